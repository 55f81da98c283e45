//! `adumbra-lab schema`: the JSON Schema of what a verb prints, and of the files that benchmarks and the
//! report write.

use adumbra_compare::camera_file::CameraFile;
use adumbra_compare::report::Report;
use adumbra_compare::verbs::render;
use adumbra_program::exit::Outcome;
use adumbra_program::schemas::{Described, SchemaArgs};
use adumbra_program::verify::VerifiedScene;
use adumbra_program::{progress, query};

use crate::bench::{ao, bake, blur, fast, gpu, hrsm, lookup, peers, stream, tree, verify};
use crate::dag::{bake::DagBaked, info::DagContents};
use crate::paper_report::Record;
use crate::tree::{bake::TreeBaked, export::Exported, import::Imported, info::TreeContents};

const DESCRIBED: &[Described] = &[
    Described::of::<bake::BakeResults>("bench bake", "bake.json"),
    Described::of::<fast::FastResults>("bench bake fast", "fast.json, of bench bake --suite fast"),
    Described::of::<verify::VerifyResults>("bench verify", "verify.json"),
    Described::of::<tree::TreeResults>("bench tree", "tree.json"),
    Described::of::<Vec<Report>>("bench shadows", "shadows.json"),
    Described::of::<hrsm::HybridResults>("bench hrsm", "hrsm.json"),
    Described::of::<blur::BlurResults>("bench blur", "blur.json"),
    Described::of::<ao::AoResults>("bench ao", "ao.json"),
    Described::of::<peers::PeerResults>("bench peers", "peers.json"),
    Described::of::<lookup::LookUpResults>("bench lookup", "lookup.json"),
    Described::of::<stream::StreamResults>("bench stream", "stream-SCENE.json"),
    Described::of::<gpu::GpuResults>("bench gpu", "gpu-ADAPTER.json"),
    Described::of::<Record>("report", "report.json of the papers' measurements"),
    Described::of::<Report>("compare", "the comparison; its report.json is the same"),
    Described::of::<render::Printed>("render", "the picture, or the list of several"),
    Described::of::<DagBaked>("dag bake", "the bake of a graph"),
    Described::of::<DagContents>("dag info", "what a graph file contains"),
    Described::of::<VerifiedScene>("dag verify", "the comparison with rays"),
    Described::of::<query::Answered>("dag query", "the look-ups"),
    Described::of::<TreeBaked>("tree bake", "the bake of a tree"),
    Described::of::<TreeContents>("tree info", "what a tree file contains"),
    Described::of::<VerifiedScene>("tree verify", "the comparison with rays"),
    Described::of::<query::Answered>("tree query", "the look-ups"),
    Described::of::<Exported>("tree export", "the pages that were written"),
    Described::of::<Imported>("tree import", "the file that was made of pages"),
    Described::of::<progress::Line>("progress", "a line of --progress json, on stderr"),
    Described::of::<CameraFile>("camera", "a camera that compare --camera takes"),
];

/// Runs the verb.
///
/// # Errors
///
/// Returns an error for an unknown name. It lists the known ones.
pub fn run(args: &SchemaArgs) -> Outcome {
    args.run(DESCRIBED)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use adumbra_testing::{assert_described, undescribed_fields};

    use super::*;

    #[test]
    fn every_field_is_described() {
        for described in DESCRIBED {
            let undescribed = undescribed_fields(&described.schema());
            assert!(undescribed.is_empty(), "{}: without a comment: {undescribed:?}", described.name);
        }
    }

    #[test]
    fn recorded_results_fit_their_schemas() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/recorded");
        let mut recorded = 0;
        for described in DESCRIBED {
            let file = described.about.split([',', ' ']).next().unwrap_or_default();
            if !described.name.starts_with("bench ") || file == "gpu-ADAPTER.json" {
                continue;
            }
            for scene in if file.contains("SCENE") { &["box-city-51k", "kaykit_city_121"][..] } else { &[""] }
            {
                let text = std::fs::read_to_string(folder.join(file.replace("SCENE", scene))).unwrap();
                assert_described(&described.schema(), &serde_json::from_str(&text).unwrap());
                recorded += 1;
            }
        }
        assert_eq!(recorded, 12);
    }
}
