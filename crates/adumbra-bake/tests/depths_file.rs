//! Files of bakes: written, read back, and refused if damaged.

use adumbra::layout::depths::code::ColumnNode;
use adumbra::{Encoding, ShadowFile, Sun};
use adumbra_bake::{Bake, BakeOptions, FrameChoice, Size};
use adumbra_files::replace_file;
use adumbra_scene::random::Random;
use adumbra_scene::{GeneratedKind, generate};
use adumbra_testing::TreeParts;

const FRAMES: [FrameChoice; 2] = [FrameChoice::Light, FrameChoice::Oblique];

fn baked(kind: GeneratedKind, resolution: u64) -> ShadowFile {
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    Bake::with_options(&generate(kind, 3), &BakeOptions::new(sun, Size::Resolution(resolution)))
        .in_memory()
        .unwrap()
}

#[test]
fn depths_file_is_read_as_it_was_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("city.adumbra");
    let file = baked(GeneratedKind::City, 1024);
    let bytes = replace_file(&path, |out| file.write_to(out, Encoding::default())).unwrap();
    assert_eq!(bytes, path.metadata().unwrap().len());
    let again = ShadowFile::read(&path).unwrap();
    assert_eq!(again, file);
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn coded_file_has_the_words_of_the_raw_one() {
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    let kinds = [GeneratedKind::City, GeneratedKind::Landscape];
    for (kind, frame) in kinds.into_iter().flat_map(|kind| FRAMES.map(|frame| (kind, frame))) {
        let options = BakeOptions::new(sun, Size::Resolution(1024)).with(|o| o.frame = frame);
        let file = Bake::with_options(&generate(kind, 3), &options).in_memory().unwrap();
        // 1024 and 256 texels; a level of 64 would be left out.
        assert_eq!(file.level_count(), 2);
        let [raw, coded] = [Encoding::Raw, Encoding::Coded].map(|encoding| file.to_bytes(encoding).unwrap());
        assert_eq!(raw.len() as u64, file.encoded_len());
        assert!(2 * coded.len() < raw.len(), "{kind:?}, {frame:?}: {} of {}", coded.len(), raw.len());
        let decoded = ShadowFile::from_bytes(&coded).unwrap();
        assert_eq!(decoded, file, "{kind:?}, {frame:?}");
        assert!(decoded.to_bytes(Encoding::Raw).unwrap() == raw, "{kind:?}, {frame:?}");
        assert!(ShadowFile::from_bytes(&raw).unwrap().to_bytes(Encoding::Coded).unwrap() == coded);
    }
}

#[test]
fn depths_file_that_is_cut_or_changed_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("spheres.adumbra");
    let file = baked(GeneratedKind::Spheres, 64);
    let refused = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        ShadowFile::read(&path).is_err()
    };
    for encoding in [Encoding::Raw, Encoding::Coded] {
        let bytes = file.to_bytes(encoding).unwrap();
        for length in 0..bytes.len() {
            assert!(refused(&bytes[..length]), "{encoding:?}: {length}");
        }
        for at in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[at] ^= 1 << (at & 7);
            assert!(refused(&changed), "{encoding:?}: {at}");
        }
    }
}

#[test]
fn damaged_shapes_are_rejected_or_answer_consistently() {
    let good = TreeParts::of(&baked(GeneratedKind::City, 256).tree);
    let mut random = Random::for_batch(1, 0);
    let mut below = |n: usize| (random.unit() * n as f64) as usize;
    let (mut accepted, mut ranks) = (0, 0);
    for _ in 0..4000 {
        let mut damaged = good.clone();
        let mut code: Vec<&mut u32> = damaged.words_mut().collect();
        for _ in 0..1 + below(4) {
            let (at, shift) = (below(code.len()), 16 * below(2));
            let half = match below(4) {
                0 => below(1 << 16) as u32,
                1 => 0xffff,
                2 => *code[below(code.len())] & 0xffff,
                _ => *code[at] >> shift & 0xffff ^ 1 << below(16),
            };
            *code[at] = *code[at] & !(0xffff << shift) | half << shift;
        }
        let damaged = match damaged.tree() {
            Ok(damaged) => damaged,
            Err(fault) => {
                ranks += usize::from(fault.kind() == "Ranks");
                continue;
            }
        };
        accepted += 1;
        let size = damaged.size();
        for _ in 0..100 {
            let [i, j] = [0, 1].map(|a| below(size[a] as usize) as u32);
            let value = damaged.value(i, j);
            if let ColumnNode::Leaf { at, base } = damaged.place(i, j).0 {
                let of_leaf = damaged.shapes().leaf(at, base).values();
                assert_eq!(of_leaf[((j & 7) * 8 + (i & 7)) as usize], value, "({i}, {j})");
            }
        }
    }
    assert!(accepted > 300 && ranks > 10, "{accepted} accepted, {ranks} with ranks");
}
