//! Tests of the packed layout's nodes: worked values, and look-ups in single nodes.

use super::node::{Cube, Inner, Target, high_bits};
use super::{POOL_WORDS, PackedDag};
use crate::dag::descend::{Descend, Descent};

#[test]
fn packed_worked_values() {
    // The first worked value of the module's documentation.
    let inner = Inner {
        codes: 0x8c4,
        targets: [
            Target::Follows,
            Target::Pool(2),
            Target::Pool(2),
            Target::Near(5),
            Target::Follows,
            Target::Follows,
            Target::Follows,
            Target::Follows,
        ],
    };
    let mut units = Vec::new();
    inner.write(4, &mut units);
    assert_eq!(units, [0x08c4, 0x0402, 0x0402, 0x0005]);
    assert_eq!(Inner::read(&units, 4), Ok(inner));

    // Eight pointers with one slot each: the eighth must not be mistaken for the pointer without a slot.
    let eight = Inner { codes: 0x6db, targets: std::array::from_fn(|p| Target::Pool(p as u32)) };
    let mut units = Vec::new();
    eight.write(4, &mut units);
    assert_eq!(units, [0x76db, 0x400, 0x401, 0x402, 0x403, 0x404, 0x405, 0x406, 0x407]);
    assert_eq!(Inner::read(&units, 4), Ok(eight));
    let packed = PackedDag { top: vec![0; POOL_WORDS], units, ..PackedDag::default() };
    for c in 0..8 {
        assert!(
            matches!(packed.child(0, 4, c >> 2 << 3, (c >> 1 & 1) << 3, (c & 1) << 3), Descent::Into(p) if p == c)
        );
    }

    // The second worked value, and a wide pointer of each width.
    let mask = 0xff0f_0f0f_0f0f_0f0f;
    let cube = Cube::from_leaf_masks(&[u64::MAX, u64::MAX, mask, mask, mask, 0, 0, 0]).unwrap();
    let mut units = Vec::new();
    cube.write(&mut units);
    assert_eq!(units, [0x0324, 0x0f0f, 0x0f0f, 0x0f0f, 0xff0f]);

    let far = Inner { codes: 4, targets: [Target::Pool(0xabcde); 8] };
    for (high_bits, expected) in [
        (4, &[0xf004, 0x0a01, 0xbcde][..]),
        (8, &[0xf004, 0x0a01, 0xbcde][..]),
        (16, &[0xf004, 0x0001, 0x000a, 0xbcde][..]),
    ] {
        let mut units = Vec::new();
        far.write(high_bits, &mut units);
        assert_eq!(units, expected, "{high_bits}");
        assert_eq!(Inner::read(&units, high_bits).unwrap().pointers(), far.pointers());
        units[1] |= 0x8000;
        assert!(Inner::read(&units, high_bits).is_err() || high_bits == 8);
    }
}

#[test]
fn packed_wide_slots_address_the_whole_pool() {
    // Eight pointers, wide ones among narrow ones, in pools of up to 2^20, up to 2^24 and more units.
    for (pool_units, last) in [(1 << 20, 0xf_fffe), (1 << 24, 0xff_fffe), (1 << 30, 0x3fff_fffe)] {
        let targets: [u32; 8] = std::array::from_fn(|p| if p % 3 == 0 { p as u32 } else { last - p as u32 });
        let inner = Inner { codes: 0x6db, targets: targets.map(Target::Pool) };
        let high_bits = high_bits(pool_units);
        let mut units = Vec::new();
        inner.write(high_bits, &mut units);
        assert_eq!(Inner::read(&units, high_bits), Ok(inner));
        let mut top = vec![0; POOL_WORDS];
        top[1] = pool_units;
        let packed = PackedDag { top, units, ..PackedDag::default() };
        for (c, &target) in (0_u32..).zip(&targets) {
            let step = packed.child(0, 4, c >> 2 << 3, (c >> 1 & 1) << 3, (c & 1) << 3);
            assert!(matches!(step, Descent::Into(unit) if unit == target), "{pool_units} {c}");
        }
    }
}

#[test]
fn packed_bit_planes_match_masks() {
    // Each mask has eight voxels fewer lit than the one before, and none is shared. Eight masks take four
    // planes. Two masks take as many units as two planes, so they are not stored as planes.
    for count in 1..=8_u32 {
        let leaf_masks: [u64; 8] = std::array::from_fn(|k| u64::MAX << (8 * (k as u32).min(count - 1) + 3));
        let cube = Cube::from_leaf_masks(&leaf_masks).unwrap();
        assert_eq!((cube.mask_count() as u32, cube.in_planes()), (count, count > 2));
        let mut units = Vec::new();
        cube.write(&mut units);
        assert_eq!(units.len() as u32, cube.units());
        let (read, length) = Cube::read(&units, &[]).unwrap();
        assert_eq!((read.leaf_masks(), length), (leaf_masks, units.len() as u32));
        let packed = PackedDag { units, ..PackedDag::default() };
        for k in 0..8 {
            assert_eq!(packed.leaf_mask_of_cube(0, k), leaf_masks[k as usize], "{count} {k}");
        }
    }
}
