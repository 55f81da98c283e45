//! Surfaces with holes: how much light a file lets through them, compared with rays through the same
//! textures.

use adumbra::query::receiver;
use adumbra::{Filter, ShadowFile, Sun};
use adumbra_bake::{Bake, BakeOptions, FrameChoice, Size};
use adumbra_scene::{
    AlphaMode, GeneratedKind, LoadOptions, Material, Mesh, Pixels, Scene, Texture, Wrap, generate, load,
    random::Random,
};
use adumbra_testing::{add_quad, scene_file, scene_of, shared};
use adumbra_truth::trace::{Ray, TraceOptions, Tracer};
use adumbra_truth::verify::{
    Class, LightAnswers, Sampler, Solids, SurfaceSampler, Verification, Verifier, VerifyOptions,
};

const UP: [f64; 3] = [0.0, 1.0, 0.0];
/// Height of level cards above the ground.
const HEIGHT: f32 = 4.0;
/// Side of a level card.
const SIDE: f32 = 6.0;

/// A ground, and above it a mesh of cards that are cut by a texture.
fn cut_by(texture: Texture, cards: Mesh) -> Scene {
    let half = 40.0;
    let mut ground = Mesh::default();
    add_quad(&mut ground, [[-half, 0.0, half], [half, 0.0, half], [half, 0.0, -half], [-half, 0.0, -half]]);
    let triangles = cards.triangles.len();
    let mut scene = scene_of(vec![ground, Mesh { triangle_materials: vec![1; triangles], ..cards }]);
    scene.materials.push(Material {
        alpha: AlphaMode::Mask { cutoff: 0.5 },
        texture: Some(0),
        ..Material::opaque("cut", [1.0; 4])
    });
    scene.textures.push(texture);
    scene
}

/// A texture of one row of texels, opaque where `is_opaque(texel)`.
fn row(texels: u32, wrap: Wrap, is_opaque: impl Fn(u32) -> bool) -> Texture {
    let alphas = (0..texels).map(|t| if is_opaque(t) { 255 } else { 0 }).collect();
    let pixels = Pixels::Alpha(alphas);
    Texture { name: "row".to_owned(), width: texels, height: 1, pixels, wrap: [wrap; 2], nearest: true }
}

/// Returns the world position of a point on level card `number` of `count`. The cards are side by side along
/// x, each rotated about its centre.
fn on_card([x, z]: [f32; 2], angle: f32, number: usize, count: usize) -> [f32; 3] {
    let (sin, cos) = angle.to_radians().sin_cos();
    let middle = 1.5 * SIDE * (number as f32 - 0.5 * (count - 1) as f32);
    [middle + x * cos + z * sin, HEIGHT, z * cos - x * sin]
}

/// Level cards turned by these angles, degrees, whose texture repeats every `period_world` along their x.
fn level_cards(angles: &[f32], period_world: f32) -> Mesh {
    let mut cards = Mesh::default();
    let half = 0.5 * SIDE;
    let corners = [[-half, half], [half, half], [half, -half], [-half, -half]];
    for (number, &angle) in angles.iter().enumerate() {
        add_quad(&mut cards, corners.map(|corner| on_card(corner, angle, number, angles.len())));
        cards.uvs.extend(corners.map(|[x, z]| [(x + half) / period_world, z / period_world]));
    }
    cards
}

/// The bars of [`level_cards`] whose texture is opaque in the first `width_world` of each period, as
/// geometry.
fn level_bars(angles: &[f32], period_world: f32, width_world: f32) -> Mesh {
    let mut bars = Mesh::default();
    let half = 0.5 * SIDE;
    for (number, &angle) in angles.iter().enumerate() {
        let mut low = -half;
        while low < half {
            let high = (low + width_world).min(half);
            let corners = [[low, half], [high, half], [high, -half], [low, -half]];
            add_quad(&mut bars, corners.map(|corner| on_card(corner, angle, number, angles.len())));
            low += period_world;
        }
    }
    bars
}

/// Returns the mean light on the ground in the middle of the shadow of card `number` of `count`, according to
/// the files and according to rays.
fn light_below<const N: usize>(
    files: [&ShadowFile; N],
    tracer: &Tracer<'_>,
    number: usize,
    count: usize,
) -> ([f64; N], f64) {
    const POINTS: u32 = 4096;
    let samplers = files.map(|file| file.sampler(Filter::Nearest));
    let sun = files[0].grid.sun.towards();
    let (mut sums, mut lit) = ([0.0; N], 0.0);
    for i in 0..POINTS {
        // Steps of the golden ratio do not coincide with the period of any bars.
        let along = [0.618_033_988_75 * f64::from(i), f64::from(i) / f64::from(POINTS)].map(f64::fract);
        // These points are on the card whatever its rotation.
        let [x, z] = along.map(|c| 0.65 * SIDE * (c as f32 - 0.5));
        let card = on_card([0.0; 2], 0.0, number, count);
        let card = [card[0] + x, card[1], z].map(f64::from);
        let p: [f64; 3] = std::array::from_fn(|a| card[a] - sun[a] / sun[1] * f64::from(HEIGHT));
        let ray = Ray { origin: p, direction: sun, t_min: 1e-3, t_max: f64::INFINITY };
        for (sum, sampler) in sums.iter_mut().zip(&samplers) {
            *sum += f64::from(sampler.visibility(p, Some(UP)));
        }
        lit += f64::from(u8::from(!tracer.occluded(&ray)));
    }
    (sums.map(|sum| sum / f64::from(POINTS)), lit / f64::from(POINTS))
}

fn baked(scene: &Scene, size: Size) -> ShadowFile {
    let sun = Sun::from_angles(205.0, 55.0).expect("above the horizon");
    let options = BakeOptions::new(sun, size).with(|o| o.frame = FrameChoice::Light);
    Bake::with_options(scene, &options).in_memory().expect("a small bake fits")
}

fn verify(scene: &Scene, file: &ShadowFile) -> Verification {
    let tracer = Tracer::build(scene, TraceOptions::default());
    let solids = Solids::of(scene);
    let sun = file.grid.sun.towards();
    let sampler = Sampler::Surface(SurfaceSampler::new(scene, &solids, sun, false));
    let answers = LightAnswers::of(file, file.sampler(Filter::Nearest));
    Verifier::new(&answers, &tracer, &solids).run(&sampler, &VerifyOptions { samples: 40_000, seed: 3 })
}

#[test]
fn masked_bars_pass_as_much_light_as_rays_and_geometry() {
    let angles = [0.0, 10.0, 22.5, 30.0, 45.0, 60.0, 67.5, 90.0];
    let width_world = 0.2;
    let mut most = 0.0_f64;
    // Bars that are as wide as the gaps, of one texel of the texture and of eight, and bars a quarter as wide
    // as the period.
    for (texels, opaque, widths_texels) in [(2, 1, [1.0, 3.0]), (16, 8, [1.5, 8.0]), (32, 8, [1.0, 2.0])] {
        let period_world = width_world * texels as f32 / opaque as f32;
        let texture = || row(texels, Wrap::Repeat, |t| t < opaque);
        let masked = cut_by(texture(), level_cards(&angles, period_world));
        let mut solid = cut_by(texture(), level_bars(&angles, period_world, width_world));
        solid.meshes[1].triangle_materials.fill(0);
        let tracer = Tracer::build(&masked, TraceOptions::default());
        for width_texels in widths_texels {
            let size = Size::VoxelSize(f64::from(width_world) / width_texels);
            let files = [&masked, &solid].map(|scene| baked(scene, size));
            for (number, angle) in angles.iter().enumerate() {
                let files = [&files[0], &files[1]];
                let ([by_mask, by_bars], expected) = light_below(files, &tracer, number, angles.len());
                let [from_bars, from_rays] = [by_mask - by_bars, by_mask - expected].map(f64::abs);
                let case = format!("{opaque} of {texels}, {width_texels} texels wide, {angle}°");
                assert!(from_bars < 0.02, "{case}: {by_mask:.3} by the mask, {by_bars:.3} by bars");
                assert!(from_rays < 0.025, "{case}: {by_mask:.3} by the mask, {expected:.3} by rays");
                most = most.max(from_bars).max(from_rays);
            }
            let [mask, bars] = [(&masked, &files[0]), (&solid, &files[1])].map(|(s, file)| verify(s, file));
            assert!(mask.holds() && bars.holds(), "{opaque} of {texels}, {width_texels}: {mask:?} {bars:?}");
        }
    }
    eprintln!("at most {most:.3} apart");
}

#[test]
fn layers_of_leaves_pass_as_much_light_as_rays() {
    // Half of the texels, at random, are opaque.
    let mut random = 1_u32;
    let mut alpha = |_| {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        if random >> 31 == 0 { 0 } else { 255 }
    };
    let pixels = Pixels::Alpha((0..64 * 64).map(&mut alpha).collect());
    let wrap = [Wrap::Repeat; 2];
    let leaves = Texture { name: "leaves".to_owned(), width: 64, height: 64, pixels, wrap, nearest: false };
    let mut cards = Mesh::default();
    for (layer, angle) in [12.0, 47.0, 81.0].into_iter().enumerate() {
        let mut one = level_cards(&[angle, angle + 15.0], 1.5);
        one.positions.iter_mut().for_each(|p| p[1] += 0.2 * layer as f32);
        let first = cards.positions.len() as u32;
        cards.triangles.extend(one.triangles.iter().map(|corners| corners.map(|v| v + first)));
        cards.positions.extend(one.positions);
        cards.uvs.extend(one.uvs);
    }
    let scene = cut_by(leaves, cards);
    let tracer = Tracer::build(&scene, TraceOptions::default());
    // From texels that are half as large as the holes to texels that hold several.
    for voxel_size in [0.012, 0.03, 0.08] {
        let file = baked(&scene, Size::VoxelSize(voxel_size));
        for number in [0, 1] {
            let ([found], expected) = light_below([&file], &tracer, number, 2);
            let case = format!("{voxel_size}: {found:.3} instead of {expected:.3}");
            assert!((0.05..0.3).contains(&expected) && (found - expected).abs() < 0.02, "{case}");
        }
    }
}

/// Cards that stand on the ground along x, one behind the other, each with a part of the texture from
/// `u[0]` to `u[1]`, and from v = 1 at its foot to 0 at its tip.
fn standing_cards(u: [f32; 2]) -> Mesh {
    let mut cards = Mesh::default();
    for number in 0..40 {
        let (x, z) = (-20.0 + 4.3 * (number % 9) as f32, -18.0 + 0.9 * number as f32);
        add_quad(&mut cards, [[x, 0.0, z], [x + 2.0, 0.0, z + 0.7], [x + 2.0, 1.5, z + 0.7], [x, 1.5, z]]);
        cards.uvs.extend([[u[0], 1.0], [u[1], 1.0], [u[1], 0.0], [u[0], 0.0]]);
    }
    cards
}

#[test]
fn cards_cast_only_their_part_of_the_texture() {
    // The left half is clear.
    let texture = row(64, Wrap::Repeat, |t| t >= 32);
    let scene = cut_by(texture, standing_cards([0.0, 0.499]));
    for resolution in [256, 512, 1024, 2048] {
        let file = baked(&scene, Size::Resolution(resolution));
        let sampler = file.sampler(Filter::Nearest);
        for i in 0..40_000 {
            let along = [0.618_033_988_75 * f64::from(i), f64::from(i) / 40_000.0].map(f64::fract);
            let p = [40.0 * along[0] - 20.0, 0.0, 40.0 * along[1] - 20.0];
            assert!(sampler.visibility(p, Some(UP)) == 1.0, "{p:?} at {resolution}");
        }
    }
}

#[test]
fn grass_casts_alike_with_repeating_and_clamped_textures() {
    // Blades that are opaque at the root and end before the tip.
    let grass = |wrap| {
        let alphas = (0..64 * 16).map(|t: u32| if t / 64 > 2 + t % 64 * 7 % 11 { 255 } else { 0 });
        let pixels = Pixels::Alpha(alphas.collect());
        let texture =
            Texture { name: "grass".to_owned(), width: 64, height: 16, pixels, wrap, nearest: false };
        cut_by(texture, standing_cards([0.0, 1.0]))
    };
    let [repeats, ends] = [[Wrap::Repeat; 2], [Wrap::Repeat, Wrap::Clamp]].map(grass);
    for resolution in [512, 1024] {
        let [one, other] =
            [&repeats, &ends].map(|scene| verify(scene, &baked(scene, Size::Resolution(resolution))));
        for v in [&one, &other] {
            assert!(v.holds(), "{v:?}");
        }
        let wrong = |v: &Verification| v.class(Class::Interior).wrong() + v.class(Class::Edge).misplaced;
        assert!(wrong(&one) <= wrong(&other) + 2, "{one:?} and {other:?}");
    }
}

/// The differences between filtered look-ups on the ground and the mean of rays over the filter's square.
#[derive(Debug)]
struct FilteredError {
    rmse: f64,
    mean: f64,
}

/// Returns the errors of a filter of `width` × `width` at random points on the ground: the highest opaque
/// surface that faces up.
fn filtered_error(scene: &Scene, tracer: &Tracer<'_>, file: &ShadowFile, width: u32) -> FilteredError {
    const POINTS: usize = 20_000;
    /// Strata of the square, along each axis.
    const STRATA: u32 = 16;
    const RAYS: u32 = STRATA * STRATA;
    let (grid, bounds) = (file.grid, scene.bounds());
    let sun = grid.sun.towards();
    let sampler = file.sampler(Filter::try_from(width).expect("a filter"));
    let mut random = Random::new(1, 0);
    let (mut squares, mut sum, mut points) = (0.0, 0.0, 0);
    while points < POINTS {
        let [x, z] = [0, 2].map(|a| bounds.min[a] + random.unit() * (bounds.max[a] - bounds.min[a]));
        let top = bounds.max[1] + 1.0;
        let down = Ray { origin: [x, top, z], direction: [0.0, -1.0, 0.0], t_min: 0.0, t_max: f64::INFINITY };
        let mut highest: Option<(f64, [f64; 3])> = None;
        tracer.for_each_hit(&down, |hit| {
            let is_opaque = scene.materials[hit.material as usize].alpha == AlphaMode::Opaque;
            if is_opaque && hit.normal[1] > 0.5 && highest.is_none_or(|(y, _)| top - hit.t > y) {
                highest = Some((top - hit.t, hit.normal));
            }
        });
        let Some((y, normal)) = highest else { continue };
        let p = [x, y, z];
        let gradient = receiver(&grid, &file.settings.bias, p, Some(normal)).gradient;
        let center = grid.to_grid(p);
        let lit = (0..RAYS).filter(|ray| {
            let [dx, dy] = [ray % STRATA, ray / STRATA].map(|stratum| {
                f64::from(width) * ((f64::from(stratum) + random.unit()) / f64::from(STRATA) - 0.5)
            });
            let along = center[2] + gradient[0] * dx + gradient[1] * dy;
            let q = grid.to_world([center[0] + dx, center[1] + dy, along]);
            // Start above the surface, so that curved ground does not block its own rays.
            let lift = (0.5 + 0.5 * f64::from(width)) * grid.voxel_size;
            let origin = std::array::from_fn(|a| q[a] + lift * sun[a]);
            !tracer.occluded(&Ray { origin, direction: sun, t_min: 0.0, t_max: f64::INFINITY })
        });
        let difference =
            f64::from(sampler.visibility(p, Some(normal))) - lit.count() as f64 / f64::from(RAYS);
        squares += difference * difference;
        sum += difference;
        points += 1;
    }
    FilteredError { rmse: (squares / POINTS as f64).sqrt(), mean: sum / POINTS as f64 }
}

/// Bakes a scene at two resolutions and checks filtered look-ups. `before` holds the root mean square errors
/// of an earlier rule, which used half of a texel's area in place of its centre.
fn assert_filtered(scene: &Scene, resolutions: [u64; 2], before: [f64; 2]) {
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).expect("above the horizon");
    let tracer = Tracer::build(scene, TraceOptions::default());
    for (resolution, before) in resolutions.into_iter().zip(before) {
        let size = Size::Resolution(resolution);
        let options = BakeOptions::new(sun, size).with(|o| o.frame = FrameChoice::Light);
        let file = Bake::with_options(scene, &options).in_memory().expect("it fits");
        let error = filtered_error(scene, &tracer, &file, 5);
        eprintln!("at {resolution}, 5 × 5: {error:.4?}");
        assert!(error.rmse < before && error.mean.abs() < 0.005, "{resolution}: {error:?}");
    }
}

#[test]
#[ignore = "slow: bakes a forest of a million leaves"]
fn filtered_look_ups_in_a_forest_are_near_the_mean_of_rays() {
    assert_filtered(&generate(GeneratedKind::Forest, 1), [1024, 2048], [0.0490, 0.0403]);
}

#[test]
#[ignore = "slow: a real scene"]
fn shared_filtered_look_ups_below_real_trees_are_near_the_mean_of_rays() {
    let Some(scenes) = shared("scenes") else { return };
    let scene = load(&scene_file(&scenes, "alpine-2"), &LoadOptions::default()).expect("a good scene");
    assert_filtered(&scene, [2048, 4096], [0.0420, 0.0321]);
}
