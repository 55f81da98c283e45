//! Compares two techniques with ray-traced truth, using the library: same camera, same pixels, one row each.
//!
//! `cargo run --release -p adumbra-compare --example compare_two` bakes the generated city and prints the
//! table of `voxel:filter=5` and `csm:filter=5`. Append `-- sm msm` to compare others;
//! `adumbra render --help` lists them. The example fails if a technique is wrong at more than 10 % of the
//! pixels. It needs a Vulkan, Metal or DirectX 12 adapter, which may be a software one.

use std::error::Error;

use adumbra::Sun;
use adumbra_bake::{Bake, BakeOptions, Size};
use adumbra_compare::compare::{Contender, Reference, compare, truth_for};
use adumbra_compare::truth::{Cache, TruthTracer, scene_key};
use adumbra_program::format::{figure, percent};
use adumbra_render::{Gpu, GpuOptions, Renderer, SceneOptions, TechniqueFiles, TechniqueSpec, build};
use adumbra_scene::{Camera, GeneratedKind, Projection, generate};

/// Techniques compared by default.
const DEFAULTS: [&str; 2] = ["voxel:filter=5", "csm:filter=5"];
/// Largest share of wrong pixels. A technique that exceeds it is not set up correctly.
const MAX_WRONG: f64 = 0.1;

fn main() -> Result<(), Box<dyn Error>> {
    let mut names: Vec<String> = std::env::args().skip(1).collect();
    if names.is_empty() {
        names = DEFAULTS.map(str::to_owned).into();
    }
    let scene = generate(GeneratedKind::City, 1);
    let sun = Sun::from_direction([0.5, 0.8, 0.35])?;
    let options = BakeOptions::new(sun, Size::Resolution(8192));
    let file = Bake::with_options(&scene, &options).in_memory()?;

    let gpu = Gpu::request(&GpuOptions::default())?;
    let mut renderer = Renderer::new(gpu, &scene, SceneOptions::default())?;
    println!("drawn by {}", renderer.gpu().name());
    let mut contenders = Vec::new();
    for name in &names {
        let spec: TechniqueSpec = name.parse()?;
        let technique = build(renderer.gpu(), &spec, TechniqueFiles::of(&file))?;
        let prepared = Some(renderer.prepare(technique)?);
        contenders.push(Contender { prepared, truth: truth_for(&spec), spec });
    }

    // The reference: rays at the camera's own pixels. Techniques with penumbrae are compared with a disc of
    // 0.53°, sampled with 64 rays.
    let truth = TruthTracer::build(&scene, false);
    let (cache, key) = (Cache::none(), scene_key(&scene, false));
    let reference =
        Reference { truth: &truth, cache: &cache, scene: &key, towards_sun: sun.towards(), disc: (0.53, 64) };
    let camera = Camera {
        eye: [-150.0, 38.0, 175.0],
        target: [-75.0, 4.0, 75.0],
        projection: Projection::Perspective { fov_degrees: 50.0 },
        width: 480,
        height: 270,
    };
    let comparison = compare(&mut renderer, &reference, &camera, &mut contenders, 3)?;

    println!("{} pixels compared", comparison.pixels.compared);
    println!(
        "{:20} {:>9} {:>9} {:>8} {:>12} {:>17}",
        "technique", "ms", "MB", "RMSE", "wrong lit %", "wrong shadowed %"
    );
    for row in comparison.compared.iter().map(|c| &c.row) {
        println!(
            "{:20} {:9.2} {:9.2} {:>8} {:>12} {:>17}",
            row.name,
            row.gpu_ms.unwrap_or(f64::NAN),
            row.bytes as f64 / 1e6,
            figure(row.rmse, 4),
            percent(row.wrong_lit, 3),
            percent(row.wrong_shadowed, 3)
        );
        if row.wrong().is_none_or(|wrong| wrong > MAX_WRONG) {
            return Err(
                format!("{} is wrong at over 10 % of the pixels, or none is compared", row.name).into()
            );
        }
    }
    Ok(())
}
