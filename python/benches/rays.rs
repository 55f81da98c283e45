//! The Rust side of `rays.py`: times `Tracer::sun_visible` over the points of a file.
//!
//! `rays SCENE POINTS NORMALS X,Y,Z LIFT REPEATS`: a scene, points and normals as little-endian float64
//! triples, the direction towards the sun, and how far rays start above the points. Prints the seconds of
//! each repeat, from an empty result to a full one, the number of lit points, and the bytes that it held.

mod memory;
mod triples;

use std::error::Error;
use std::time::Instant;

use adumbra::grid::vec3::dot;
use adumbra_scene::LoadOptions;
use adumbra_truth::trace::{TraceOptions, Tracer};
use rayon::prelude::*;

use memory::measured;
use triples::triples;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [scene, points, normals, sun, lift, repeats] = &*arguments else {
        return Err("usage: rays SCENE POINTS NORMALS X,Y,Z LIFT REPEATS".into());
    };
    let scene = adumbra_scene::load(scene.as_ref(), &LoadOptions::default())?;
    let tracer = Tracer::build(&scene, TraceOptions::default());
    let (points, normals) = (triples(points.as_ref())?, triples(normals.as_ref())?);
    let sun: Vec<f64> = sun.split(',').map(str::parse).collect::<Result<_, _>>()?;
    let Ok(sun) = <[f64; 3]>::try_from(sun) else { return Err("a sun is three numbers".into()) };
    let lift: f64 = lift.parse()?;
    for _ in 0..repeats.parse::<u32>()? {
        let start = Instant::now();
        let (lit, bytes) = measured(|| -> Vec<bool> {
            let each = points.par_iter().zip(&normals);
            each.map(|(point, normal)| {
                let faces = dot(*normal, sun) > 0.0;
                faces && tracer.sun_visible(std::array::from_fn(|a| point[a] + lift * normal[a]), sun)
            })
            .collect()
        })?;
        let seconds = start.elapsed().as_secs_f64();
        println!("{seconds} {} {bytes}", lit.iter().filter(|&&is_lit| is_lit).count());
    }
    Ok(())
}
