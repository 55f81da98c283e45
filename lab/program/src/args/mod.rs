//! The command-line options of `adumbra-lab`.

mod bench;
mod compare;
mod dag;
#[cfg(test)]
mod defaults;
mod report;
mod tree;
mod tune;

use adumbra_compare::verbs::render::after_help;
use adumbra_program::schemas::SchemaArgs;
pub use bench::{
    BenchAo, BenchBake, BenchBlur, BenchGpu, BenchHrsm, BenchLookup, BenchPeers, BenchShadows, BenchStream,
    BenchTree, BenchVerb, BenchVerify, SuiteArg,
};
use clap::Subcommand;
pub use compare::{Compare, CubeArgs, Render};
pub use dag::{DagBake, DagInfo, DagVerb};
pub use report::Report;
pub(crate) use report::SECTIONS;
pub use tree::{TreeBake, TreeExport, TreeImport, TreeInfo, TreeQuery, TreeVerb, TreeVerify};
pub use tune::TuneAo;

/// What `adumbra-lab` does.
#[derive(Subcommand)]
pub enum Verb {
    /// Run a benchmark and write its results as tables: bakes, trees, shadows compared with ray-traced truth,
    /// and more
    #[command(after_help = "Example: adumbra-lab bench bake --scenes scenes -o docs/bench")]
    Bench {
        /// The benchmark.
        #[command(subcommand)]
        what: BenchVerb,
    },
    /// Repeat the measurements of every paper, and write one page that shows the published results next to
    /// ours; exit code 1 if a section failed
    #[command(
        after_help = "Writes report.html, which needs no other file and no network, and report.json. Finished measurements stay in the folder \
        even if a later one fails.\n\n\
        Example: adumbra-lab report -o report\n\nExample: adumbra-lab report --full --scenes scenes --truth truth -o report"
    )]
    Report(Report),
    /// Search for the best parameters of every ambient-occlusion estimator on the eight scenes, and record
    /// them
    #[command(
        after_help = "Run it in the repository root: the record that it writes is compiled into the program.\n\n\
        Example: adumbra-lab tune-ao --scenes scenes --only issao\n\n\
        Example: adumbra-lab tune-ao --scenes scenes --variant issao:reading=1 --variant issao:reading=2"
    )]
    TuneAo(TuneAo),
    /// Bake, describe and look up files of the 2021 paper: world-aligned trees
    Tree {
        /// What to do.
        #[command(subcommand)]
        what: TreeVerb,
    },
    /// Bake, describe and look up files of the 2014 paper: graphs of voxels
    Dag {
        /// What to do.
        #[command(subcommand)]
        what: DagVerb,
    },
    /// Compare techniques with ray-traced truth, as adumbra compare does, the papers' techniques too
    #[command(
        after_help = "Example: adumbra-lab compare city.glb --camera street --shadow voxel-cubes --shadow csm -o compared"
    )]
    Compare(Compare),
    /// Draw a scene, as adumbra render does, with the papers' techniques too
    #[command(after_help = after_help("adumbra-lab", crate::TECHNIQUES))]
    Render(Render),
    /// Print the JSON Schema of what a verb prints or writes as JSON; without a name, list those that have
    /// one
    #[command(after_help = "Example: adumbra-lab schema tree bake")]
    Schema(SchemaArgs),
}
