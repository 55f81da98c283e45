//! Input of ambient occlusion, drawn or synthetic, and its results on GPU and CPU.

use adumbra_render::frame::frame;
use adumbra_render::occlusion::twin::{Ambient, Surfaces, Twin, estimate};
use adumbra_render::occlusion::{OcclusionInput, OcclusionPasses, OcclusionSettings};
use adumbra_render::readback::read_floats;
use adumbra_render::{Answer, Gpu, Renderer, Shot, TechniqueFiles, build};
use adumbra_scene::Camera;
use adumbra_shaders::layout::{DepthToZ, Frame};

use super::buffers::Buffers;

/// The G-buffer of a frame.
pub(crate) struct GBuffer {
    pub(crate) frame: Frame,
    pub(crate) depth: Vec<f32>,
    pub(crate) normal: Vec<[f32; 3]>,
    depth_view: wgpu::TextureView,
    normal_view: wgpu::TextureView,
}

/// `issao` with fixed numbers, independent of tuned defaults, so that tests of the passes around the
/// estimator always see the same noise.
const ISSAO: &str =
    "issao:reading=1:lambda=1:phi=0.5:psi=0.01:zcap=5:sigma=0.01:before=nothing:relation=equal";

/// Parses settings, with a radius in world units. `issao` is replaced by [`ISSAO`].
pub(crate) fn settings(text: &str, radius_world: f64) -> OcclusionSettings {
    let text = text.replacen("issao", ISSAO, 1);
    OcclusionSettings::from_spec(&text.parse().unwrap(), radius_world).unwrap()
}

impl GBuffer {
    /// Draws a frame of a scene.
    pub(crate) fn drawn(renderer: &mut Renderer, camera: Camera, number: u32) -> Self {
        let none = build(renderer.gpu(), &"none".parse().unwrap(), TechniqueFiles::default()).unwrap();
        let mut none = renderer.prepare(none).unwrap();
        let shot = Shot { camera, towards_sun: super::sun(), number };
        renderer.draw(&shot, &mut none, Answer::Visibility).unwrap();
        Self::now(renderer, &shot)
    }

    /// The frame drawn last. Its content on the GPU is valid until the next frame is drawn.
    pub(crate) fn now(renderer: &Renderer, shot: &Shot) -> Self {
        let targets = renderer.targets().unwrap();
        Self {
            frame: frame(&shot.camera, &renderer.bounds(), shot.towards_sun, shot.number),
            depth: read_floats(renderer.gpu(), &targets.depth.texture, 0, 0).unwrap(),
            normal: renderer.read_surface(shot).unwrap().normal,
            depth_view: targets.depth.view.clone(),
            normal_view: targets.normal.view.clone(),
        }
    }

    /// Random view depths from `near_world` to `far_world`, a tenth of them sky, and random normals, as seen
    /// by `frame`.
    pub(crate) fn random(gpu: &Gpu, frame: Frame, [near_world, far_world]: [f32; 2], mut seed: u32) -> Self {
        let mut next = || {
            seed = seed.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            let word = (seed >> ((seed >> 28) + 4) ^ seed).wrapping_mul(277_803_737);
            (word >> 22 ^ word) as f32 / 4_294_967_296.0
        };
        let size = frame.size;
        let pixels = 0..size[0] * size[1];
        let k = frame.depth_to_z;
        let depth: Vec<f32> = pixels
            .clone()
            .map(|_| {
                let z = near_world + (far_world - near_world) * next();
                if next() < 0.1 { 0.0 } else { stored_depth(k, z) }
            })
            .collect();
        let normal: Vec<[f32; 3]> = pixels
            .map(|_| {
                let n = [0, 1, 2].map(|a| 1.6 * next() - 0.8 - frame.forward[a]);
                let length = n.iter().map(|c| c * c).sum::<f32>().sqrt();
                n.map(|c| c / length)
            })
            .collect();
        let Buffers { depth: drawn, normal: normals } = Buffers::new(gpu, size, &depth, &normal);
        Self { frame, depth, normal, depth_view: drawn.view, normal_view: normals.view }
    }

    pub(crate) fn surfaces(&self) -> Surfaces<'_> {
        Surfaces { frame: self.frame, depth: &self.depth, normal: &self.normal }
    }

    /// Width and height, pixels.
    pub(crate) fn size(&self) -> [usize; 2] {
        self.frame.size.map(|s| s as usize)
    }

    /// Distance along the camera's forward direction; `None` for the sky.
    pub(crate) fn view_depth(&self, at: usize) -> Option<f32> {
        let (k, d) = (self.frame.depth_to_z, self.depth[at]);
        (d > 0.0).then(|| k.view_depth(d))
    }

    /// Computes the next frame of ambient visibility on the GPU.
    pub(crate) fn on_gpu(&self, gpu: &Gpu, passes: &mut OcclusionPasses) -> Vec<f32> {
        let input = OcclusionInput { frame: &self.frame, depth: &self.depth_view, normal: &self.normal_view };
        passes.prepare(gpu, &self.frame);
        let mut encoder = gpu.encoder("test");
        passes.encode_surfaces(gpu, &mut encoder, &input);
        passes.encode_estimate(gpu, &mut encoder, &input);
        passes.encode_history(gpu, &mut encoder, &input);
        passes.encode_filter(gpu, &mut encoder, &input);
        gpu.finish(encoder.finish()).unwrap();
        passes.read(gpu).unwrap()
    }

    /// Computes a first frame of ambient visibility on the CPU.
    pub(crate) fn on_cpu(&self, settings: &OcclusionSettings) -> Vec<f32> {
        visibility(&Twin::new(*settings).ambient(&self.surfaces()))
    }

    /// The estimate with a great many taps: the mean over every rotation of the noise.
    pub(crate) fn without_noise(&self, settings: &OcclusionSettings) -> Vec<f32> {
        let many = OcclusionSettings { reuse: true, samples: 64, ..*settings };
        let mut sum = vec![0.0; self.depth.len()];
        for turn in 0..16 {
            let [width, height, ..] = self.frame.size;
            let frame = Frame { size: [width, height], number: turn, ..self.frame };
            let turned = estimate(&many, &Surfaces { frame, ..self.surfaces() });
            sum.iter_mut().zip(turned).for_each(|(s, a)| *s += a[0] / 16.0);
        }
        sum
    }

    /// Checks a first frame's visibility.
    pub(crate) fn assert_same(&self, gpu: &Gpu, settings: &OcclusionSettings, what: &str) {
        let found = self.on_gpu(gpu, &mut OcclusionPasses::new(gpu, *settings));
        assert_same(gpu, &found, &self.on_cpu(settings), what);
    }
}

/// Checks that the GPU's values are the CPU's, within 2e-3.
///
/// A software adapter computes all of them as the CPU does. The sines, quotients and roots of a GPU may be
/// off in their last bits (WGSL, *Accuracy of Concrete Floating Point Expressions*), so that a sample at an
/// edge falls on its other side. There, one value of 500 may be apart, and one of 50 with `depth=plain`.
pub(crate) fn assert_same(gpu: &Gpu, found: &[f32], expected: &[f32], what: &str) {
    let worst = largest(found, expected);
    let apart = found.iter().zip(expected).filter(|(a, b)| (*a - *b).abs() >= 2e-3).count();
    // With plain differences of depth no texel beside a pixel of a slope is close to it. The nearest in depth
    // is taken then, but on a plane two are equally far, and rounding decides.
    let share = if what.contains("depth=plain") { 50 } else { 500 };
    let allowed = if gpu.is_software() { 0 } else { found.len() / share };
    assert!(apart <= allowed, "{what}: {apart} of {} are apart, by up to {worst}", found.len());
}

/// Variants of estimators that their names alone do not cover.
pub(crate) const VARIANTS: [&str; 8] = [
    "ssao:tangent=0",
    "issao:lambda=1:phi=0.5:levels=off",
    "issao:lambda=1:phi=0.5:reading=1",
    "issao:lambda=1:phi=0.5:reading=2",
    "issao:lambda=1:phi=0.5:attenuation=off",
    "issao:lambda=1:phi=0.5:before=nothing",
    "issao:lambda=1:phi=0.5:relation=free",
    "issao:preset=fig3",
];

/// Returns the stored depth for a view depth.
pub(crate) fn stored_depth(k: DepthToZ, z: f32) -> f32 {
    (k.numerator - k.denominator * z) / (k.denominator_slope * z - k.numerator_slope)
}

pub(crate) fn visibility(ambient: &[Ambient]) -> Vec<f32> {
    ambient.iter().map(|a| a[0]).collect()
}

/// Returns the largest absolute difference.
pub(crate) fn largest(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    differences.inspect(|d| assert!(d.is_finite())).fold(0.0, f32::max)
}

/// Returns the root mean square difference.
pub(crate) fn rms(a: &[f32], b: &[f32]) -> f64 {
    assert_eq!(a.len(), b.len());
    let sum: f64 = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    (sum / a.len() as f64).sqrt()
}
