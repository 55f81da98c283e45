//! An engine whose materials can add a texture but no buffer. It links `adumbra` and a graphics library, and
//! nothing else of this project: it builds a bind group from the bytes of a look-up texture.
//!
//! `cargo run --release -p adumbra-render --example look_up_texture` bakes the generated city and prints the
//! mean visibility of the points of a square of 200 m over its streets, from a texture of either format.
//! `-- city.adumbra` takes another file. The example fails if more than one point in a thousand differs from
//! the CPU look-up by more than one row of the filter's taps. Cost in bindings: one texture. Nothing is
//! uploaded per frame.

mod shade;

use std::error::Error;

use adumbra::gpu::{Bindings, LookUp, TexelFormat};
use adumbra::{Filter, ShadowFile, Sun};
use adumbra_bake::{Bake, BakeOptions, Size};
use adumbra_scene::{GeneratedKind, generate};

/// Number of points per side of the square.
const SIDE: u32 = 256;
const METRES_PER_POINT: f64 = 200.0 / SIDE as f64;
/// Corner of the square, above the pavements.
const CORNER_WORLD: [f64; 3] = [-150.0, 0.25, -50.0];
/// The filter.
const FILTER: Filter = Filter::Box5;
/// Tolerance of the visibility: the shader's `f32` positions may put a point into the texel next to the one
/// that the CPU's `f64` gives.
const ROW_OF_TAPS: f32 = 1.001 / FILTER.width() as f32;
const UP: [f64; 3] = [0.0, 1.0, 0.0];

fn main() -> Result<(), Box<dyn Error>> {
    let file = match std::env::args().nth(1) {
        Some(path) => ShadowFile::read(&path)?,
        None => {
            let options = BakeOptions::new(Sun::from_direction([0.5, 0.8, 0.35])?, Size::Resolution(8192));
            Bake::with_options(&generate(GeneratedKind::City, 1), &options).in_memory()?
        }
    };
    // The engine's device and queue.
    let (device, queue) = pollster::block_on(async {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let adapter = instance.request_adapter(&wgpu::RequestAdapterOptions::default()).await?;
        Ok::<_, Box<dyn Error>>(adapter.request_device(&wgpu::DeviceDescriptor::default()).await?)
    })?;

    let max_side = device.limits().max_texture_dimension_2d;
    let texture = file.gpu().texture(&LookUp { filter: FILTER, ..LookUp::default() }, max_side)?;
    let anchor = texture.anchor_world();
    let points_world: Vec<[f64; 3]> = (0..SIDE * SIDE)
        .map(|i| {
            let [x, z] = [i % SIDE, i / SIDE].map(|n| (f64::from(n) + 0.5) * METRES_PER_POINT);
            [CORNER_WORLD[0] + x, CORNER_WORLD[1], CORNER_WORLD[2] + z]
        })
        .collect();
    let relative = |p: &[f64; 3]| {
        let [x, y, z] = [0, 1, 2].map(|a| (p[a] - f64::from(anchor[a])) as f32);
        [[x, y, z, 0.0], [0.0, 1.0, 0.0, 0.0]]
    };
    let points: Vec<shade::Point> = points_world.iter().map(relative).collect();
    let shadow = file.sampler(FILTER);
    for format in [TexelFormat::R32Uint, TexelFormat::Rgba8Unorm] {
        let view = shade::upload(&device, &queue, &texture, format);
        let look_up = texture.wgsl(format, Bindings { group: 1, first: 0 }) + shade::FILTERED;
        let resources = [wgpu::BindingResource::TextureView(&view)];
        let found = shade::shade(&device, &queue, (&look_up, &resources), &points)?;
        let is_off =
            |(p, v): &(&[f64; 3], &f32)| (shadow.visibility(**p, Some(UP)) - **v).abs() > ROW_OF_TAPS;
        let off = points_world.iter().zip(&found).filter(is_off).count();
        let mean = found.iter().sum::<f32>() / found.len() as f32;
        let (width, height) = (texture.width(), texture.height());
        println!(
            "{format:?}, {width} x {height} texels: mean visibility {mean:.3}; {off} of {} points differ from the CPU's look-up",
            found.len()
        );
        if off * 1000 > found.len() {
            return Err("the shader's look-up differs from the CPU's".into());
        }
    }
    Ok(())
}
