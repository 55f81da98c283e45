//! The Rust side of `look_ups.py`: times `Sampler::par_visibilities` over the points of a file.
//!
//! `look_ups FILE POINTS NORMALS REPEATS`: a shadow file, its points and normals as little-endian float64
//! triples. Prints the seconds of each repeat, from an empty result to a full one, and the bytes that it
//! held.

mod memory;
mod triples;

use std::error::Error;
use std::time::Instant;

use adumbra::{Filter, ShadowFile};

use memory::measured;
use triples::triples;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, points, normals, repeats] = &*arguments else {
        return Err("usage: look_ups FILE POINTS NORMALS REPEATS".into());
    };
    let sampler = ShadowFile::read(file)?.sampler(Filter::Box5);
    let (points, normals) = (triples(points.as_ref())?, triples(normals.as_ref())?);
    for _ in 0..repeats.parse::<u32>()? {
        let start = Instant::now();
        let (done, bytes) = measured(|| {
            let mut out = vec![0.0; points.len()];
            sampler.par_visibilities(&points, Some(&normals), &mut out)
        })?;
        done?;
        println!("{} {bytes}", start.elapsed().as_secs_f64());
    }
    Ok(())
}
