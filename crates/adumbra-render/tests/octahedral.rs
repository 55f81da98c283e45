//! core/octahedral.wgsl against its CPU twin.

mod kit;

use adumbra_render::gpu::binding;
use adumbra_render::octahedral::{decode, encode};
use adumbra_render::readback::read_buffer;
use adumbra_shaders::{assemble, source};
use wgpu::{BufferUsages, ShaderStages};

const PASS: &str = "
@group(0) @binding(0) var<storage, read> directions: array<vec4f>;
@group(0) @binding(1) var<storage, read_write> packed: array<vec4f>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let bytes = octahedral_bytes(octahedral_texel(octahedral_encode(directions[id.x].xyz)));
    packed[id.x] = vec4f(octahedral_decode(bytes), f32(bytes.x | bytes.y << 8u));
}
";

/// A Fibonacci lattice over the sphere.
#[test]
fn octahedral_packs_as_its_twin_does() {
    let gpu = kit::gpu();
    let count = 64 * 512_u32;
    let directions: Vec<[f32; 4]> = (0..count)
        .map(|i| {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
            let (sin, cos) = (2.399963229728653 * f64::from(i)).sin_cos();
            let radius = (1.0 - z * z).sqrt();
            [(radius * cos) as f32, (radius * sin) as f32, z as f32, 0.0]
        })
        .collect();
    let given = gpu.buffer("test::directions", bytemuck::cast_slice(&directions), BufferUsages::STORAGE);
    let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let found = gpu.buffer("test::packed", &vec![0; 16 * count as usize], usage);
    let layout = gpu.layout("test", ShaderStages::COMPUTE, &[binding::STORAGE, binding::STORAGE_OUT]);
    let text = assemble(&[source::OCTAHEDRAL]) + PASS;
    let pipeline = gpu.compute("test", text, "main", &[Some(&layout)]);
    let group = gpu.bind("test", &layout, vec![given.as_entire_binding(), found.as_entire_binding()]);
    let mut encoder = gpu.encoder("test");
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.dispatch_workgroups(count / 64, 1, 1);
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
    let found = read_buffer(&gpu, &found).unwrap();
    let found: &[[f32; 4]] = bytemuck::cast_slice(&found);
    let mut other_bytes = 0;
    for (d, f) in directions.iter().zip(found) {
        let word = f[3] as u32;
        let bytes = [(word & 255) as u8, (word >> 8) as u8];
        // Where a byte lies halfway, the last bit of a quotient decides.
        other_bytes += usize::from(bytes != encode([d[0], d[1], d[2]]));
        let expected = decode(bytes);
        assert!((0..3).all(|a| (expected[a] - f[a]).abs() < 1e-5), "{bytes:?}: {expected:?}, {f:?}");
    }
    println!("{other_bytes} of {count} packed otherwise");
    assert!(other_bytes * 1000 < count as usize, "{other_bytes}");
}
