//! The sky from points.

use std::f64::consts::{PI, TAU};
use std::sync::atomic::{AtomicUsize, Ordering};

use adumbra::grid::vec3::dot;
use adumbra_bake::{Progress, Watch};
use adumbra_truth::trace::Tracer;
use rayon::prelude::*;

use super::patches::Patches;
use crate::error::{Error, Result};
use crate::points::{Facing, Receiver};

/// Number of points that one thread takes at a time.
const BLOCK: usize = 256;

/// The sky from a point.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyView {
    /// One bit for each patch, 1 if its middle is seen. Byte k has the patches from 8 k on, the first in its
    /// lowest bit.
    pub bits: Vec<u8>,
    /// Share of the light of a uniform sky that arrives: 1 on an open plain, about a half on an open wall.
    pub sky_view_factor: f64,
    /// Share of the sky's solid angle above the horizon that is hidden, also by the surface itself: 0 on an
    /// open plain.
    pub shade_fraction: f64,
}

impl SkyView {
    /// Whether the point sees the middle of a patch.
    pub fn sees(&self, patch: usize) -> bool {
        self.bits.get(patch / 8).is_some_and(|byte| byte >> (patch % 8) & 1 == 1)
    }
}

/// Finds for each point the patches of the sky that it sees, on the current rayon pool. A sheet is seen from
/// above, and a point in space measures light as a level surface does. Progress counts blocks of points.
/// Cost: a ray for each patch that is on the surface's side.
///
/// # Errors
/// Returns [`Error::Interrupted`] if `watch` asks for it.
pub fn sky_views(
    tracer: &Tracer<'_>,
    receivers: &[Receiver],
    patches: &Patches,
    watch: Watch<'_>,
) -> Result<Vec<SkyView>> {
    let total = receivers.len().div_ceil(BLOCK);
    let done = AtomicUsize::new(0);
    let view_bytes = (size_of::<SkyView>() + patches.len().div_ceil(8)) as u64;
    let block = |points: &[Receiver]| {
        if watch.cancel.load(Ordering::Relaxed) {
            return Err(Error::Interrupted);
        }
        let views: Vec<SkyView> = points.iter().map(|point| view(tracer, point, patches)).collect();
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        (watch.progress)(Progress {
            done,
            total,
            texels_per_unit: BLOCK as u64,
            result_bytes: (done * BLOCK) as u64 * view_bytes,
        });
        Ok(views)
    };
    Ok(receivers.par_chunks(BLOCK).map(block).collect::<Result<Vec<_>>>()?.concat())
}

fn view(tracer: &Tracer<'_>, point: &Receiver, patches: &Patches) -> SkyView {
    let point = seen_from_above(point);
    let normal = point.normal().unwrap_or([0.0, 1.0, 0.0]);
    let mut bits = vec![0; patches.len().div_ceil(8)];
    let (mut light, mut open) = (0.0, 0.0);
    for (patch, &center) in patches.centers().iter().enumerate() {
        if !point.faces(center) || !tracer.sun_visible(point.origin(1.0), center) {
            continue;
        }
        bits[patch / 8] |= 1 << (patch % 8);
        light += dot(patches.weights()[patch], normal).max(0.0);
        open += patches.solid_angles()[patch];
    }
    SkyView { bits, sky_view_factor: light / PI, shade_fraction: (1.0 - open / TAU).max(0.0) }
}

/// Turns a sheet's normal up.
fn seen_from_above(point: &Receiver) -> Receiver {
    let facing = match point.facing {
        Facing::Both(normal) if normal[1] < 0.0 => Facing::Front(normal.map(|c| -c)),
        Facing::Both(normal) => Facing::Front(normal),
        other => other,
    };
    Receiver { facing, ..*point }
}

#[cfg(test)]
mod tests {
    use adumbra_testing::{cuboid, scene_of};
    use adumbra_truth::trace::TraceOptions;

    use super::*;

    fn views(high: f32, points: &[([f64; 3], Facing)]) -> Vec<[SkyView; 2]> {
        let scene = scene_of(vec![
            cuboid([-9000.0, -1.0, -9000.0], [9000.0, 0.0, 9000.0]),
            cuboid([-9000.0, 0.0, -1.0], [9000.0, high, 0.0]),
        ]);
        let tracer = Tracer::build(&scene, TraceOptions::default());
        let of = |&(p_world, facing)| Receiver { p_world, facing, lift_world: 1e-3 };
        let points: Vec<Receiver> = points.iter().map(of).collect();
        let see = |patches: Patches| sky_views(&tracer, &points, &patches, Watch::none()).unwrap();
        let [coarse, fine] = [see(Patches::tregenza()), see(Patches::reinhart_577())];
        coarse.into_iter().zip(fine).map(|(a, b)| [a, b]).collect()
    }

    const UP: [f64; 3] = [0.0, 1.0, 0.0];

    #[test]
    fn open_plain_sees_the_whole_sky() {
        for facing in [Facing::Front(UP), Facing::Both([0.0, -1.0, 0.0]), Facing::Space] {
            let both = &views(0.5, &[([0.0, 1.0, 500.0], facing)])[0];
            for (view, count) in both.iter().zip([145, 577]) {
                assert!((view.sky_view_factor - 1.0).abs() < 1e-12, "{view:?}");
                assert!(view.shade_fraction.abs() < 1e-12);
                assert_eq!((0..600).filter(|&patch| view.sees(patch)).count(), count);
            }
        }
    }

    /// Beside an endless wall, half of the sky is hidden, and half of the light of a level surface.
    #[test]
    fn point_beside_an_endless_wall_sees_half_of_the_sky() {
        for view in &views(9000.0, &[([0.0, 0.0, 0.01], Facing::Front(UP))])[0] {
            // A patch counts fully if its middle is in the plane of the wall.
            assert!((view.sky_view_factor - 0.5).abs() < 0.04, "{}", view.sky_view_factor);
            assert!((view.shade_fraction - 0.5).abs() < 0.04, "{}", view.shade_fraction);
            assert!(!view.sees(0));
        }
    }

    #[test]
    fn point_on_a_wall_sees_half_of_the_sky() {
        for view in &views(100.0, &[([0.0, 50.0, 0.0], Facing::Front([0.0, 0.0, 1.0]))])[0] {
            assert!((view.sky_view_factor - 0.5).abs() < 0.01, "{}", view.sky_view_factor);
            assert!((view.shade_fraction - 0.5).abs() < 0.04, "{}", view.shade_fraction);
        }
    }
}
