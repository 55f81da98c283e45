//! `adumbra schema`: the JSON Schema of what a verb prints.

#[cfg(feature = "render")]
use adumbra_compare::camera_file::CameraFile;
#[cfg(feature = "render")]
use adumbra_compare::report::Report;
#[cfg(feature = "render")]
use adumbra_compare::verbs::render;
use adumbra_program::exit::Outcome;
use adumbra_program::schemas::{Described, SchemaArgs};
use adumbra_program::{progress, query};
use adumbra_truth::verify::Verification;

#[cfg(feature = "render")]
use super::demo;
use super::{bake, cache, convert, export, generate, info, inspect};

const DESCRIBED: &[Described] = &[
    Described::of::<generate::Generated>("generate", "the scene that was written"),
    Described::of::<inspect::Inspected>("inspect", "what a scene contains"),
    Described::of::<bake::Printed>("bake", "the bake, or with --dry-run its forecast"),
    Described::of::<progress::Line>("progress", "a line of bake --progress json, on stderr"),
    Described::of::<info::FileInfo>("info", "what a shadow file contains"),
    Described::of::<Verification>("verify", "the comparison with rays"),
    Described::of::<query::Answered>("query", "the look-ups"),
    Described::of::<export::WebExported>("export", "the file that was written"),
    Described::of::<cache::CacheContents>("cache info", "what a folder of bake --cache has"),
    Described::of::<cache::Pruned>("cache prune", "what was removed from a folder of bake --cache"),
    Described::of::<convert::Converted>("pack", "the coded file that was written"),
    Described::of::<convert::Converted>("unpack", "the raw file that was written"),
    #[cfg(feature = "render")]
    Described::of::<render::Printed>("render", "the picture, or the list of several"),
    #[cfg(feature = "render")]
    Described::of::<Report>("compare", "the comparison; its report.json is the same"),
    #[cfg(feature = "render")]
    Described::of::<demo::Shown>("demo", "what the demo made"),
    #[cfg(feature = "render")]
    Described::of::<CameraFile>("camera", "a camera that view saves, and that compare --camera takes"),
];

pub(crate) fn run(args: &SchemaArgs) -> Outcome {
    args.run(DESCRIBED)
}

#[cfg(test)]
mod tests {
    use adumbra_testing::undescribed_fields;

    use super::*;

    #[test]
    fn every_field_is_described() {
        for described in DESCRIBED {
            let undescribed = undescribed_fields(&described.schema());
            assert!(undescribed.is_empty(), "{}: without a comment: {undescribed:?}", described.name);
        }
    }
}
