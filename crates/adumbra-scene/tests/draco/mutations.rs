//! Damaged streams: whatever their bytes, a load returns a scene or an error, and stays within its memory
//! limit.
//!
//! The damage knows where a stream has its header, its counts, its connectivity and its attributes.
//! `ADUMBRA_FUZZ_SECONDS=600` runs for that long, and `ADUMBRA_FUZZ_SEED` gives other cases.

use std::env;
use std::time::Instant;

use adumbra_scene::random::Random;
use adumbra_scene::{Error, LoadOptions, load};
use adumbra_testing::fuzz_time;
use peak_alloc::PeakAlloc;
use serde_json::json;

use crate::fixture::Fixture;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Memory that a load may hold.
const MAX_BYTES: u64 = 64 << 20;
/// Memory of the test itself.
const TEST_BYTES: u64 = 64 << 20;

struct Damage {
    random: Random,
}

impl Damage {
    fn below(&mut self, count: usize) -> usize {
        (self.random.unit() * count as f64) as usize
    }

    fn byte(&mut self) -> u8 {
        let any = self.below(256) as u8;
        [any, any, 0, 0xff, 0x7f, 0x80][self.below(6)]
    }

    /// A position in a stream: in the header, the counts, the connectivity or the attributes, equally often.
    fn place(&mut self, length: usize) -> usize {
        let ends = [5, 11, 24, length / 3, length].map(|end| end.min(length));
        let part = self.below(4);
        let (from, to) = (ends[part], ends[part + 1].max(ends[part] + 1));
        (from + self.below(to - from)).min(length - 1)
    }

    fn bytes(&mut self, stream: &mut [u8]) {
        let at = self.place(stream.len());
        match self.below(5) {
            0 => stream[at] ^= 1 << self.below(8),
            1 => stream[at] = self.byte(),
            // A number of up to five groups of seven bits.
            2 => {
                let groups = self.below(5);
                for byte in stream.iter_mut().skip(at).take(groups) {
                    *byte = 0x80 | self.byte();
                }
                if let Some(last) = stream.get_mut(at + groups) {
                    *last &= 0x7f;
                }
            }
            3 => {
                let length = self.below(16).min(stream.len() - at);
                let from = self.below(stream.len() - length);
                stream.copy_within(from..from + length, at);
            }
            _ => {
                let length = self.below(9).min(stream.len() - at);
                stream[at..][..length].fill_with(|| self.byte());
            }
        }
    }

    /// Changes what the file states about a stream.
    fn json(&mut self, fixture: &mut Fixture, view: usize) {
        let accessor = self.below(13);
        match self.below(4) {
            0 => fixture.json["accessors"][accessor]["count"] = json!(1_u64 << self.below(40)),
            1 => {
                let kinds = [5120, 5121, 5122, 5123, 5125, 5126];
                fixture.json["accessors"][accessor]["componentType"] = json!(kinds[self.below(6)]);
            }
            2 => {
                let primitive = &mut fixture.json["meshes"][0]["primitives"][0];
                let ids = &mut primitive["extensions"]["KHR_draco_mesh_compression"]["attributes"];
                ids[["POSITION", "COLOR_0", "JOINTS_0"][self.below(3)]] = json!(self.below(8));
            }
            _ => {
                let length = fixture.json["bufferViews"][view]["byteLength"].as_u64().expect("a length");
                fixture.json["bufferViews"][view]["byteLength"] = json!(self.below(length as usize));
            }
        }
    }
}

#[test]
fn draco_damage_never_panics_and_memory_is_bounded() {
    let number = |name: &str| -> Option<u64> { Some(env::var(name).ok()?.parse().expect("a whole number")) };
    let seconds = fuzz_time();
    let seed = number("ADUMBRA_FUZZ_SEED").unwrap_or(1);
    let names = [
        "edgebreaker-lossless",
        "edgebreaker-quantized",
        "edgebreaker-quantized-slow",
        "sequential-lossless",
        "sequential-quantized",
    ];
    let whole = names.map(Fixture::read);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("scene.glb");
    let options = LoadOptions { max_memory_bytes: Some(MAX_BYTES), ..LoadOptions::default() };
    let (start, mut cases, mut loaded) = (Instant::now(), 0_u64, 0_u64);
    MEMORY.reset_peak_usage();
    while seconds.map_or(cases < 2000, |limit| start.elapsed() < limit) {
        let mut damage = Damage { random: Random::new(seed, cases) };
        let mut fixture = whole[damage.below(names.len())].clone();
        // Views 1 to 3 are the streams.
        let view = 1 + damage.below(3);
        let [from, length] = ["byteOffset", "byteLength"]
            .map(|k| fixture.json["bufferViews"][view][k].as_u64().expect("a number") as usize);
        for _ in 0..=damage.below(4) {
            match damage.below(6) {
                0 => damage.json(&mut fixture, view),
                _ => damage.bytes(&mut fixture.bin[from..][..length]),
            }
        }
        std::fs::write(&path, fixture.bytes()).expect("writes");
        match load(&path, &options) {
            Ok(_) => loaded += 1,
            Err(Error::Io(error)) => panic!("case {cases} of seed {seed}: {error}"),
            Err(_) => {}
        }
        cases += 1;
    }
    let peak = MEMORY.peak_usage() as u64;
    eprintln!("{cases} cases, {loaded} of them loaded; peak {peak} bytes");
    assert!(loaded > cases / 100 && loaded < cases, "{loaded} of {cases} loaded");
    assert!(peak < MAX_BYTES + TEST_BYTES, "{peak}");
}
