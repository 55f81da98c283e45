//! Baked shadows in an engine's own shader: upload a file, bind group 1, include the WGSL, call `shadow_factor`.
//!
//! `cargo run --release -p adumbra-render --example engine -- city.adumbra 10,0,4` asks for one point; an engine asks for every pixel, from a
//! fragment or a compute shader. What it costs in bindings: one uniform and one storage buffer in group 1 (six storage buffers for
//! files larger than one binding may be).

use adumbra::format::ShadowFile;
use adumbra_render::Gpu;
use adumbra_render::gpu::binding;
use adumbra_render::readback::read_buffer;
use adumbra_render::voxel::Voxel;
use adumbra_shaders::{assemble, source};
use wgpu::{BufferUsages, ShaderStages};

/// The engine's own shader: group 0 is its own.
const ENGINE_WGSL: &str = "
@group(0) @binding(0) var<storage, read> point: array<vec4f>;
@group(0) @binding(1) var<storage, read_write> visibility: array<f32>;

@compute @workgroup_size(1)
fn main() {
    var s: Surface;
    s.p_relative = point[0].xyz;
    s.normal = vec3f(0.0, 1.0, 0.0);
    s.towards_sun = point[1].xyz;
    visibility[0] = shadow_factor(s);
}
";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(path), Some(point)) = (arguments.next(), arguments.next()) else {
        return Err("give a shadow file and a point: city.adumbra 10,0,4".into());
    };
    let p_world: Vec<f64> = point.split(',').map(str::parse).collect::<Result<_, _>>()?;
    let [x, y, z] = p_world[..] else { return Err("give a point as x,y,z".into()) };
    let file = ShadowFile::read(&path)?;

    // The engine's device and queue.
    let (device, queue) = pollster::block_on(async {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await?;
        let limits = adapter.limits();
        let asked = wgpu::DeviceDescriptor { required_limits: limits, ..Default::default() };
        Ok::<_, Box<dyn std::error::Error>>(adapter.request_device(&asked).await?)
    })?;
    let gpu = Gpu::sharing(&device, &queue);

    // Once: the file's words and their bind group.
    let mut voxel = Voxel::of_file(&gpu, &file, file.settings.bias, 9)?;
    // Each frame: the point that positions count from, usually the camera.
    let eye = [x, y + 1.7, z];
    voxel.set_anchor(&gpu, eye)?;

    // Once: the pipeline.
    let mut files = vec![source::SURFACE];
    files.extend(voxel.look_up());
    files.push(source::VOXEL_PASS);
    let mut text = assemble(&files);
    text += ENGINE_WGSL;
    let own = gpu.layout("engine", ShaderStages::COMPUTE, &[binding::STORAGE, binding::STORAGE_OUT]);
    let pipeline = gpu.compute("engine", text, "main", &[Some(&own), Some(voxel.bindings().layout())]);

    let sun = file.grid.sun.towards();
    let asked: Vec<f32> =
        [x - eye[0], y - eye[1], z - eye[2], 0.0, sun[0], sun[1], sun[2], 0.0].map(|c| c as f32).into();
    let asked = gpu.buffer("engine::point", bytemuck::cast_slice(&asked), BufferUsages::STORAGE);
    let answer = gpu.buffer("engine::answer", &[0; 4], BufferUsages::STORAGE | BufferUsages::COPY_SRC);
    let group = gpu.bind("engine", &own, vec![asked.as_entire_binding(), answer.as_entire_binding()]);
    let mut encoder = gpu.encoder("engine");
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.set_bind_group(1, voxel.bindings().group(), &[]);
    pass.dispatch_workgroups(1, 1, 1);
    drop(pass);
    gpu.finish(encoder.finish())?;
    let bytes = read_buffer(&gpu, &answer)?;
    println!("{}", f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]));
    Ok(())
}
