//! The test vectors of the shadow file.

use std::error::Error;

use adumbra::layout::depths::page::BUNDLE_PAGES;
use adumbra::layout::depths::{DepthTree, TreeBuilder};
use adumbra::{Encoding, Frame, LightGrid, ShadowFile};
use adumbra_papers::dag::LeafMasks;
use adumbra_papers::dag::build::convert::depths_of;

use super::grids::{self, Grid, REPEATED_PAGE, Voxels};
use super::shadow_bytes::ShadowBytes;
use super::{Known, Vector, flipped};
use crate::broken::Broken;

/// Voxels in the form that the converter reads.
struct Masks<'g> {
    size: [u32; 3],
    lit: &'g Voxels,
}

impl LeafMasks for Masks<'_> {
    fn size(&self) -> [u32; 3] {
        self.size
    }

    fn look_up(&self, x: u32, y: u32, z: u32) -> u64 {
        (0..64).fold(0, |mask, bit| mask | u64::from((self.lit)(x + bit % 8, y + bit / 8, z)) << bit)
    }

    /// No block larger than a column is known to be uniform.
    fn end_level(&self, _: u32, _: u32, _: u32) -> u32 {
        0
    }
}

/// Grids that also have a coded vector: one with several bundles, one with several levels, and one with all
/// numbers of depths.
const ALSO_CODED: [&str; 3] = ["many_pages", "levels", "many_depths"];

/// Returns the vectors of the grids whose columns are lit and then shadowed, and of those that only a
/// quadtree can hold.
pub(super) fn valid(known: &[Known], large: &[Vec<Grid>]) -> Result<Vec<Vector>, Box<dyn Error>> {
    let small =
        known.iter().filter(|known| known.is_monotone()).map(|known| std::slice::from_ref(&known.grid));
    let raw = small.chain(large.iter().map(Vec::as_slice)).map(|levels| vector(levels, Encoding::Raw));
    let is_coded = |levels: &&Vec<Grid>| ALSO_CODED.contains(&levels[0].name);
    let coded = large.iter().filter(is_coded).map(|levels| vector(levels, Encoding::Coded));
    raw.chain(coded).chain([Encoding::Raw, Encoding::Coded].map(repeated)).collect()
}

/// Returns a vector whose pages all store the same words. A writer that merges equal shapes would store them
/// once. In coded form, the bundle ends with zeros.
fn repeated(encoding: Encoding) -> Result<Vector, Box<dyn Error>> {
    let grid = grids::repeated();
    let [_, _, depth] = grid.grid.size;
    let one =
        depths_of(&Masks { size: [REPEATED_PAGE, REPEATED_PAGE, depth], lit: &grid.lit }, grid.root_level)?;
    let mut builder = TreeBuilder::new(grid.grid.size, Vec::new());
    builder.add([0, 0], &[one.page([0, 0]); BUNDLE_PAGES]);
    file_of(&grid, builder.finish()?, Vec::new(), encoding)
}

/// Returns the vector of these levels, the finest first.
fn vector(levels: &[Grid], encoding: Encoding) -> Result<Vector, Box<dyn Error>> {
    let tree = |grid: &Grid| {
        let size = grid.grid.size;
        depths_of(&Masks { size, lit: &grid.lit }, grid.root_level)
    };
    let Some((finest, coarser)) = levels.split_first() else { return Err("a vector has a level".into()) };
    let coarser: Vec<_> =
        coarser.iter().map(|grid| Ok((grid.grid, tree(grid)?))).collect::<Result<_, Box<dyn Error>>>()?;
    file_of(finest, tree(finest)?, coarser, encoding)
}

/// Returns the vector of a grid's tree and coarser levels.
fn file_of(
    finest: &Grid,
    tree: DepthTree,
    coarser: Vec<(LightGrid, DepthTree)>,
    encoding: Encoding,
) -> Result<Vector, Box<dyn Error>> {
    let file = ShadowFile::new(finest.grid, finest.settings, tree).with_coarser(coarser);
    let coded = if encoding == Encoding::Coded { "_coded" } else { "" };
    Ok(Vector {
        name: format!("{}{coded}_depths", finest.name),
        bytes: file.to_bytes(encoding)?,
        answers: finest.answers(),
    })
}

fn bytes_of(name: &str, vectors: &[Vector]) -> Result<ShadowBytes, String> {
    let vector = vectors.iter().find(|v| v.name == name).ok_or_else(|| format!("no vector {name}"))?;
    Ok(ShadowBytes(vector.bytes.clone()))
}

/// Returns files with one fault each.
pub(super) fn broken(valid: &[Vector]) -> Result<Vec<Broken>, Box<dyn Error>> {
    let small = bytes_of("example_8_depths", valid)?;
    let many = bytes_of("many_pages_depths", valid)?;
    let levels = bytes_of("levels_depths", valid)?;
    let mut all = headers(&small, &levels);
    all.extend(frames_of_levels(&levels)?);
    all.extend(parts(&small, &many, &levels));
    let coded = ["many_pages_coded_depths", "levels_coded_depths"].map(|name| bytes_of(name, valid));
    let [many_coded, levels_coded] = coded;
    all.extend(coded_parts(&many, &many_coded?, &levels_coded?));
    all.extend(zeros(&bytes_of("repeated_coded_depths", valid)?));
    let flips = [bytes_of("sphere_depths", valid)?, bytes_of("cliff_depths", valid)?, many];
    all.extend(flipped::flipped(
        "Depths",
        &flips,
        |bytes| ShadowFile::from_bytes(bytes).err()?.fault(),
        &[
            ("depths_root", "Root", "neither in it nor in the common section"),
            ("depths_order", "Order", "leads neither to an earlier shape"),
            ("depths_end", "End", "extends past its end"),
            ("depths_bits", "Bits", "invalid bits"),
            ("depths_ranks", "Ranks", "above its last"),
            ("depths_overlap", "Overlap", "overlap"),
        ],
    )?);
    Ok(all)
}

/// Faults of header and directory.
fn headers(small: &ShadowBytes, levels: &ShadowBytes) -> Vec<Broken> {
    let (s, l) = (|| small.clone(), || levels.clone());
    let nan = f64::NAN;
    let mut all = Vec::new();
    let mut add = |name, error, names, bytes| all.push(Broken { name, error, fault: None, names, bytes });

    add("empty", "Truncated", "header", Vec::new());
    add("magic", "Magic", "ADUMBRA", s().put(0, b"GIF89a\0\0").0);
    add("copied_as_text", "Magic", "ADUMBRA", s().put(7, b"\r").0);
    add("future_version", "FutureVersion", "version 5", s().put_word(8, 5).sealed());
    add("version_0", "HeaderField", "version", s().put_word(8, 0).sealed());
    add("version_3", "HeaderField", "version", s().put_word(8, 3).sealed());
    add("header_length", "HeaderField", "header_bytes", s().put_word(12, 384).sealed());
    add("cut_in_header", "Truncated", "header", s().cut(200).0);
    add("header_damaged", "HeaderChecksum", "header", s().put_word(20, 16).0);
    add("unknown_flag", "HeaderField", "flags", s().put_word(16, 1 << 6).sealed());
    add("resolution_0", "HeaderField", "resolution", s().put_word(20, 0).sealed());
    add("grids_0", "HeaderField", "grids", s().put_word(24, 0).sealed_header());
    add("grids_9", "HeaderField", "grids", s().put_word(24, 9).sealed_header());
    add("encoding_unknown", "HeaderField", "encoding", s().put_word(28, 7).sealed_header());
    add("thickness_negative", "HeaderField", "thickness", s().put_f64(32, -0.1).sealed());
    add("bias_infinite", "HeaderField", "bias", s().put_f64(48, f64::NEG_INFINITY).sealed());
    add("bounds_without_flag", "HeaderField", "bounds", s().put_f64(64, 1.0).sealed());
    add("bounds_inverted", "HeaderField", "bounds", s().put_word(16, 0x13).put_f64(64, 1.0).sealed());
    add("region_side", "HeaderField", "region", s().put_word(144, 3000).sealed());
    add("region_without_side", "HeaderField", "region", s().put_word(148, 1).sealed());
    add("reserved_of_header", "HeaderField", "reserved", s().put_word(200, 1).sealed());
    add("file_bytes", "HeaderField", "file_bytes", s().put_word(136, 768).sealed());
    add("file_bytes_small", "HeaderField", "file_bytes", s().put_word(136, 300).sealed());

    // The first entry of the directory begins at byte 256, the second at 512.
    let grid = |at: usize| 256 + at;
    add("cut_in_directory", "Truncated", "directory", s().cut(300).0);
    add("directory_damaged", "SectionChecksum", "directory", s().put_word(grid(4), 9).0);
    add(
        "more_grids_than_there_are",
        "Truncated",
        "directory",
        s().put_word(24, 8).put_word(136, 5000).sealed_header(),
    );
    add("size_0", "HeaderField", "size", s().put_word(grid(4), 0).sealed());
    add("level_of_first", "HeaderField", "level", s().put_word(grid(12), 1).sealed());
    add("level_twice", "HeaderField", "level", l().put_word(512 + 12, 0).sealed());
    add("voxel_size_0", "HeaderField", "voxel_size", s().put_f64(grid(16), 0.0).sealed());
    add("voxel_size_infinite", "HeaderField", "voxel_size", s().put_f64(grid(16), f64::INFINITY).sealed());
    add("voxel_size_of_level", "HeaderField", "voxel_size", l().put_f64(512 + 16, 3.0).sealed());
    add("sun_not_unit", "HeaderField", "sun", s().put_f64(grid(32), 1.001).sealed());
    add("sun_below", "HeaderField", "sun", s().put_f64(grid(32), -1.0).sealed());
    add("corner_nan", "HeaderField", "corner", s().put_f64(grid(48), nan).sealed());
    add("frame_unknown", "HeaderField", "frame", s().put_word(grid(144), 2).sealed());
    add("reserved_after_frame", "HeaderField", "reserved", s().put_word(grid(148), 2).sealed());
    add("yaw_of_light", "HeaderField", "yaw", s().put_f64(grid(152), 0.5).sealed());
    add("yaw_nan", "HeaderField", "yaw", s().put_word(grid(144), 1).put_f64(grid(152), nan).sealed());
    let turned = s().put_word(grid(144), 1).put_f64(grid(152), 0.5);
    add("yaw_of_other_axes", "HeaderField", "axes", turned.sealed());
    add("axes_skew", "HeaderField", "axes", s().put_f64(grid(80), 1e-6).sealed());
    add("axes_left_handed", "HeaderField", "axes", s().put_f64(grid(72), -1.0).sealed());
    add("reserved_of_grid", "HeaderField", "reserved", s().put_word(grid(252), 1).sealed());
    add("checksum_of_bundles", "HeaderField", "checksum", s().put_word(grid(224), 1).sealed_front());
    all
}

/// Levels whose frame is not that of the first grid.
fn frames_of_levels(levels: &ShadowBytes) -> Result<Vec<Broken>, Box<dyn Error>> {
    let file = ShadowFile::from_bytes(&levels.0)?;
    let LightGrid { sun, voxel_size, corner, size, .. } = file.grid;
    let frames =
        [("frame_of_first_level", Frame::Light), ("yaw_of_first_level", Frame::Oblique { yaw_radians: 0.5 })];
    let broken = frames.map(|(name, frame)| {
        let grid = LightGrid::new(sun, frame, voxel_size, corner, size);
        let alone = ShadowFile::new(grid, file.settings, (*file.tree).clone()).to_bytes(Encoding::Raw)?;
        // Replace the placement of the grid: its directory entry up to its sections.
        let bytes = levels.clone().put(256, &alone[256..416]).sealed();
        Ok(Broken { name, error: "HeaderField", fault: None, names: "that of the first grid", bytes })
    });
    broken.into_iter().collect()
}

/// Faults of the parts behind the directory.
fn parts(small: &ShadowBytes, many: &ShadowBytes, levels: &ShadowBytes) -> Vec<Broken> {
    let (s, m, l) = (|| small.clone(), || many.clone(), || levels.clone());
    let grid = |at: usize| 256 + at;
    let damaged = |at: usize| m().put(at, &[many.0[at] ^ 0x5A]).0;
    let mut all = Vec::new();
    let mut add = |name, error, names, bytes| all.push(Broken { name, error, fault: None, names, bytes });

    add("table_offset", "SectionBounds", "table", s().put_word(grid(160), 0).sealed_front());
    add("table_length", "SectionBounds", "table", s().put_word(grid(168), 48).sealed_front());
    add("common_offset", "SectionBounds", "common section", s().put_word(grid(184), 384).sealed_front());
    add(
        "common_far_away",
        "SectionBounds",
        "common section",
        s().put_word(grid(188), 0x7FFF_FFFF).sealed_front(),
    );
    add("bundles_offset", "SectionBounds", "bundles", s().put_word(grid(208), 512).sealed_front());
    add("bundles_huge", "HeaderField", "file_bytes", s().put_word(grid(220), 0x1000_0000).sealed_front());
    add("size_of_another", "SectionBounds", "table", s().put_word(grid(0), 8192).sealed_front());
    add("cut_in_table", "Truncated", "table of level 0", m().cut(many.table(0) + 20).0);
    add("cut_in_common", "Truncated", "common section of level 0", m().cut(many.common(0) + 5).0);
    add("cut_last_byte", "Truncated", "bundles of level 0", m().cut(many.0.len() - 1).0);
    add("goes_on", "TrailingBytes", "end", [s().0, vec![0]].concat());
    add("table_damaged", "SectionChecksum", "table of level 0", damaged(many.table(0) + 20));
    add("common_damaged", "SectionChecksum", "common section of level 0", damaged(many.common(0)));
    add("bundle_damaged", "SectionChecksum", "bundle 0 of level 0", damaged(many.bundle(0, 0) + 200));
    add("last_level_damaged", "SectionChecksum", "of level 2", {
        let at = levels.common(2);
        l().put(at, &[levels.0[at] ^ 1]).0
    });
    add("bundles_swapped", "SectionChecksum", "bundle 0 of level 0", m().swapped(0, 0, 1));
    let table = many.table(0);
    add("bundle_of_no_bytes", "Bundle", "bundle 0 of level 0", m().put_word(table, 0).sealed_front());
    add(
        "bundle_short",
        "Bundle",
        "bundle 0 of level 0",
        m().put_word(table, 100).put_word(table + 4, 100).sealed_front(),
    );
    add("bundle_raw_length", "Bundle", "bundle 0 of level 0", m().put_word(table + 4, 4).sealed_front());
    add("bundle_longer_than_all", "Bundle", "table of level 0", {
        let longer = many.word(table) + 400;
        m().put_word(table, longer).put_word(table + 4, longer).sealed_front()
    });
    add("table_flags", "HeaderField", "reserved", m().put_word(table + 20, 2).sealed());
    let bundle = many.bundle(0, 0);
    let words = many.word(bundle + 8);
    add(
        "page_longer_than_its_bundle",
        "Bundle",
        "words of pages",
        m().put_word(bundle + 8, words + 1).sealed(),
    );
    add("page_outside_the_grid", "Bundle", "outside the grid", {
        // The last slot of the last bundle.
        let last = many.bundle(0, many.bundles(0) - 1);
        m().put_word(last + 4 * 46, 5).sealed()
    });
    add("range_of_depths", "Bundle", "range of depths", m().put_word(table + 12, 0).sealed());
    add(
        "range_of_another",
        "Bundle",
        "range of depths",
        m().put_word(table + 20, 1 - many.word(table + 20)).sealed(),
    );
    add("bytes_for_nothing", "Bundle", "one depth", s().uniform_with_bytes());
    all
}

/// Faults of the zeros at the end of a bundle.
fn zeros(repeated: &ShadowBytes) -> Vec<Broken> {
    let bundle = repeated.last_bundle();
    let with = |name, error, bytes: &[u8]| Broken {
        name,
        error,
        fault: None,
        names: "bundle 0 of level 0",
        bytes: repeated.clone().with_last_bundle(bytes).sealed(),
    };
    let but_two = &bundle[..bundle.len() - 2];
    vec![
        with("coded_zeros_cut", "Bundle", but_two),
        with("coded_zeros_go_on", "Coded", &[&bundle[..], &[0, 0]].concat()),
        with("coded_zeros_end_with_1", "Coded", &[but_two, &[0, 1]].concat()),
    ]
}

/// Faults of coded parts, and of lengths that only coded parts may have.
fn coded_parts(raw: &ShadowBytes, many: &ShadowBytes, levels: &ShadowBytes) -> Vec<Broken> {
    let m = || many.clone();
    let table = many.table(0);
    let grid = |at: usize| 256 + at;
    let mut all = Vec::new();
    let mut add = |name, error, names, bytes| all.push(Broken { name, error, fault: None, names, bytes });

    let (common, last) = (many.stored_common(0), many.last_bundle());
    let some = |bytes: &[u8], length: usize| bytes[..length].to_vec();
    add(
        "common_raw_length",
        "SectionBounds",
        "raw length",
        raw.clone().put_word(grid(232), 4).sealed_front(),
    );
    add("coded_common_raw_length_huge", "SectionBounds", "raw length", {
        let most = 16 * common.len() as u32;
        m().put_word(grid(232), most + 4).sealed_front()
    });
    add("coded_common_raw_length", "Coded", "common section of level 0", {
        let length = many.word(grid(232));
        m().put_word(grid(232), length + 4).sealed_front()
    });
    add("coded_common_cut", "Coded", "common section of level 0", {
        m().with_common(&some(&common, common.len() - 2), many.word(grid(232))).sealed()
    });
    add("coded_common_of_another_file", "Coded", "bundle 0 of level 0", {
        m().with_common(&levels.stored_common(0), levels.word(grid(232))).sealed()
    });
    add("coded_bundle_raw_length_huge", "Bundle", "bundle 0 of level 0", {
        let most = 192 + 16 * many.word(table);
        m().put_word(table + 4, most + 4).sealed_front()
    });
    add("coded_bundle_raw_length", "Coded", "bundle 0 of level 0", {
        let length = many.word(table + 4);
        m().put_word(table + 4, length - 4).sealed_front()
    });
    add(
        "coded_bundle_cut",
        "Coded",
        "bundle 3 of level 0",
        m().with_last_bundle(&some(&last, last.len() - 2)).sealed(),
    );
    add(
        "coded_bundle_goes_on",
        "Coded",
        "bundle 3 of level 0",
        m().with_last_bundle(&[&last[..], &[0]].concat()).sealed(),
    );
    add("coded_bundle_of_another_place", "Coded", "bundle 3 of level 0", {
        let first = many.bundle(0, 0);
        let other = &many.0[first..first + many.word(table) as usize];
        m().with_last_bundle(other).sealed()
    });
    all
}
