//! The WGSL that `adumbra` gives an engine, for buffers, textures and streams: all answer alike. With a
//! filter they answer as the CPU does, also where a coarser level of a stream stands in.

use std::io::Cursor;
use std::time::Duration;

use adumbra::gpu::{Bindings, LookUp, Parameters, Penumbra, TexelFormat};
use adumbra::stream::{BytesSource, StreamOptions, Streamer, View};
use adumbra::{Encoding, Filter, ShadowFile, Sun};
use adumbra_bake::Bake;
use adumbra_render::gpu::Gpu;
use adumbra_scene::random::Random;
use adumbra_scene::{GeneratedKind, generate};
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{BindingResource, BufferUsages};

use crate::kit;
use crate::shade::{self, Point, shade};

/// Penumbrae at a point, with taps rotated by its number.
const SOFT: &str = "
fn visibility_of(point: u32, p_relative: vec3f, normal: vec3f) -> f32 {
    return adumbra_soft_visibility(p_relative, normal, vec2u(point, 7u));
}
";

fn buffer(gpu: &Gpu, contents: &[u8], usage: BufferUsages) -> wgpu::Buffer {
    gpu.device.create_buffer_init(&BufferInitDescriptor { label: None, contents, usage })
}

/// Returns the answers from a uniform and a storage buffer.
fn from_buffers(gpu: &Gpu, wgsl: &str, parameters: &[u8], words: &[u32], points: &[Point]) -> Vec<f32> {
    let parameters = buffer(gpu, parameters, BufferUsages::UNIFORM);
    let words = buffer(gpu, bytemuck::cast_slice(words), BufferUsages::STORAGE);
    let resources = [parameters.as_entire_binding(), words.as_entire_binding()];
    shade(&gpu.device, &gpu.queue, (wgsl, &resources), points).unwrap()
}

/// Returns a stream with the pages that a view with pixels of this size needs.
fn settled(file: &ShadowFile, pixel_world: f64) -> Streamer {
    let mut bytes = Cursor::new(Vec::new());
    file.write_to(&mut bytes, Encoding::Coded).unwrap();
    let mut streamer = Streamer::new(BytesSource(bytes.into_inner()), StreamOptions::default());
    let view = View { pixel_world, ..View::everything() };
    assert!(streamer.settle(&[view], Duration::from_secs(600), |_| ()));
    streamer
}

/// Returns the answers from the pool of a stream.
fn from_stream(
    gpu: &Gpu,
    streamer: &Streamer,
    look_up: &LookUp,
    call: &str,
    anchor: [f32; 3],
    points: &[Point],
) -> Vec<f32> {
    let levels = streamer.parameters(look_up, anchor.map(f64::from)).unwrap();
    let mut parameters: Vec<u8> = levels.iter().flat_map(|level| level.to_bytes()).collect();
    parameters.resize(8 * Parameters::BYTES, 0);
    let wgsl = streamer.wgsl(Bindings::default()) + call;
    from_buffers(gpu, &wgsl, &parameters, streamer.words(), points)
}

#[test]
fn texts_for_engines_answer_as_the_cpu_does() {
    const COUNT: usize = 5000;
    let gpu = kit::gpu();
    let scene = generate(GeneratedKind::City, 3);
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    let file = Bake::new(&scene, sun).resolution(1024).in_memory().unwrap();
    let whole = settled(&file, 0.0);
    let coarse = settled(&file, 8.0 * file.grid.voxel_size);
    let words = file.gpu().words().to_vec();
    let bounds = scene.bounds();
    let mut random = Random::for_batch(41, 0);
    let p_world: Vec<[f32; 3]> = (0..COUNT)
        .map(|_| [0, 1, 2].map(|a| (bounds.min[a] + random.unit() * (bounds.max[a] - bounds.min[a])) as f32))
        .collect();

    let penumbra = Some(Penumbra { sun_degrees: 2.0, ..Penumbra::default() });
    for (call, penumbra) in [(shade::FILTERED, None), (SOFT, penumbra)] {
        let look_up = LookUp { penumbra, ..LookUp::default() };
        let texture = file.gpu().texture(&look_up, 2048).unwrap();
        let anchor = texture.anchor_world();
        let points: Vec<Point> = p_world
            .iter()
            .map(|p| [[p[0] - anchor[0], p[1] - anchor[1], p[2] - anchor[2], 0.0], [0.0, 1.0, 0.0, 0.0]])
            .collect();

        let wgsl = file.gpu().wgsl(Bindings::default()) + call;
        let parameters = file.gpu().parameters(&look_up, anchor.map(f64::from)).unwrap().to_bytes();
        let found = from_buffers(&gpu, &wgsl, &parameters, &words, &points);

        for format in [TexelFormat::R32Uint, TexelFormat::Rgba8Unorm] {
            let view = shade::upload(&gpu.device, &gpu.queue, &texture, format);
            let wgsl = texture.wgsl(format, Bindings::default()) + call;
            let resources = [BindingResource::TextureView(&view)];
            let from_texture = shade(&gpu.device, &gpu.queue, (&wgsl, &resources), &points).unwrap();
            assert!(from_texture == found, "{format:?} {call}");
        }
        assert!(from_stream(&gpu, &whole, &look_up, call, anchor, &points) == found, "{call}");
        let coarser = from_stream(&gpu, &coarse, &look_up, call, anchor, &points);
        let same = coarser.iter().zip(&found).filter(|(a, b)| a == b).count();
        assert!(same > COUNT / 2 && same < COUNT, "{call}: {same} of {COUNT} answers are the finest level's");

        let between = found.iter().filter(|v| **v > 0.0 && **v < 1.0).count();
        assert!(between * 100 > COUNT, "{call}: {between} points are partly lit");
        if penumbra.is_none() {
            let sampler = file.sampler(Filter::Box5);
            let off = points.iter().zip(&found).filter(|([p, _], found)| {
                let p_world = [0, 1, 2].map(|a| f64::from(anchor[a]) + f64::from(p[a]));
                (sampler.visibility(p_world, Some([0.0, 1.0, 0.0])) - **found).abs() > 1e-5
            });
            let off = off.count();
            assert!(off * 2000 <= COUNT, "{off} of {COUNT} points differ");
            let sampler = coarse.sampler(Filter::Box5).unwrap();
            let off = points.iter().zip(&coarser).filter(|([p, _], found)| {
                let p_world = [0, 1, 2].map(|a| f64::from(anchor[a]) + f64::from(p[a]));
                let answer = sampler.look_up(coarse.words(), p_world, Some([0.0, 1.0, 0.0]));
                (answer.visibility - **found).abs() > 1e-5
            });
            let off = off.count();
            assert!(off * 2000 <= COUNT, "{off} of {COUNT} streamed points differ");
        }
    }
}
