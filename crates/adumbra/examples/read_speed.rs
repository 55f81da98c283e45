//! How fast a shadow file is read on one core, raw and coded:
//! `cargo run --release -p adumbra --example read_speed FILE`.
//!
//! Reading a raw file takes only the time to check its words. The extra time of a coded file is the decoding.

use std::env;
use std::error::Error;
use std::time::{Duration, Instant};

use adumbra::{Encoding, ShadowFile};

/// Times each file is read. The shortest time counts.
const ROUNDS: usize = 7;

fn main() -> Result<(), Box<dyn Error>> {
    let path = env::args().nth(1).ok_or("usage: read_speed FILE.adumbra")?;
    let file = ShadowFile::read(&path)?;
    let [raw, coded] = [Encoding::Raw, Encoding::Coded].map(|encoding| file.to_bytes(encoding));
    let (raw, coded) = (raw?, coded?);
    let megabytes = raw.len() as f64 / 1e6;
    let [raw_seconds, coded_seconds] = [shortest(&raw)?, shortest(&coded)?].map(|time| time.as_secs_f64());
    let decoding = coded_seconds - raw_seconds;
    println!("{megabytes:.2} MB raw, {:.2} MB coded", coded.len() as f64 / 1e6);
    println!("raw words read:   {raw_seconds:.4} s, {:.1} MB/s", megabytes / raw_seconds);
    println!("coded words read: {coded_seconds:.4} s, {:.1} MB/s", megabytes / coded_seconds);
    println!("decoding alone:   {decoding:.4} s, {:.1} MB/s", megabytes / decoding);
    Ok(())
}

fn shortest(bytes: &[u8]) -> Result<Duration, Box<dyn Error>> {
    let mut least = Duration::MAX;
    for _ in 0..ROUNDS {
        let start = Instant::now();
        let file = ShadowFile::from_bytes(bytes)?;
        least = least.min(start.elapsed());
        drop(file);
    }
    Ok(least)
}
