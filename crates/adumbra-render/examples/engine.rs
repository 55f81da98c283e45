//! An engine that shades with a shadow file. For that it links `adumbra` and a graphics library, and nothing
//! else of this project: upload the file's words, put the look-up's WGSL before the engine's own, and call
//! `adumbra_visibility` in the fragment shader.
//!
//! `cargo run --release -p adumbra-render --example engine -- city.adumbra square.png` draws a square of 200
//! m over the city's streets, seen from straight above, white = lit. Without a file, the example bakes the
//! generated city. It fails if more than one pixel in a thousand differs from the CPU look-up by more than
//! one row of the filter's taps. Cost in bindings: one uniform buffer and one storage buffer of the file's
//! size.

use std::error::Error;

use adumbra::gpu::{Bindings, LookUp};
use adumbra::{Filter, ShadowFile, Sun};
use adumbra_bake::Bake;
use adumbra_scene::{GeneratedKind, generate};
use wgpu::BufferUsages;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

const PIXELS: u32 = 512;
const METRES_PER_PIXEL: f64 = 200.0 / PIXELS as f64;
/// Corner of the square that is drawn, above the pavements.
const CORNER_WORLD: [f64; 3] = [-150.0, 0.25, -50.0];
/// The camera.
const EYE_WORLD: [f64; 3] = [-50.0, 1.7, 50.0];
/// The filter.
const FILTER: Filter = Filter::Box9;
/// Tolerance of the visibility: the shader's `f32` positions may put a point into the texel next to the one
/// that the CPU's `f64` gives.
const ROW_OF_TAPS: f32 = 1.001 / FILTER.width() as f32;

/// The engine's own shader. Group 0 is its own, group 1 is the look-up's.
const ENGINE_WGSL: &str = "
struct Square { corner: vec3f, metres_per_pixel: f32 }
@group(0) @binding(0) var<uniform> square: Square;

@vertex
fn vertex(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn fragment(@builtin(position) pixel: vec4f) -> @location(0) f32 {
    let p_relative = square.corner + square.metres_per_pixel * vec3f(pixel.x, 0.0, pixel.y);
    return adumbra_visibility(p_relative, vec3f(0.0, 1.0, 0.0));
}
";

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let file = match arguments.next() {
        Some(path) => ShadowFile::read(path)?,
        None => {
            let city = generate(GeneratedKind::City, 1);
            Bake::new(&city, Sun::from_direction([0.5, 0.8, 0.35])?).in_memory()?
        }
    };
    let picture = arguments.next().unwrap_or_else(|| "square.png".to_owned());
    // The engine's device and queue.
    let (device, queue) = pollster::block_on(async {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await?;
        Ok::<_, Box<dyn Error>>(adapter.request_device(&wgpu::DeviceDescriptor::default()).await?)
    })?;
    let buffer = |contents: &[u8], usage| {
        device.create_buffer_init(&BufferInitDescriptor { label: None, contents, usage })
    };

    // Once: upload the file's words, and put the look-up's text before the engine's own.
    let look_up = LookUp { filter: FILTER, ..LookUp::default() };
    let words = buffer(bytemuck::cast_slice(&file.gpu().words().to_vec()), BufferUsages::STORAGE);
    let wgsl = file.gpu().wgsl(Bindings { group: 1, first: 0 }) + ENGINE_WGSL;
    // Every frame: write the parameters for positions relative to the camera.
    let parameters = buffer(&file.gpu().parameters(&look_up, EYE_WORLD)?.to_bytes(), BufferUsages::UNIFORM);

    // All that follows is the engine's own.
    let corner: [f32; 3] = std::array::from_fn(|a| (CORNER_WORLD[a] - EYE_WORLD[a]) as f32);
    let square = [corner[0], corner[1], corner[2], METRES_PER_PIXEL as f32];
    let square = buffer(bytemuck::cast_slice(&square), BufferUsages::UNIFORM);
    let target = Target::new(&device);
    target.draw(&device, &queue, &wgsl, [&[&square], &[&parameters, &words]]);
    let visibility = target.read(&device, &queue)?;

    let bytes: Vec<u8> = visibility.iter().map(|v| (255.0 * v).round() as u8).collect();
    image::save_buffer(&picture, &bytes, PIXELS, PIXELS, image::ExtendedColorType::L8)?;
    let shadow = file.sampler(FILTER);
    let differ = (0..).zip(&visibility).filter(|&(i, v): &(u32, _)| {
        let [x, z] = [i % PIXELS, i / PIXELS].map(|n| (f64::from(n) + 0.5) * METRES_PER_PIXEL);
        let p_world = [CORNER_WORLD[0] + x, CORNER_WORLD[1], CORNER_WORLD[2] + z];
        (shadow.visibility(p_world, Some([0.0, 1.0, 0.0])) - v).abs() > ROW_OF_TAPS
    });
    let (differ, pixels) = (differ.count(), visibility.len());
    let mean = visibility.iter().sum::<f32>() / pixels as f32;
    println!(
        "{picture}: mean visibility {mean:.3}; {differ} of {pixels} pixels differ from the CPU's look-up"
    );
    if differ * 1000 > pixels { Err("the shader's look-up differs from the CPU's".into()) } else { Ok(()) }
}

/// A square picture of one value per pixel.
struct Target {
    texture: wgpu::Texture,
}

impl Target {
    const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

    fn new(device: &wgpu::Device) -> Self {
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: PIXELS, height: PIXELS, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: Self::FORMAT,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        Self { texture }
    }

    /// Draws one triangle over the picture. `groups` are the buffers of each bind group.
    fn draw(&self, device: &wgpu::Device, queue: &wgpu::Queue, wgsl: &str, groups: [&[&wgpu::Buffer]; 2]) {
        let source = wgpu::ShaderSource::Wgsl(wgsl.into());
        let module = &device.create_shader_module(wgpu::ShaderModuleDescriptor { label: None, source });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: None,
            vertex: wgpu::VertexState {
                module,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some("fragment"),
                compilation_options: Default::default(),
                targets: &[Some(Self::FORMAT.into())],
            }),
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            multiview_mask: None,
            cache: None,
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.texture.create_view(&Default::default()),
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations::default(),
            })],
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        for (group, buffers) in (0..).zip(groups) {
            let entries: Vec<_> = (0..)
                .zip(buffers)
                .map(|(binding, buffer)| wgpu::BindGroupEntry {
                    binding,
                    resource: buffer.as_entire_binding(),
                })
                .collect();
            let layout = &pipeline.get_bind_group_layout(group);
            let descriptor = wgpu::BindGroupDescriptor { label: None, layout, entries: &entries };
            pass.set_bind_group(group, &device.create_bind_group(&descriptor), &[]);
        }
        pass.draw(0..3, 0..1);
        drop(pass);
        queue.submit([encoder.finish()]);
    }

    /// Returns the values, rows in order.
    fn read(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Vec<f32>, Box<dyn Error>> {
        let copy = device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: u64::from(4 * PIXELS * PIXELS),
            usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let rows =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(4 * PIXELS), rows_per_image: None };
        let to = wgpu::TexelCopyBufferInfo { buffer: &copy, layout: rows };
        let mut encoder = device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(self.texture.as_image_copy(), to, self.texture.size());
        queue.submit([encoder.finish()]);
        copy.map_async(wgpu::MapMode::Read, .., |_| {});
        device.poll(wgpu::PollType::wait_indefinitely())?;
        Ok(bytemuck::pod_collect_to_vec(&copy.get_mapped_range(..)?))
    }
}
