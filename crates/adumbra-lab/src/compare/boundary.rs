//! How much finer a hybrid map is where the true shadow has an edge.
//!
//! *At an edge* lies a compared pixel that a ray's answer changes within one coarsest texel of, in the light's plane
//! ([`EdgeProbe::is_clear`] does not hold there). A look-up that ends `level` levels above the finest of `merges` + 1 has texels
//! 2^(`merges` - `level`) times finer than the coarsest. The gain is the mean of that over the pixels at edges, less 1.
//! A map of the coarsest size alone gains 0.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::truth::{EdgeProbe, Surfaces};

/// Every so many compared pixels are asked whether an edge is near.
pub const EDGE_SAMPLE: usize = 7;

/// What a hybrid map's levels add at the edges of the true shadow.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BoundaryGain {
    /// Pixels at edges that were asked about.
    pub pixels: u64,
    /// Mean of coarsest texel edge over texel edge, less 1: 0 where all look-ups end at the coarsest level.
    pub gain: f64,
    /// Share of the pixels whose look-up ends at the finest level.
    pub at_finest: f64,
}

/// Of one pixel in [`EDGE_SAMPLE`] that is `judged`, those within `radius_world` of an edge of the true shadow. Cost: up to 17 rays each.
pub fn pixels_at_edges(
    probe: &EdgeProbe<'_, '_>,
    surfaces: &Surfaces,
    judged: impl Fn(usize) -> bool,
    radius_world: f64,
) -> Vec<usize> {
    let asked: Vec<usize> = (0..surfaces.pixels()).filter(|&i| judged(i)).step_by(EDGE_SAMPLE).collect();
    let at_edge =
        |&i: &usize| !probe.is_clear(surfaces.position[i], surfaces.normal[i].map(f64::from), radius_world);
    asked.into_par_iter().filter(at_edge).collect()
}

/// The gain at `pixels` of a map of `merges` + 1 levels; `levels` holds [`adumbra_render::Answer::Level`] of each pixel of the picture.
/// Pixels beside the map are left out; all zero where none is left.
pub fn boundary_gain(levels: &[f32], merges: u32, pixels: &[usize]) -> BoundaryGain {
    let ends = pixels.iter().filter_map(|&i| levels.get(i)).filter(|level| **level >= 0.0);
    let (mut count, mut finest, mut finer) = (0_u64, 0_u64, 0.0);
    for &level in ends {
        count += 1;
        finest += u64::from(level < 0.5);
        finer += (f64::from(merges) - f64::from(level)).exp2() - 1.0;
    }
    let whole = count.max(1) as f64;
    BoundaryGain { pixels: count, gain: finer / whole, at_finest: finest as f64 / whole }
}

#[cfg(test)]
mod tests {
    use adumbra::camera::{Camera, Projection};
    use adumbra::scene::{GeneratedKind, generate};

    use super::*;
    use crate::truth::{SunShape, TruthTracer};

    #[test]
    fn boundary_gain_of_known_levels() {
        let levels = [0.0, 1.0, 2.0, 2.0, -1.0, 0.0];
        let g = boundary_gain(&levels, 2, &[0, 1, 2, 3, 4]);
        assert_eq!((g.pixels, g.at_finest), (4, 0.25));
        assert!((g.gain - (3.0 + 1.0) / 4.0).abs() < 1e-12);
        assert_eq!(boundary_gain(&levels, 2, &[2, 3]).gain, 0.0);
        assert_eq!(boundary_gain(&levels, 2, &[4]).pixels, 0);
    }

    #[test]
    fn pixels_at_edges_are_few_and_more_within_a_larger_radius() {
        let mut scene = generate(GeneratedKind::Ball, 1);
        scene.stand_on_ground(4.0).unwrap();
        let truth = TruthTracer::build(&scene, false);
        let projection = Projection::Perspective { fov_degrees: 45.0 };
        let camera =
            Camera { eye: [-4.0, 5.0, 4.0], target: [-0.5, -1.0, 0.0], projection, width: 140, height: 105 };
        let surfaces = truth.surfaces(&camera);
        let towards_sun = crate::vector::normalize([0.5, 0.8, 0.35]);
        let probe = EdgeProbe::new(&truth, towards_sun);
        let judged = |i: usize| surfaces.is_valid(i) && surfaces.n_dot_l(i, towards_sun) > 0.1;
        let near = pixels_at_edges(&probe, &surfaces, judged, 0.05);
        let wide = pixels_at_edges(&probe, &surfaces, judged, 0.2);
        let asked = (0..surfaces.pixels()).filter(|&i| judged(i)).count() / EDGE_SAMPLE;
        assert!(near.len() > 3 && near.len() < wide.len() && wide.len() < asked / 2, "{near:?} of {asked}");
        // An edge lies between what is lit and what is not: the wide band holds both.
        let factors = truth.factors(&surfaces, towards_sun, SunShape::Hard);
        let lit = wide.iter().filter(|&&i| factors[i] > 0.5).count();
        assert!(lit > 0 && lit < wide.len());
    }
}
