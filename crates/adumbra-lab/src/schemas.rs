//! Schemas of the JSON that comparisons, benchmarks and the report write. `docs/json.md` is generated from them.

use schemars::{JsonSchema, Schema, SchemaGenerator};

use crate::bench::{ao, bake, blur, fast, gpu, hrsm, lookup, peers, tree, verify};
use crate::paper_report::Record;
use adumbra_compare::report::Report;

/// One JSON document.
#[derive(Clone, Debug)]
pub struct Described {
    /// Command that writes it.
    pub command: &'static str,
    /// File that it writes.
    pub file: &'static str,
    /// Its schema. References point to definitions of the generator.
    pub schema: Schema,
}

/// Documents of `adumbra compare`, of every benchmark, and of the report.
pub fn documents(generator: &mut SchemaGenerator) -> Vec<Described> {
    fn described<T: JsonSchema>(
        generator: &mut SchemaGenerator,
        command: &'static str,
        file: &'static str,
    ) -> Described {
        Described { command, file, schema: T::json_schema(generator) }
    }
    vec![
        described::<Report>(generator, "adumbra compare", "report.json"),
        described::<bake::Document>(generator, "adumbra-lab bench bake", "bake.json"),
        described::<fast::Document>(generator, "adumbra-lab bench bake --suite fast", "fast.json"),
        described::<verify::Document>(generator, "adumbra-lab bench verify", "verify.json"),
        described::<tree::Document>(generator, "adumbra-lab bench tree", "tree.json"),
        described::<Vec<Report>>(generator, "adumbra-lab bench shadows", "shadows.json"),
        described::<hrsm::Document>(generator, "adumbra-lab bench hrsm", "hrsm.json"),
        described::<blur::Document>(generator, "adumbra-lab bench blur", "blur.json"),
        described::<ao::Document>(generator, "adumbra-lab bench ao", "ao.json"),
        described::<peers::Document>(generator, "adumbra-lab bench peers", "peers.json"),
        described::<lookup::Document>(generator, "adumbra-lab bench lookup", "lookup.json"),
        described::<gpu::Document>(generator, "adumbra-lab bench gpu", "gpu-ADAPTER.json"),
        described::<Record>(generator, "adumbra-lab report", "report.json"),
    ]
}
