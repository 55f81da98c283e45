//! Bakes a city, writes the file, reads it back, and looks up 10,000 points. Rays check how many answers are
//! correct.
//!
//! `cargo run --release -p adumbra-truth --example bake_and_query` prints the shares of points that are
//! shadowed and of answers that agree with rays, and fails if fewer than 99 % agree. To use another scene and
//! file instead of the generated city, add `-- town.glb town.adumbra`.

use std::error::Error;
use std::path::PathBuf;

use adumbra::{Filter, ShadowFile, Sun};
use adumbra_bake::Bake;
use adumbra_scene::{GeneratedKind, LoadOptions, generate, load};
use adumbra_truth::trace::{Ray, TraceOptions, Tracer};

/// Points per side of the square that covers the scene from above.
const SIDE: u32 = 100;
/// Height above its surface at which a ray starts, metres.
const LIFT_WORLD: f64 = 1e-3;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1).map(PathBuf::from);
    let scene = match arguments.next() {
        Some(path) => load(&path, &LoadOptions::default())?,
        None => generate(GeneratedKind::City, 1),
    };
    let path = arguments.next().unwrap_or_else(|| "city.adumbra".into());

    // Direction towards the sun, any length; Y is up.
    let sun = Sun::from_direction([0.5, 0.8, 0.35])?;
    let baked = Bake::new(&scene, sun).resolution(8192).save(&path)?;
    println!("{}: {} bytes, baked in {:.1} s", path.display(), baked.bytes, baked.report.seconds);

    // As in a game: read the file, create a sampler that reads 1 × 1 texels, and look up points.
    let file = ShadowFile::read(&path)?;
    let shadow = file.sampler(Filter::Nearest);

    let tracer = Tracer::build(&scene, TraceOptions::default());
    let bounds = scene.bounds();
    let (mut asked, mut shadowed, mut agree) = (0_u32, 0_u32, 0_u32);
    for (i, k) in (0..SIDE).flat_map(|k| (0..SIDE).map(move |i| (i, k))) {
        let across = |a: usize, n: u32| {
            bounds.min[a] + (f64::from(n) + 0.5) / f64::from(SIDE) * (bounds.max[a] - bounds.min[a])
        };
        // The first surface below the sky: a street or a roof.
        let sky = [across(0, i), bounds.max[1] + 1.0, across(2, k)];
        let down = Ray { origin: sky, direction: [0.0, -1.0, 0.0], t_min: 0.0, t_max: f64::INFINITY };
        let Some(hit) = tracer.nearest_surface(&down) else { continue };
        let normal = if hit.front { hit.normal } else { hit.normal.map(|c| -c) };
        // Skip surfaces that face away from the sun or are close to the terminator, where neither answer is
        // reliable.
        if (0..3).map(|a| normal[a] * sun.towards()[a]).sum::<f64>() < 0.1 {
            continue;
        }
        let p_world = [sky[0], sky[1] - hit.t, sky[2]];
        let visibility = shadow.visibility(p_world, Some(normal));
        let lifted = std::array::from_fn(|a| p_world[a] + LIFT_WORLD * normal[a]);
        asked += 1;
        shadowed += u32::from(visibility < 0.5);
        agree += u32::from((visibility >= 0.5) == tracer.sun_visible(lifted, sun.towards()));
    }
    let share = |n: u32| 100.0 * f64::from(n) / f64::from(asked.max(1));
    println!("{asked} points: {:.1} % in shadow, {:.2} % agree with rays", share(shadowed), share(agree));
    if asked == 0 || share(agree) < 99.0 {
        return Err("the file disagrees with rays".into());
    }
    Ok(())
}
