//! Shades points with a look-up texture: builds a bind group from the bytes that `adumbra::gpu` provides,
//! using wgpu alone.

use std::error::Error;

use adumbra::gpu::{LookUpTexture, WordSource, wgsl_files};
use adumbra_shaders::{Source, assemble, source};

/// A point, relative to the texture's anchor, and its normal: two elements of the WGSL `array<vec4f>`.
pub(crate) type Point = [[f32; 4]; 2];

/// The engine's own shader. Group 0 is its own, group 1 is the look-up texture.
const ENGINE_WGSL: &str = "
@group(0) @binding(0) var<storage, read> points: array<vec4f>;
@group(0) @binding(1) var<storage, read_write> visibility: array<f32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if (id.x < arrayLength(&visibility)) {
        var s: AdumbraSurface;
        s.p_relative = points[2u * id.x].xyz;
        s.normal = points[2u * id.x + 1u].xyz;
        s.towards_sun = adumbra_texture_towards_sun();
        visibility[id.x] = adumbra_shadow_factor(s);
    }
}
";

/// Returns the visibility of the sun at each point.
pub(crate) fn shade(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    (texture, words): (&LookUpTexture, WordSource),
    points: &[Point],
) -> Result<Vec<f32>, Box<dyn Error>> {
    // Upload the texture's bytes unchanged, whichever format the engine uses.
    let format = match words {
        WordSource::R32Uint => wgpu::TextureFormat::R32Uint,
        _ => wgpu::TextureFormat::Rgba8Unorm,
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

    // Assemble the shader from the files that the format needs, then the engine's own text.
    let mut files: Vec<Source> = wgsl_files(words).into_iter().filter_map(source::by_path).collect();
    files.push(source::VOXEL_TEXTURE_PASS);
    files.push(Source { name: "engine", text: ENGINE_WGSL });
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("engine"),
        source: wgpu::ShaderSource::Wgsl(assemble(&files).into()),
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
    let view = on_device.create_view(&Default::default());
    let look_up = bind(1, &[wgpu::BindingResource::TextureView(&view)]);

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
