//! Frame times and shimmer along a camera path.

use adumbra::camera::Camera;
use adumbra_render::{Answer, FrameTimes, Renderer, Shot, Stage, SurfacePoint};

use super::{Contender, Judge, MIN_N_DOT_L};
use crate::error::Result;
use crate::paths::CameraPath;
use crate::report::{Cheaper, PathReport, PathRow};
use crate::shimmer::ShimmerCount;
use crate::truth::EdgeProbe;

/// Points are followed from a picture of so many pixels across.
const POINTS_ACROSS: u32 = 128;
/// A point is near an edge within so many pixels of the frames, in the light's plane.
const EDGE_PIXELS: f64 = 4.0;

/// Walks `path` with pictures of `width` × `height` pixels: every contender draws every frame once, and fixed points are followed from each
/// frame to the next. Contenders without pipelines are left out.
///
/// # Errors
/// What the renderer reports. Cost: the frames; besides, a frame and contender, two look-ups of about 9,000 points, and a frame 17 rays a
/// point.
pub fn walk(
    renderer: &mut Renderer,
    judge: &Judge<'_, '_>,
    path: &CameraPath,
    [width, height]: [u32; 2],
    contenders: &mut [Contender],
) -> Result<PathReport> {
    let shot = |frame: u32| Shot {
        camera: path.camera(frame, width, height),
        towards_sun: judge.towards_sun,
        number: 0,
    };
    let points: Vec<Followed> =
        (1..path.frames()).map(|f| follow(judge, &shot(f - 1).camera, &shot(f).camera)).collect();
    let mut techniques = Vec::new();
    for contender in contenders.iter_mut() {
        let Some(prepared) = &mut contender.prepared else { continue };
        // The first frame warms up.
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
    }
    let cheaper = cheaper(&techniques);
    Ok(PathReport { frames: path.frames(), techniques, cheaper })
}

/// Each voxel technique beside the first cascades.
fn cheaper(techniques: &[PathRow]) -> Vec<Cheaper> {
    let Some(csm) = techniques.iter().find(|t| t.name.to_lowercase().starts_with("csm")) else {
        return Vec::new();
    };
    let beside = |voxel: &PathRow| {
        let frames = voxel.gpu_ms.iter().zip(&csm.gpu_ms);
        let fewer = frames.clone().filter(|(v, c)| v < c).count();
        let share = fewer as f64 / frames.len().max(1) as f64;
        Cheaper { voxel: voxel.name.clone(), csm: csm.name.clone(), share }
    };
    techniques.iter().filter(|t| t.name.to_lowercase().starts_with("voxel")).map(beside).collect()
}

/// Points that two consecutive cameras have in view.
struct Followed {
    points: Vec<SurfacePoint>,
    near_edge: Vec<bool>,
}

fn follow(judge: &Judge<'_, '_>, from: &Camera, to: &Camera) -> Followed {
    let height = (POINTS_ACROSS * from.height).div_ceil(from.width).max(1);
    let surfaces = judge.truth.surfaces(&Camera { width: POINTS_ACROSS, height, ..*from });
    let next = to.view();
    let inside = |p: [f64; 3]| {
        next.pixel(p).is_some_and(|[x, y]| {
            (0.0..f64::from(to.width)).contains(&x) && (0.0..f64::from(to.height)).contains(&y)
        })
    };
    let kept: Vec<usize> = (0..surfaces.pixels())
        .filter(|&i| {
            surfaces.is_valid(i)
                && surfaces.n_dot_l(i, judge.towards_sun) > MIN_N_DOT_L
                && inside(surfaces.position[i])
        })
        .collect();
    let view = from.view();
    let pixel = 2.0 * view.half[1] / f64::from(from.height);
    let probe = EdgeProbe::new(judge.truth, judge.towards_sun);
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
    fn cheaper_counts_frames_beside_the_first_cascades() {
        let rows = [
            row("voxel:filter=9", &[1.0, 2.0, 3.0, 4.0]),
            row("csm", &[2.0, 2.0, 4.0, 9.0]),
            row("csm-vsm", &[0.0; 4]),
        ];
        let found = cheaper(&rows);
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].csm.as_str(), found[0].share), ("csm", 0.75));
        assert!(cheaper(&rows[..1]).is_empty());
    }
}
