//! core/octahedral.wgsl against its CPU twin.

use adumbra_render::octahedral::{decode, encode};
use adumbra_shaders::{Source, source};

use crate::kit;

const PASS: &str = "
@group(0) @binding(0) var<storage, read> directions: array<vec4f>;
@group(0) @binding(1) var<storage, read_write> packed: array<vec4f>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let bytes = adumbra_octahedral_bytes(adumbra_octahedral_texel(adumbra_octahedral_encode(directions[id.x].xyz)));
    packed[id.x] = vec4f(adumbra_octahedral_decode(bytes), f32(bytes.x | bytes.y << 8u));
}
";

/// Tests directions of a Fibonacci lattice over the sphere.
#[test]
fn gpu_octahedral_matches_twin() {
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
    let texts = [source::OCTAHEDRAL, Source { name: "test", text: PASS }];
    let found = kit::lists::run(&gpu, &texts, bytemuck::cast_slice(&directions), count, 16);
    let found: &[[f32; 4]] = bytemuck::cast_slice(&found);
    let mut other_bytes = 0;
    for (d, f) in directions.iter().zip(found) {
        let word = f[3] as u32;
        let bytes = [(word & 255) as u8, (word >> 8) as u8];
        // If a value is halfway between two bytes, the last bit of a quotient decides.
        other_bytes += usize::from(bytes != encode([d[0], d[1], d[2]]));
        let expected = decode(bytes);
        assert!((0..3).all(|a| (expected[a] - f[a]).abs() < 1e-5), "{bytes:?}: {expected:?}, {f:?}");
    }
    println!("{other_bytes} of {count} packed otherwise");
    assert!(other_bytes * 1000 < count as usize, "{other_bytes}");
}
