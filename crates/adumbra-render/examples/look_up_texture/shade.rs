//! Shades points with a look-up's WGSL, using wgpu alone.

use std::error::Error;

use adumbra::gpu::{LookUpTexture, TexelFormat};

/// A point, relative to the look-up's anchor, and its normal: two elements of the WGSL `array<vec4f>`.
pub(crate) type Point = [[f32; 4]; 2];

/// The engine's own shader. Group 0 is its own, group 1 is the look-up's.
const ENGINE_WGSL: &str = "
@group(0) @binding(0) var<storage, read> points: array<vec4f>;
@group(0) @binding(1) var<storage, read_write> visibility: array<f32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if (id.x < arrayLength(&visibility)) {
        visibility[id.x] = visibility_of(id.x, points[2u * id.x].xyz, points[2u * id.x + 1u].xyz);
    }
}
";

/// The visibility of a point with a filter.
pub(crate) const FILTERED: &str = "
fn visibility_of(point: u32, p_relative: vec3f, normal: vec3f) -> f32 {
    return adumbra_visibility(p_relative, normal);
}
";

/// Uploads the texture's bytes unchanged, whichever format the engine uses.
pub(crate) fn upload(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &LookUpTexture,
    format: TexelFormat,
) -> wgpu::TextureView {
    let format = match format {
        TexelFormat::R32Uint => wgpu::TextureFormat::R32Uint,
        TexelFormat::Rgba8Unorm => wgpu::TextureFormat::Rgba8Unorm,
    };
    let size = wgpu::Extent3d { width: texture.width(), height: texture.height(), depth_or_array_layers: 1 };
    let on_device = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("look-up texture"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let bytes_per_row = Some(4 * texture.width());
    let rows = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
    queue.write_texture(on_device.as_image_copy(), texture.bytes(), rows, size);
    on_device.create_view(&Default::default())
}

/// Returns the visibility of the sun at each point. `look_up` is the WGSL of a look-up, followed by the
/// function that calls it, and `resources` are those of the look-up.
pub(crate) fn shade(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    (look_up, resources): (&str, &[wgpu::BindingResource<'_>]),
    points: &[Point],
) -> Result<Vec<f32>, Box<dyn Error>> {
    let wgsl = look_up.to_owned() + ENGINE_WGSL;
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("engine"),
        source: wgpu::ShaderSource::Wgsl(wgsl.into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("engine"),
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: Default::default(),
        cache: None,
    });

    let buffer = |label, size, usage| {
        let mapped_at_creation = false;
        device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation })
    };
    use wgpu::BufferUsages as Usage;
    let input = buffer("points", size_of_val(points) as u64, Usage::STORAGE | Usage::COPY_DST);
    queue.write_buffer(&input, 0, bytemuck::cast_slice(points));
    let bytes = 4 * points.len() as u64;
    let output = buffer("visibility", bytes, Usage::STORAGE | Usage::COPY_SRC);
    let copy = buffer("visibility, to read", bytes, Usage::COPY_DST | Usage::MAP_READ);
    let bind = |group, resources: &[wgpu::BindingResource<'_>]| {
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource: resource.clone() })
            .collect();
        let layout = pipeline.get_bind_group_layout(group);
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &layout,
            entries: &entries,
        })
    };
    let own = bind(0, &[input.as_entire_binding(), output.as_entire_binding()]);
    let look_up = bind(1, resources);

    let mut encoder = device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &own, &[]);
    pass.set_bind_group(1, &look_up, &[]);
    pass.dispatch_workgroups((points.len() as u32).div_ceil(64), 1, 1);
    drop(pass);
    encoder.copy_buffer_to_buffer(&output, 0, &copy, 0, bytes);
    queue.submit([encoder.finish()]);
    copy.map_async(wgpu::MapMode::Read, .., |_| {});
    device.poll(wgpu::PollType::wait_indefinitely())?;
    Ok(bytemuck::pod_collect_to_vec(&copy.get_mapped_range(..)?))
}
