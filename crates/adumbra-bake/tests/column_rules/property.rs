//! The rule itself, over random layers: a look-up finds what a ray finds, unless a blocker is within the
//! receiver's bias.

use adumbra::query::receiver;
use adumbra::{Filter, ShadowFile, Sun};
use adumbra_bake::{BakeOptions, ColumnBuilder, FrameChoice, Size};
use adumbra_scene::Scene;
use adumbra_scene::random::Random;
use adumbra_truth::trace::{Ray, TraceOptions, Tracer};
use proptest::prelude::*;

use super::model::{Model, Point, UP, bake_quietly, scene};

const VOXEL: f64 = 0.1;
const FLOOR_HALF: f64 = 4.0;
const UPPER_HALF: f64 = 2.0;
/// Depths closer than this are not distinguished, voxels: fixed-point rounding, and the bake's 1/256.
const SLACK: f64 = 1.0 / 64.0;
/// Centres this close to an outline along both axes may be covered or not, texels: corners are snapped to
/// 1/256, and open surfaces grow by as much.
const OUTLINE: f64 = 1.0 / 128.0;

/// The object above the floor.
#[derive(Clone, Copy, Debug)]
enum Upper {
    Quad,
    /// Thickness in voxels.
    Slab(f64),
    /// Thickness, height of the teeth and pitch, voxels.
    Teeth([f64; 3]),
}

#[derive(Clone, Debug)]
struct Layers {
    upper: Upper,
    /// Gap along the light, voxels.
    gap: f64,
    /// Slope of level ground to the light.
    slope: f64,
    azimuth: f64,
    /// Offset of the scene along the light, voxels.
    phase: f64,
    /// The yaw of the oblique frame; `None` = the light's frame.
    yaw_radians: Option<f64>,
    switch_within_voxels: u32,
    builder: ColumnBuilder,
    seed: u64,
}

prop_compose! {
    fn any_layers()(
        upper in prop_oneof![
            Just(Upper::Quad),
            (0.01_f64..12.0).prop_map(Upper::Slab),
            (0.2_f64..3.0, 0.5_f64..8.0, 0.7_f64..6.0).prop_map(|(t, h, p)| Upper::Teeth([t, h, p])),
        ],
        gap in 0.2_f64..12.0,
        slope in prop_oneof![Just(0.0), 0.0_f64..9.0],
        azimuth in 0.0_f64..std::f64::consts::TAU,
        phase in 0.0_f64..1.0,
        yaw_radians in prop::option::of(-3.0_f64..3.0),
        switch_within_voxels in prop_oneof![Just(0), Just(8)],
        fast in any::<bool>(),
        seed in any::<u64>(),
    ) -> Layers {
        let builder = if fast { ColumnBuilder::Fast } else { ColumnBuilder::Plain };
        Layers { upper, gap, slope, azimuth, phase, yaw_radians, switch_within_voxels, builder, seed }
    }
}

impl Layers {
    /// Builds floor and upper layer, each as its own instance.
    fn scene(&self) -> Scene {
        let cosine = 1.0 / self.slope.hypot(1.0);
        let ground = self.ground();
        let bottom = ground + self.gap * VOXEL * cosine;
        let (mut floor, mut upper) = (Model::default(), Model::default());
        floor.level_square(FLOOR_HALF, ground);
        let [low, high] = [-UPPER_HALF, UPPER_HALF];
        match self.upper {
            Upper::Quad => upper.level_square(UPPER_HALF, bottom),
            Upper::Slab(thickness) => {
                upper.cuboid([low, bottom, low], [high, bottom + thickness * VOXEL, high]);
            }
            Upper::Teeth([thickness, height, pitch]) => {
                let valleys = bottom + thickness * VOXEL;
                let levels = [bottom, valleys, valleys + height * VOXEL];
                upper.toothed_bar([low, high], levels, [low, high], pitch * VOXEL);
            }
        }
        scene(&[floor, upper])
    }

    /// Returns the height of the floor, as a vertex has it.
    fn ground(&self) -> f64 {
        f64::from((self.phase * VOXEL * self.slope.hypot(1.0)) as f32)
    }

    fn options(&self) -> BakeOptions {
        let towards = [self.slope * self.azimuth.cos(), 1.0, self.slope * self.azimuth.sin()];
        BakeOptions::new(Sun::from_direction(towards).unwrap(), Size::VoxelSize(VOXEL)).with(|o| {
            o.switch_within_voxels = self.switch_within_voxels;
            o.builder = self.builder;
            o.frame = self.yaw_radians.map_or(FrameChoice::Light, FrameChoice::ObliqueAt);
        })
    }
}

/// Whether a ray from the point that a look-up samples reaches the sun, or
/// `None` if nothing is guaranteed. `own` is the receiver's instance.
fn expected(tracer: &Tracer<'_>, baked: &ShadowFile, p: Point, own: u32) -> Option<bool> {
    let r = receiver(&baked.grid, &baked.settings.bias, p, Some(UP));
    let center = [0, 1].map(|a| r.p_grid[a].floor() + 0.5);
    let [dx, dy] = [0, 1].map(|a| center[a] - r.p_grid[a]);
    let lifted = r.p_grid[2] + r.gradient[0] * dx + r.gradient[1] * dy;
    let bias = baked.settings.bias.along_light(r.gradient[0].hypot(r.gradient[1]));
    let towards = baked.grid.sun.towards();
    let mut answers = [false; 5];
    let around = [[0.0, 0.0], [1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]];
    for (n, [ox, oy]) in around.map(|offsets| offsets.map(|o| o * OUTLINE)).into_iter().enumerate() {
        let at = |depth: f64| baked.grid.to_world([center[0] + ox, center[1] + oy, depth]);
        // From behind the plane towards the sun, up to the sampled point.
        let length = baked.grid.voxel_along_light() * (bias + 2.0 * SLACK);
        let near = Ray { origin: at(lifted + bias + SLACK), direction: towards, t_min: 0.0, t_max: length };
        let (mut covers, mut within_bias) = (false, false);
        tracer.for_each_hit(&near, |hit| {
            covers |= hit.instance == own;
            within_bias |= hit.instance != own;
        });
        if within_bias || !covers {
            return None;
        }
        let ray = Ray { origin: at(lifted), direction: towards, t_min: 0.0, t_max: f64::INFINITY };
        answers[n] = !tracer.occluded(&ray);
    }
    answers.iter().all(|lit| *lit == answers[0]).then_some(answers[0])
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, ..ProptestConfig::default() })]

    #[test]
    fn look_ups_on_layers_find_what_rays_find(layers in any_layers()) {
        let scene = layers.scene();
        let baked = bake_quietly(&scene, &layers.options());
        let tracer = Tracer::build(&scene, TraceOptions::default());
        let sampler = baked.sampler(Filter::Nearest);
        let mut random = Random::for_batch(layers.seed, 0);
        let mut any = |half: f64| half * (2.0 * random.unit() - 1.0);
        let top = match layers.upper {
            Upper::Quad => Some(0.0),
            Upper::Slab(thickness) => Some(thickness * VOXEL),
            Upper::Teeth(_) => None,
        };
        for n in 0..600 {
            let on_upper = top.filter(|_| n % 4 == 0);
            let (own, half, y) = match on_upper {
                Some(above) => {
                    let bottom = layers.gap * VOXEL / layers.slope.hypot(1.0);
                    (1, UPPER_HALF, layers.ground() + bottom + above)
                }
                None => (0, FLOOR_HALF, layers.ground()),
            };
            // Vertices are stored as 32-bit floats.
            let p = [any(half), f64::from(y as f32), any(half)];
            let Some(lit) = expected(&tracer, &baked, p, own) else { continue };
            let found = sampler.visibility(p, Some(UP)) > 0.5;
            prop_assert!(found == lit, "at {p:?}: a ray says lit = {lit}, the look-up {found}");
        }
    }
}
