//! An engine's own wgpu program that shades with a shadow file: upload the file, set bind group 1, include
//! the WGSL, call `adumbra_shadow_factor`.
//!
//! `cargo run --release -p adumbra-render --example engine` bakes the generated city, shades a square of 200
//! m over its streets, seen from straight above, and writes it to square.png, white = lit.
//! `-- city.adumbra picture.png` takes another file. The example fails if more than one pixel in a thousand
//! differs from the CPU look-up by more than one row of the filter's taps. Cost in bindings: one uniform and
//! one storage buffer in group 1, or six storage buffers for files larger than one binding may be.

use std::error::Error;

use adumbra::{Filter, ShadowFile, Sun};
use adumbra_bake::{Bake, BakeOptions, Size};
use adumbra_render::gpu::{Gpu, binding};
use adumbra_render::readback::read_buffer;
use adumbra_render::voxel::{BakedLight, VoxelSettings};
use adumbra_scene::{GeneratedKind, generate};
use adumbra_shaders::{Source, assemble, source};
use wgpu::{BufferUsages, ShaderStages};

const PIXELS: u32 = 512;
const METRES_PER_PIXEL: f64 = 200.0 / PIXELS as f64;
/// Corner of the square that is drawn, above the pavements.
const CORNER_WORLD: [f64; 3] = [-150.0, 0.25, -50.0];
/// The filter.
const FILTER: Filter = Filter::Box9;
/// Tolerance of the visibility: the shader's `f32` positions may put a point into the texel next to the one
/// that the CPU's `f64` gives.
const ROW_OF_TAPS: f32 = 1.001 / FILTER.width() as f32;

/// The engine's own shader, with its own group 0. An engine fills `AdumbraSurface` from its G-buffer or in
/// its fragment shader; this one shades a square in mid-air.
const ENGINE_WGSL: &str = "
struct Engine { corner: vec3f, metres_per_pixel: f32, towards_sun: vec3f, pixels: u32 }
@group(0) @binding(0) var<uniform> engine: Engine;
@group(0) @binding(1) var<storage, read_write> visibility: array<f32>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let at = (vec2f(id.xy) + 0.5) * engine.metres_per_pixel;
    var s: AdumbraSurface;
    s.p_relative = engine.corner + vec3f(at.x, 0.0, at.y);
    s.normal = vec3f(0.0, 1.0, 0.0);
    s.towards_sun = engine.towards_sun;
    visibility[id.y * engine.pixels + id.x] = adumbra_shadow_factor(s);
}
";

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let file = match arguments.next() {
        Some(path) => ShadowFile::read(&path)?,
        None => {
            let sun = Sun::from_direction([0.5, 0.8, 0.35])?;
            let options = BakeOptions::new(sun, Size::Resolution(8192));
            let city = generate(GeneratedKind::City, 1);
            Bake::with_options(&city, &options).in_memory()?
        }
    };
    let picture = arguments.next().unwrap_or_else(|| "square.png".into());

    // The engine's device and queue.
    let (device, queue) = pollster::block_on(async {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await?;
        let asked = wgpu::DeviceDescriptor { required_limits: adapter.limits(), ..Default::default() };
        Ok::<_, Box<dyn Error>>(adapter.request_device(&asked).await?)
    })?;

    // Once: upload the file's words and create their bind group.
    let gpu = Gpu::sharing(&device, &queue);
    let mut light = BakedLight::from_file(&gpu, &file, VoxelSettings::taps(FILTER, file.settings.bias))?;
    // Every frame: set the origin of relative positions, usually the camera.
    let anchor = [-50.0, 1.7, 50.0];
    light.set_anchor(&gpu, anchor)?;

    // Once: assemble the shader from the files of the look-up and the engine's own text, and build its
    // pipeline.
    let mut files = vec![source::SURFACE];
    files.extend(light.visibility_sources());
    files.push(Source { name: "engine", text: ENGINE_WGSL });
    let own = gpu.layout("engine", ShaderStages::COMPUTE, &[binding::UNIFORM, binding::STORAGE_OUT]);
    let groups = [Some(&own), Some(light.bindings().layout())];
    let pipeline = gpu.compute("engine", assemble(&files), "main", &groups);

    let corner: [f32; 3] = std::array::from_fn(|a| (CORNER_WORLD[a] - anchor[a]) as f32);
    let sun = file.grid.sun.towards().map(|c| c as f32);
    let mut uniform: Vec<u8> = bytemuck::cast_slice(&[corner, sun].concat()).to_vec();
    uniform.splice(12..12, (METRES_PER_PIXEL as f32).to_le_bytes());
    uniform.extend(PIXELS.to_le_bytes());
    let uniform = gpu.uniform("engine::uniform", &uniform);
    let pixels = (PIXELS * PIXELS) as usize;
    let visibility = gpu.buffer(
        "engine::visibility",
        &vec![0; 4 * pixels],
        BufferUsages::STORAGE | BufferUsages::COPY_SRC,
    );
    let group = gpu.bind("engine", &own, vec![uniform.as_entire_binding(), visibility.as_entire_binding()]);
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.set_bind_group(1, light.bindings().group(), &[]);
    pass.dispatch_workgroups(PIXELS / 8, PIXELS / 8, 1);
    drop(pass);
    queue.submit([encoder.finish()]);
    let visibility: Vec<f32> = bytemuck::pod_collect_to_vec(&read_buffer(&gpu, &visibility)?);

    let bytes: Vec<u8> = visibility.iter().map(|v| (255.0 * v).round() as u8).collect();
    image::save_buffer(&picture, &bytes, PIXELS, PIXELS, image::ExtendedColorType::L8)?;
    let shadow = file.sampler(FILTER);
    let differ = (0..).zip(&visibility).filter(|&(i, v): &(u32, _)| {
        let [x, z] = [i % PIXELS, i / PIXELS].map(|n| (f64::from(n) + 0.5) * METRES_PER_PIXEL);
        let p_world = [CORNER_WORLD[0] + x, CORNER_WORLD[1], CORNER_WORLD[2] + z];
        (shadow.visibility(p_world, Some([0.0, 1.0, 0.0])) - v).abs() > ROW_OF_TAPS
    });
    let (differ, mean) = (differ.count(), visibility.iter().sum::<f32>() / pixels as f32);
    println!(
        "{picture}: mean visibility {mean:.3}; {differ} of {pixels} pixels differ from the CPU's look-up"
    );
    if differ * 1000 > pixels { Err("the shader's look-up differs from the CPU's".into()) } else { Ok(()) }
}
