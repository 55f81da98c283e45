//! Compares normals with rays through the texels' centres, and depth drawn with normals with depth drawn
//! alone.

use adumbra::Sun;
use adumbra_scene::{AlphaMode, Camera, GeneratedKind, Projection, Scene, generate};
use adumbra_truth::trace::{Ray, TraceOptions, Tracer};

use super::*;
use crate::gpu::GpuOptions;
use crate::maps::DepthPrecision;
use crate::maps::cascades::{LayerFit, depth_range, scene_layer};
use crate::maps::layers::Layer;
use crate::maps::textures::DepthTextures;
use crate::octahedral;
use crate::readback::{read_depth, read_texture};
use crate::scene::SceneOptions;
use crate::technique::FrameInput;

const SIZE: u32 = 256;

/// One layer drawn over a scene. `normals` is empty if they were not requested.
struct Drawn {
    fit: LayerFit,
    depth: Vec<f32>,
    normals: Vec<[u8; 2]>,
    bytes: u64,
}

/// Draws a layer. With `movers`, static casters are cached and copied, and the movers are drawn over the
/// copy.
fn draw(gpu: &Gpu, scene: &Scene, movers: Option<&Scene>, sun: &Sun, options: DepthPassOptions) -> Drawn {
    let upload = |scene| SceneBuffers::new(gpu, scene, SceneOptions::default()).unwrap();
    let (buffers, movers) = (upload(scene), movers.map(upload));
    let extent = buffers.light_extent(sun);
    let fit = scene_layer(&extent, depth_range(&extent, None), buffers.lattice_world(), SIZE, 2.0);
    let projection = Projection::Orthographic { height_world: 1.0 };
    let camera = Camera { eye: [9.0, 5.0, -3.0], target: [0.0; 3], projection, width: 1, height: 1 };
    let view = camera.view();
    let input = FrameInput {
        gpu,
        camera: &camera,
        view: &view,
        anchor_world: camera.eye,
        towards_sun: sun.towards(),
        scene: &buffers,
        movers: movers.as_ref(),
        bounds: buffers.bounds(),
        number: 0,
    };
    let pass = DepthPass::new(gpu, options);
    let live = DepthTextures::new(gpu, "test::live", SIZE, 1, options).unwrap();
    let kept = movers.is_some().then(|| DepthTextures::new(gpu, "test::kept", SIZE, 1, options).unwrap());
    let mut layer = Layer::new(gpu, &pass);
    layer.prepare(&input, &fit, true, kept.is_some());
    let mut encoder = gpu.encoder("test");
    assert!(layer.encode(&input, &pass, &mut encoder, 0, &live, kept.as_ref()));
    gpu.queue.submit([encoder.finish()]);
    let depth = read_depth(gpu, &live.all.texture, 0).unwrap();
    let normals = live.normals.as_ref().map(|(all, _)| read_texture(gpu, &all.texture, 0, 0).unwrap());
    let normals = normals.unwrap_or_default().as_chunks::<2>().0.to_vec();
    Drawn { fit, depth, normals, bytes: live.bytes() }
}

fn gpu() -> Gpu {
    Gpu::request(&GpuOptions::default()).unwrap()
}

fn with_normals(depth: DepthPrecision) -> DepthPassOptions {
    DepthPassOptions { format: depth.format(), normals: true }
}

/// Depth of the first caster on the ray through a position in texels, and its normal flipped towards the sun.
fn traced(tracer: &Tracer<'_>, fit: &LayerFit, p_texels: [f64; 2]) -> Option<(f64, [f64; 3])> {
    let [u, v] = [0, 1].map(|a| fit.first(a) + p_texels[a] * fit.texel_world);
    let [right, down, away] = fit.axes;
    let origin = std::array::from_fn(|a| u * right[a] + v * down[a] + fit.depth_world[0] * away[a]);
    let hit = tracer.nearest_blocker(&Ray { origin, direction: away, t_min: 0.0, t_max: f64::INFINITY })?;
    let facing: f64 = (0..3).map(|a| hit.normal[a] * away[a]).sum();
    let normal = if facing > 0.0 { hit.normal.map(|c| -c) } else { hit.normal };
    Some((hit.t / (fit.depth_world[1] - fit.depth_world[0]), normal))
}

fn degrees_apart(bytes: [u8; 2], normal: [f64; 3]) -> f64 {
    let found = octahedral::decode(bytes).map(f64::from);
    let chord: f64 = (0..3).map(|a| (found[a] - normal[a]) * (found[a] - normal[a])).sum::<f64>().sqrt();
    2.0 * libm::asin(0.5 * chord).to_degrees()
}

#[test]
fn normals_are_those_of_the_nearest_caster() {
    let gpu = gpu();
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    for kind in [GeneratedKind::City, GeneratedKind::Primitives, GeneratedKind::Landscape] {
        let scene = generate(kind, 7);
        let tracer = Tracer::build(&scene, TraceOptions::default());
        let Drawn { fit, depth, normals, .. } =
            draw(&gpu, &scene, None, &sun, with_normals(DepthPrecision::Bits32));
        let (mut casters, mut compared, mut at_edges, mut worst) = (0, 0, 0, 0.0_f64);
        for (at, (&depth, &bytes)) in depth.iter().zip(&normals).enumerate() {
            assert_eq!(depth == 1.0, bytes == octahedral::NONE, "{kind:?} {at}: {depth} {bytes:?}");
            let center = [at as u32 % SIZE, at as u32 / SIZE].map(|c| f64::from(c) + 0.5);
            let Some((truth, normal)) = traced(&tracer, &fit, center) else { continue };
            casters += 1;
            // At a silhouette, rounding decides which of two surfaces covers the centre.
            if (f64::from(depth) - truth).abs() > 1e-5 {
                continue;
            }
            compared += 1;
            let mut degrees = degrees_apart(bytes, normal);
            if degrees > 1.0 {
                // At a crease, rounding decides between two surfaces of equal depth.
                at_edges += 1;
                let beside = [[0.02, 0.0], [-0.02, 0.0], [0.0, 0.02], [0.0, -0.02]]
                    .map(|d| [center[0] + d[0], center[1] + d[1]]);
                let others = beside.into_iter().filter_map(|p| traced(&tracer, &fit, p));
                degrees = others.map(|(_, n)| degrees_apart(bytes, n)).fold(degrees, f64::min);
            }
            worst = worst.max(degrees);
        }
        println!("{kind:?}: {compared} of {casters} compared, {at_edges} at creases, worst {worst} degrees");
        assert!(casters > 10_000 && compared * 100 > casters * 98, "{kind:?}: {compared} of {casters}");
        assert!(at_edges * 100 < compared, "{kind:?}: {at_edges}");
        assert!(worst < 1.0, "{kind:?}: {worst}");
    }
}

#[test]
fn depth_is_the_same_with_normals_as_without() {
    let gpu = gpu();
    let sun = Sun::from_direction([-0.3, 0.6, 0.4]).unwrap();
    let scene = generate(GeneratedKind::City, 7);
    for precision in [DepthPrecision::Bits32, DepthPrecision::Bits16] {
        let both = draw(&gpu, &scene, None, &sun, with_normals(precision));
        let alone = DepthPassOptions { normals: false, ..with_normals(precision) };
        let alone = draw(&gpu, &scene, None, &sun, alone);
        assert!(alone.normals.is_empty());
        assert_eq!(both.bytes - alone.bytes, u64::from(2 * SIZE * SIZE));
        let apart = both.depth.iter().zip(&alone.depth).filter(|(b, a)| (*b - *a).abs() > 1e-6).count();
        assert_eq!(apart, 0, "{precision:?}");
    }
}

#[test]
fn cut_parts_of_masked_casters_write_no_depth_or_normal() {
    let gpu = gpu();
    let sun = Sun::from_direction([0.2, 0.9, 0.1]).unwrap();
    let mut scene = generate(GeneratedKind::Primitives, 7);
    let opaque = draw(&gpu, &scene, None, &sun, with_normals(DepthPrecision::Bits32));
    for (alpha, is_there) in [(0.8, true), (0.2, false)] {
        for material in &mut scene.materials {
            material.alpha = AlphaMode::Mask { cutoff: 0.5 };
            material.base_color[3] = alpha;
        }
        let masked = draw(&gpu, &scene, None, &sun, with_normals(DepthPrecision::Bits32));
        if is_there {
            assert!(masked.normals == opaque.normals && masked.depth == opaque.depth);
        } else {
            assert!(masked.normals.iter().all(|&n| n == octahedral::NONE));
            assert!(masked.depth.iter().all(|&d| d == 1.0));
        }
    }
}

#[test]
fn movers_are_drawn_over_kept_normals() {
    let gpu = gpu();
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    let (city, mut balls) = (generate(GeneratedKind::City, 7), generate(GeneratedKind::Spheres, 3));
    balls.instances.iter_mut().for_each(|i| i.world_from_mesh[1][3] += 20.0);
    let options = with_normals(DepthPrecision::Bits32);
    let still = draw(&gpu, &city, None, &sun, options);
    let moved = draw(&gpu, &city, Some(&balls), &sun, options);
    let texels = still.depth.iter().zip(&moved.depth).zip(still.normals.iter().zip(&moved.normals));
    let mut covered = 0;
    for ((before, after), (old, new)) in texels {
        assert!(after <= before && (after < before || old == new));
        covered += usize::from(after < before && old != new);
    }
    assert!(covered > 100, "{covered}");
}
