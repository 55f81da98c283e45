//! Frame times and shimmer along a camera path.

use adumbra_render::{Answer, FrameTimes, Reads, Renderer, Shot, Stage, SurfacePoint, TechniqueSpec};
use adumbra_scene::Camera;

use super::{Contender, MIN_N_DOT_L, Reference};
use crate::error::Result;
use crate::paths::CameraPath;
use crate::report::{Cheaper, PathReport, PathRow};
use crate::shimmer::ShimmerCount;
use crate::truth::EdgeProbe;

/// Width in pixels of the picture that the followed points are taken from.
const POINTS_ACROSS: u32 = 128;
/// Points within this distance of an edge are near it. In pixels of the frames, measured in the light's
/// plane.
const EDGE_PIXELS: f64 = 4.0;

/// Measures frame times and shimmer along `path` with pictures of `width` × `height` pixels.
///
/// Every contender draws every frame once, and fixed points are followed from each frame to the next.
/// Contenders without pipelines are skipped.
///
/// Cost: the frames, two look-ups of about 9,000 points per frame and contender, and 17 rays per point and
/// frame.
///
/// # Errors
/// Returns the errors of the renderer.
pub fn walk(
    renderer: &mut Renderer,
    reference: &Reference<'_, '_>,
    path: &CameraPath,
    [width, height]: [u32; 2],
    contenders: &mut [Contender],
) -> Result<PathReport> {
    let shot = |frame: u32| Shot {
        camera: path.camera(frame, width, height),
        towards_sun: reference.towards_sun,
        number: 0,
    };
    let points: Vec<Followed> =
        (1..path.frames()).map(|f| follow(reference, &shot(f - 1).camera, &shot(f).camera)).collect();
    let mut techniques = Vec::new();
    let mut specs = Vec::new();
    for contender in contenders.iter_mut() {
        let Some(prepared) = &mut contender.prepared else { continue };
        // A warm-up frame, which is not timed.
        renderer.draw(&shot(0), prepared, Answer::Visibility)?;
        let times: Vec<FrameTimes> = (0..path.frames())
            .map(|f| renderer.draw(&shot(f), prepared, Answer::Visibility))
            .collect::<Result<_, _>>()?;
        let shimmer = if prepared.technique().has_screen_passes() {
            None
        } else {
            let mut count = ShimmerCount::default();
            for (frame, followed) in (1..).zip(&points) {
                let before = renderer.answer(&shot(frame - 1), prepared, &followed.points)?;
                let after = renderer.answer(&shot(frame), prepared, &followed.points)?;
                count.add(&before, &after, &followed.near_edge)?;
            }
            count.finish()
        };
        let of = |what: &dyn Fn(&FrameTimes) -> f64| times.iter().map(what).collect::<Vec<f64>>();
        techniques.push(PathRow {
            name: contender.spec.to_string(),
            gpu_ms: of(&FrameTimes::shadow),
            depth_ms: of(&|t| t.before_lookup()),
            lookup_ms: of(&|t| t.of(Stage::Lookup) + t.of(Stage::Screen)),
            wall_time: times.iter().any(|t| t.wall_time),
            shimmer,
        });
        specs.push(contender.spec.clone());
    }
    let cheaper = cheaper(&specs, &techniques);
    Ok(PathReport { frames: path.frames(), techniques, cheaper })
}

/// Compares each technique that uses a baked file with the first cascaded technique.
fn cheaper(specs: &[TechniqueSpec], techniques: &[PathRow]) -> Vec<Cheaper> {
    let rows = || specs.iter().zip(techniques);
    let Some((_, csm)) = rows().find(|(spec, _)| spec.is_cascades()) else { return Vec::new() };
    let beside = |voxel: &PathRow| {
        let frames = voxel.gpu_ms.iter().zip(&csm.gpu_ms);
        let fewer = frames.clone().filter(|(v, c)| v < c).count();
        let share = fewer as f64 / frames.len().max(1) as f64;
        Cheaper { voxel: voxel.name.clone(), csm: csm.name.clone(), share }
    };
    let is_baked = |spec: &TechniqueSpec| spec.reads() != Reads::Nothing;
    rows().filter(|(spec, _)| is_baked(spec)).map(|(_, row)| beside(row)).collect()
}

/// Points inside the view of two consecutive cameras.
struct Followed {
    points: Vec<SurfacePoint>,
    near_edge: Vec<bool>,
}

fn follow(reference: &Reference<'_, '_>, from: &Camera, to: &Camera) -> Followed {
    let height = (POINTS_ACROSS * from.height).div_ceil(from.width).max(1);
    let surfaces = reference.truth.surfaces(&Camera { width: POINTS_ACROSS, height, ..*from });
    let next = to.view();
    let inside = |p: [f64; 3]| {
        next.pixel(p).is_some_and(|[x, y]| {
            (0.0..f64::from(to.width)).contains(&x) && (0.0..f64::from(to.height)).contains(&y)
        })
    };
    let kept: Vec<usize> = (0..surfaces.pixels())
        .filter(|&i| {
            surfaces.is_valid(i)
                && surfaces.n_dot_l(i, reference.towards_sun) > MIN_N_DOT_L
                && inside(surfaces.position[i])
        })
        .collect();
    let view = from.view();
    let pixel = 2.0 * view.half[1] / f64::from(from.height);
    let probe = EdgeProbe::new(reference.truth, reference.towards_sun);
    let away = |i: usize| if view.orthographic { 1.0 } else { surfaces.view_depth[i] };
    let clear = probe.clear_pixels(&surfaces, |i| EDGE_PIXELS * pixel * away(i));
    let point = |&i: &usize| SurfacePoint {
        p_world: surfaces.position[i],
        normal: surfaces.normal[i].map(f64::from),
    };
    Followed {
        points: kept.iter().map(point).collect(),
        near_edge: kept.iter().map(|&i| !clear[i]).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(name: &str, gpu_ms: &[f64]) -> PathRow {
        let none = vec![0.0; gpu_ms.len()];
        PathRow {
            name: name.to_owned(),
            gpu_ms: gpu_ms.to_vec(),
            depth_ms: none.clone(),
            lookup_ms: none,
            wall_time: false,
            shimmer: None,
        }
    }

    #[test]
    fn cheaper_compares_frames_with_the_first_cascades() {
        let rows = [
            row("voxel:filter=9", &[1.0, 2.0, 3.0, 4.0]),
            row("csm", &[2.0, 2.0, 4.0, 9.0]),
            row("csm-vsm", &[0.0; 4]),
        ];
        let specs = rows.each_ref().map(|row| row.name.parse().unwrap());
        let found = cheaper(&specs, &rows);
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].csm.as_str(), found[0].share), ("csm", 0.75));
        assert!(cheaper(&specs[..1], &rows[..1]).is_empty());
    }
}
