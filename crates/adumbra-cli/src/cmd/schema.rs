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

use super::{bake, bake_watch, cache, convert, demo, farm, generate, info, inspect, sunlight, verify};

const DESCRIBED: &[Described] = &[
    Described::of::<generate::Generated>("generate", "the scene that was written"),
    Described::of::<inspect::Inspected>("inspect", "what a scene contains"),
    Described::of::<bake::Printed>(
        "bake",
        "the bake, with --regions those of all regions, with --sun-path or --suns the path, or with --dry-run the forecast",
    ),
    Described::of::<bake_watch::BakedAgain>("bake watch", "a line of bake --watch"),
    Described::of::<progress::Line>("progress", "a line of bake --progress json, on stderr"),
    Described::of::<info::Printed>(
        "info",
        "what a shadow file contains, a manifest of regions, or a sun path",
    ),
    Described::of::<verify::Printed>("verify", "the comparison with rays"),
    Described::of::<query::Answered>("query", "the look-ups"),
    Described::of::<cache::CacheContents>("cache info", "the contents of a bake cache"),
    Described::of::<cache::Pruned>("cache prune", "what was removed from a bake cache, and what is left"),
    Described::of::<farm::Planned>("plan", "the plan that was written"),
    Described::of::<farm::Tiled>("tile", "the parts that were baked"),
    Described::of::<farm::Linked>("link", "the shadow file that was written"),
    Described::of::<convert::Converted>("convert", "the file that was written"),
    Described::of::<sunlight::SunHoursFound>("sun-hours", "the hours of the points in short"),
    Described::of::<sunlight::HoursFile>("sun-hours file", "a .json of sun-hours"),
    Described::of::<sunlight::SkyFound>("sky", "the skies of the points in short"),
    Described::of::<sunlight::SkyFile>("sky file", "a .json of sky"),
    #[cfg(feature = "render")]
    Described::of::<render::Printed>("render", "the picture, or the list of several"),
    #[cfg(feature = "render")]
    Described::of::<Report>("compare", "the comparison; its report.json is the same"),
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
