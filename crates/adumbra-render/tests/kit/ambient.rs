//! What ambient occlusion reads, drawn or made up, and its answers on GPU and CPU.

use adumbra::camera::Camera;
use adumbra_render::frame::frame;
use adumbra_render::occlusion::twin::{Ambient, Surfaces, Twin, estimate};
use adumbra_render::occlusion::{OcclusionInput, OcclusionPasses, OcclusionSettings};
use adumbra_render::readback::read_floats;
use adumbra_render::{Answer, Baked, Gpu, Renderer, Shot, build};
use adumbra_shaders::layout::Frame;

use super::buffers::Buffers;

/// What a camera sees.
pub(crate) struct Seen {
    pub(crate) frame: Frame,
    pub(crate) depth: Vec<f32>,
    pub(crate) normal: Vec<[f32; 3]>,
    depth_view: wgpu::TextureView,
    normal_view: wgpu::TextureView,
}

/// `issao` with numbers that no tuning moves: what surrounds an estimator is tested on the same noise for ever.
const ISSAO: &str =
    "issao:reading=1:lambda=1:phi=0.5:psi=0.01:zcap=5:sigma=0.01:before=nothing:relation=equal";

/// Settings by their text, with a radius in world units; `issao` stands for [`ISSAO`].
pub(crate) fn settings(text: &str, radius_world: f64) -> OcclusionSettings {
    let text = text.replacen("issao", ISSAO, 1);
    OcclusionSettings::from_spec(&text.parse().unwrap(), radius_world).unwrap()
}

impl Seen {
    /// A frame of a scene.
    pub(crate) fn drawn(renderer: &mut Renderer, camera: Camera, number: u32) -> Self {
        let none = build(renderer.gpu(), &"none".parse().unwrap(), Baked::default()).unwrap();
        let mut none = renderer.prepare(none).unwrap();
        let shot = Shot { camera, towards_sun: super::sun(), number };
        renderer.draw(&shot, &mut none, Answer::Visibility).unwrap();
        Self::now(renderer, &shot)
    }

    /// The frame that was drawn last. On the GPU it is there until the next is drawn.
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

    /// Any depths from `near_world` to `far_world`, a part of them sky, with any normals, as `frame` sees them.
    pub(crate) fn random(gpu: &Gpu, frame: Frame, [near_world, far_world]: [f32; 2], mut seed: u32) -> Self {
        let mut next = || {
            seed = seed.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            let word = (seed >> ((seed >> 28) + 4) ^ seed).wrapping_mul(277_803_737);
            (word >> 22 ^ word) as f32 / 4_294_967_296.0
        };
        let size = [frame.size[0], frame.size[1]];
        let pixels = 0..size[0] * size[1];
        let k = frame.depth_to_z;
        let depth: Vec<f32> = pixels
            .clone()
            .map(|_| {
                let z = near_world + (far_world - near_world) * next();
                // From z (c + e d) = a + b d.
                if next() < 0.1 { 0.0 } else { (k[0] - k[2] * z) / (k[3] * z - k[1]) }
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

    /// Pixels.
    pub(crate) fn size(&self) -> [usize; 2] {
        [self.frame.size[0], self.frame.size[1]].map(|s| s as usize)
    }

    /// Distance along the camera's forward direction; none for the sky.
    pub(crate) fn view_depth(&self, at: usize) -> Option<f32> {
        let (k, d) = (self.frame.depth_to_z, self.depth[at]);
        (d > 0.0).then(|| (k[0] + k[1] * d) / (k[2] + k[3] * d))
    }

    /// The next frame of ambient visibility on the GPU.
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

    /// A first frame of it on the CPU.
    pub(crate) fn on_cpu(&self, settings: &OcclusionSettings) -> Vec<f32> {
        visibility(&Twin::new(*settings).ambient(&self.surfaces()))
    }

    /// What the estimator would give with a great many taps: its mean over every turn of the noise.
    pub(crate) fn without_noise(&self, settings: &OcclusionSettings) -> Vec<f32> {
        let many = OcclusionSettings { reuse: true, samples: 64, ..*settings };
        let mut sum = vec![0.0; self.depth.len()];
        for turn in 0..16 {
            let [width, height, ..] = self.frame.size;
            let frame = Frame { size: [width, height, turn, 0], ..self.frame };
            let turned = estimate(&many, &Surfaces { frame, ..self.surfaces() });
            sum.iter_mut().zip(turned).for_each(|(s, a)| *s += a[0] / 16.0);
        }
        sum
    }

    /// Largest difference of a first frame's visibility, GPU from CPU.
    pub(crate) fn difference(&self, gpu: &Gpu, settings: &OcclusionSettings) -> f32 {
        let found = self.on_gpu(gpu, &mut OcclusionPasses::new(gpu, *settings));
        largest(&found, &self.on_cpu(settings))
    }
}

pub(crate) fn visibility(ambient: &[Ambient]) -> Vec<f32> {
    ambient.iter().map(|a| a[0]).collect()
}

/// Largest difference.
pub(crate) fn largest(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    differences.inspect(|d| assert!(d.is_finite())).fold(0.0, f32::max)
}

/// Root mean square difference.
pub(crate) fn rms(a: &[f32], b: &[f32]) -> f64 {
    assert_eq!(a.len(), b.len());
    let sum: f64 = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum();
    (sum / a.len() as f64).sqrt()
}
