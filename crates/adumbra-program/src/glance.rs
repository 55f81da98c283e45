//! The line that describes a scene as a person would see it, and warnings about unusual scenes.

use std::fmt;
use std::path::Path;

use adumbra::{Bounds, Sun};
use adumbra_scene::{Scene, pattern_of};
use adumbra_truth::glance::{EYE_HEIGHT_WORLD, Glance, Stray, shadowed_share};
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::quoted;
use crate::output::format_number;

/// Voxels larger than this share of the box that holds nearly all triangles show little of the scene.
const LARGEST_VOXEL: f64 = 0.01;
/// Above this share of standing places in shadow, a scene is unusual.
const MOSTLY_DARK: f64 = 0.95;

/// Looks at a scene, and warns on stderr if it is unusual under a sun. `path` is the scene's.
pub fn look(scene: &Scene, path: &Path, sun: Sun, ignore_alpha: bool) -> Glance {
    let glance = Glance::of(scene, sun.towards(), ignore_alpha);
    warn_of_darkness(path, &glance);
    glance
}

/// What a person would see of a scene at a glance.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct AtAGlance {
    /// Share of the ground that is in shadow by rays, 0 to 1. The ground is the lowest surface that faces up.
    /// Null if there is no place on it.
    ground_in_shadow: Option<f64>,
    /// Share of the places that are in shadow 1.7 above the ground.
    standing_in_shadow: Option<f64>,
    /// Things that hide the sun from nearly everything else, by name, as a sky dome does. Empty if there are
    /// none.
    hide_the_sun: Vec<String>,
    /// Longest side of the box that holds nearly all triangles, world units.
    side: f64,
    /// The node that reaches far beyond that box. Null if none does.
    stray: Option<String>,
}

impl AtAGlance {
    /// Converts the results of a glance.
    pub fn of(glance: &Glance) -> Self {
        Self {
            ground_in_shadow: shadowed_share(&glance.ground),
            standing_in_shadow: shadowed_share(&glance.standing),
            hide_the_sun: glance.hider.iter().flat_map(|hider| hider.names.clone()).collect(),
            side: glance.spread.side_world(),
            stray: glance.spread.stray.as_ref().map(|stray| stray.name.clone()),
        }
    }
}

fn percent(share: Option<f64>) -> String {
    share.map_or_else(|| "none".to_owned(), |share| format!("{:.0} %", 100.0 * share))
}

impl fmt::Display for AtAGlance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [ground, standing] = [self.ground_in_shadow, self.standing_in_shadow].map(percent);
        write!(f, "in shadow: {ground} of the ground, {standing} of the places {EYE_HEIGHT_WORLD} above it")
    }
}

/// Warns of a scene in which one thing hides the sun from all others, or nearly everything is in shadow.
fn warn_of_darkness(scene: &Path, glance: &Glance) {
    let scene = scene.display();
    if let Some(hider) = &glance.hider {
        let quoted: Vec<String> = hider.names.iter().map(|name| format!("{name:?}")).collect();
        let options: Vec<String> = hider.names.iter().map(|name| exclude(name)).collect();
        crate::note!(
            "warning: {scene}: {} hides the sun from {:.0} % of everything else; if it is a sky or a backdrop, leave it out with {}",
            quoted.join(" with "),
            100.0 * hider.share,
            options.join(" ")
        );
    } else if let Some(share) = shadowed_share(&glance.standing).filter(|&share| share >= MOSTLY_DARK) {
        crate::note!(
            "warning: {scene}: {:.0} % of the places where people stand are in shadow; is this the scene and the sun that are meant?",
            100.0 * share
        );
    }
}

/// Warns on stderr of voxels that are large compared with the scene, and of the cause.
pub fn warn_of_large_voxels(scene: &Path, glance: &Glance, voxel_size: f64) {
    let spread = &glance.spread;
    let side = spread.side_world();
    if !(voxel_size > LARGEST_VOXEL * side) {
        return;
    }
    let scene = scene.display();
    let large = format!(
        "voxels of {} are larger than a hundredth of the box that holds nearly all of the scene, {}",
        format_number(voxel_size),
        format_number(side)
    );
    let Bounds { min, max } = spread.bounds_to_give();
    let bounds = listed(min.iter().chain(&max));
    match &spread.stray {
        Some(Stray { name, reaches, is_around: false }) => crate::note!(
            "warning: {scene}: {large}; {name:?} reaches {}: leave it out with {}, or give --bounds={bounds}",
            listed(reaches),
            exclude(name)
        ),
        Some(Stray { name, reaches, is_around: true }) => crate::note!(
            "warning: {scene}: {large}; {name:?} is around all of it and reaches {}: give --bounds={bounds}",
            listed(reaches)
        ),
        None => crate::note!("warning: {scene}: {large}; give a higher --resolution"),
    }
}

/// Returns the option that leaves out the nodes of a name.
fn exclude(name: &str) -> String {
    format!("--exclude {}", quoted(&pattern_of(name)))
}

/// Numbers with commas between them, without zeros at their ends.
fn listed<'n>(numbers: impl IntoIterator<Item = &'n f64>) -> String {
    let short = |number: &f64| {
        let text = format!("{number:.6}");
        let text = text.trim_end_matches('0').trim_end_matches('.');
        if text == "-0" { "0".to_owned() } else { text.to_owned() }
    };
    numbers.into_iter().map(short).collect::<Vec<_>>().join(",")
}
