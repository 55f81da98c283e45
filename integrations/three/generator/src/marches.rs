//! Answers of marches through the test vectors for other suns than theirs, which `tests/unit/march.test.ts`
//! compares with the package's.

use std::path::Path;

use adumbra::grid::vec3::normalize;
use adumbra::{Filter, PathSampler, ShadowFile};

use crate::Generated;

/// Pairs of files, below `test_vectors`: the file that is looked up first, and the other file.
const PAIRS: [[&str; 2]; 6] = [
    ["valid/levels_depths", "valid/many_pages_depths"],
    ["valid/low_sun_tall_depths", "valid/low_sun_tall_depths"],
    ["valid/many_pages_depths", "valid/levels_depths"],
    ["valid/odd_sizes_depths", "valid/slopes_depths"],
    ["valid/slopes_depths", "valid/odd_sizes_depths"],
    ["valid/upright_turned_low_depths", "valid/upright_turned_low_depths"],
];

/// How far the sun is from that of the first file, before it is scaled to length 1.
const ASIDE: [f64; 3] = [0.06, 0.02, -0.04];

/// For how many voxels a ray must be hidden from both files to be taken to meet something.
const DARK_AFTER_VOXELS: u32 = 2;

/// Points of each pair.
const POINTS: usize = 100;

/// Returns a JSON list: for each pair its files; when hidden rays are dark; the sun; points and normals, as
/// 32-bit numbers; and the visibilities with filters of 1 and 5.
///
/// # Errors
/// Returns the crate's message if a file cannot be read or marched through.
pub fn golden(vectors: &Path) -> Result<Generated, String> {
    let rows: Result<Vec<String>, String> = PAIRS.iter().map(|names| pair(vectors, *names)).collect();
    Ok(Generated { name: "marches.json".to_owned(), text: format!("[\n{}\n]\n", rows?.join(",\n")) })
}

fn pair(vectors: &Path, names: [&str; 2]) -> Result<String, String> {
    let read =
        |name: &str| ShadowFile::read(vectors.join(format!("{name}.adumbra"))).map_err(|e| e.to_string());
    let mut files = [read(names[0])?, read(names[1])?];
    files[0].settings.dark_after_voxels = DARK_AFTER_VOXELS;
    let own = files[0].grid.sun.towards();
    let sun = normalize(std::array::from_fn(|a| own[a] + ASIDE[a]));
    let points: Vec<[[f32; 3]; 2]> = points(&files[0]).collect();
    let mut answers = Vec::new();
    for filter in [Filter::Nearest, Filter::Box5] {
        let sampler = PathSampler::new([&files[0], &files[1]], sun, filter).ok_or("the sun is too far")?;
        let look_up =
            |[p, normal]: &[[f32; 3]; 2]| sampler.look_up(p.map(f64::from), Some(normal.map(f64::from)));
        answers.push(points.iter().map(look_up).collect::<Vec<_>>());
    }
    Ok(format!(
        "{{\"files\": {names:?}, \"darkAfterVoxels\": {DARK_AFTER_VOXELS}, \"sun\": {sun:?},\n\"points\": {points:?},\n\"answers\": {answers:?}}}"
    ))
}

/// Returns points around the depths at which columns switch, with a normal each.
fn points(file: &ShadowFile) -> impl Iterator<Item = [[f32; 3]; 2]> + '_ {
    let mut state = 1_u64;
    let mut random = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f64 / f64::from(1 << 24)
    };
    (0..POINTS).map(move |_| {
        let [x, y] = [0, 1].map(|a| random() * f64::from(file.grid.size[a]));
        let depth = f64::from(file.tree.value(x as u32, y as u32).min(file.grid.size[2]));
        let p = file.grid.to_world([x, y, depth + 12.0 * (random() - 0.4)]);
        let normal = normalize([random() - 0.5, random() - 0.2, random() - 0.5]);
        [p, normal].map(|vector| vector.map(|c| c as f32))
    })
}
