//! The test vectors of the shadow file.

use std::error::Error;

use adumbra::ShadowFile;
use adumbra_papers::dag::build::convert::depths_of;

use super::flipped::flipped;
use super::headers::Files;
use super::{Known, Vector, bytes_of};
use crate::broken::Broken;

/// Returns the vectors whose columns are lit and then shadowed.
pub(super) fn valid(known: &[Known]) -> Result<Vec<Vector>, Box<dyn Error>> {
    let made = |Known { grid, dag }: &Known| {
        let file = ShadowFile::new(grid.grid, grid.settings, depths_of(dag, grid.root_level)?);
        let mut bytes = Vec::new();
        file.write_to(&mut bytes)?;
        Ok(Vector { name: format!("{}_depths", grid.name), bytes, answers: grid.answers() })
    };
    known.iter().filter(|known| known.is_monotone()).map(made).collect()
}

/// Returns files with one fault each.
pub(super) fn broken(valid: &[Vector], graphs: &[Vector]) -> Result<Vec<Broken>, Box<dyn Error>> {
    let small = bytes_of("example_8_depths", valid)?;
    let [sphere, cliff] = [bytes_of("sphere_depths", valid)?, bytes_of("cliff_depths", valid)?];
    let files = Files { magic: "ADUMBRA", later: "version 4", small: small.clone(), full: cliff.clone() };
    let mut all = files.broken();
    let s = || small.clone();
    let mut add = |name, error, names, bytes| all.push(Broken { name, error, fault: None, names, bytes });
    // The layouts of earlier versions, whose headers are those of graph files.
    let earlier = |name| bytes_of(name, graphs).map(|graph| graph.put(0, b"ADUMBRA\n").put_word(8, 3));
    add("layout_plain", "Layout", "layout plain", earlier("example_8")?.sealed());
    add("layout_packed", "Layout", "layout packed", earlier("example_8_packed")?.sealed());
    add("layout_in_version_1", "HeaderField", "reserved", s().put_word(8, 1).sealed());
    add("frame_in_version_2", "HeaderField", "reserved", s().put_word(8, 2).put_word(356, 1).sealed());

    let (name, fault) = ("depths_root_level", Some("RootLevel"));
    let bytes = s().put_word(36, 6).sealed();
    all.push(Broken { name, error: "Depths", fault, names: "root level 6", bytes });
    all.extend(flipped(
        "Depths",
        &[sphere, cliff],
        |bytes| ShadowFile::from_bytes(bytes).err()?.fault(),
        &[
            ("depths_order", "Order", "which is not before it"),
            ("depths_end", "End", "past the end of the code"),
            ("depths_wide", "Wide", "refers to wide entry"),
            ("depths_bits", "Bits", "invalid bits"),
            ("depths_ranks", "Ranks", "above its last"),
        ],
    )?);
    Ok(all)
}
