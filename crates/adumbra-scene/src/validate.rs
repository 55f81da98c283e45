//! Checks shared by all loaders: degenerate triangles while loading, and the whole scene at the end.

use std::path::Path;

use crate::filter::Met;
use crate::{AlphaMode, EmptyReason, Error, LoadOptions, Result, Scene};

/// Rejects degenerate triangles and records enough about them to explain an empty scene.
#[derive(Debug, Default)]
pub(super) struct Sieve {
    degenerate: u64,
    first: Option<[f32; 3]>,
    spread: bool,
    /// Whether the default scene of a glTF file has no nodes.
    pub(super) empty_scene: bool,
    /// Which patterns of the name filter have matched.
    pub(super) met: Met,
    /// Whether the name filter dropped any triangles.
    pub(super) filtered: bool,
}

impl Sieve {
    /// Whether the triangle has nonzero area; if not, it is counted. Zero area means that the cross product,
    /// taken with 64-bit differences of the 32-bit coordinates, is exactly zero.
    pub(super) fn keeps(&mut self, p: [[f32; 3]; 3]) -> bool {
        let edge =
            |i: usize| -> [f64; 3] { std::array::from_fn(|a| f64::from(p[i][a]) - f64::from(p[0][a])) };
        let (u, v) = (edge(1), edge(2));
        let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        if cross != [0.0; 3] {
            return true;
        }
        self.degenerate += 1;
        let first = *self.first.get_or_insert(p[0]);
        self.spread |= p.iter().any(|&q| q != first);
        false
    }
}

/// Returns [`Error::NotFinite`] if the vertex is not finite.
pub(super) fn check_vertex(path: &Path, mesh: &str, index: u64, p: [f32; 3]) -> Result<()> {
    if p.iter().all(|c| c.is_finite()) {
        return Ok(());
    }
    Err(Error::NotFinite { path: path.to_owned(), what: format!("vertex {index} of mesh {mesh:?}") })
}

/// Completes a loaded scene: drops meshes without triangles, fills in the notes, and rejects a scene that
/// casts nothing, has no extent or overflows. Cost: one pass over the stored triangles and vertices, and
/// eight points per instance.
pub(super) fn finish(path: &Path, mut scene: Scene, sieve: &Sieve, options: &LoadOptions) -> Result<Scene> {
    scene.notes.degenerate_triangles = sieve.degenerate;
    let unmatched = sieve.met.unmatched(&options.filter);
    drop_empty_meshes(&mut scene);
    count_blended(&mut scene);
    let empty = |reason| Err(Error::NoTriangles { path: path.to_owned(), reason });
    if scene.instances.is_empty() {
        if sieve.degenerate > 0 && !sieve.spread {
            return Err(Error::ZeroExtent { path: path.to_owned() });
        }
        if scene.notes.skipped_movers > 0 {
            return empty(EmptyReason::AllAnimated { instances: scene.notes.skipped_movers });
        }
        if sieve.degenerate > 0 {
            return empty(EmptyReason::ZeroArea { triangles: sieve.degenerate });
        }
        if sieve.filtered && !options.filter.is_empty() {
            return empty(EmptyReason::Filtered { unmatched });
        }
        if sieve.empty_scene {
            return empty(EmptyReason::EmptyScene);
        }
        if !scene.notes.omissions.is_empty() {
            return empty(EmptyReason::OnlyOmitted { omissions: scene.notes.omissions });
        }
        return empty(EmptyReason::NoneStored);
    }
    let casts = scene.instances.iter().filter(|i| i.casts).any(|i| {
        let mesh = &scene.meshes[i.mesh as usize];
        mesh.triangle_materials.iter().any(|&m| scene.materials[m as usize].casts)
    });
    if !casts {
        return empty(EmptyReason::NoneCasts);
    }
    check_extent(path, &scene)?;
    scene.notes.unmatched_patterns = unmatched;
    scene.meshes.shrink_to_fit();
    scene.instances.shrink_to_fit();
    Ok(scene)
}

fn drop_empty_meshes(scene: &mut Scene) {
    let empty: Vec<bool> = scene.meshes.iter().map(|m| m.triangles.is_empty()).collect();
    scene.retain_meshes(|mesh| !empty[mesh]);
}

fn count_blended(scene: &mut Scene) {
    let blended: Vec<bool> =
        scene.materials.iter().map(|m| m.blended && matches!(m.alpha, AlphaMode::Mask { .. })).collect();
    let mut triangles = vec![0_u64; blended.len()];
    for &m in scene.meshes.iter().flat_map(|m| &m.triangle_materials) {
        triangles[m as usize] += 1;
    }
    let used = || blended.iter().zip(&triangles).filter(|&(&b, &n)| b && n > 0);
    scene.notes.blended_materials = used().count() as u64;
    scene.notes.blended_triangles = used().map(|(_, &n)| n).sum();
}

/// Checks that every placed vertex is finite, and that not all are the same point.
fn check_extent(path: &Path, scene: &Scene) -> Result<()> {
    let boxes: Vec<[[f32; 3]; 2]> = scene
        .meshes
        .iter()
        .map(|mesh| {
            let mut b = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
            for p in &mesh.positions {
                for a in 0..3 {
                    b[0][a] = b[0][a].min(p[a]);
                    b[1][a] = b[1][a].max(p[a]);
                }
            }
            b
        })
        .collect();
    let (mut first, mut spread) = (None, false);
    for instance in &scene.instances {
        let [low, high] = boxes[instance.mesh as usize];
        for corner in 0..8 {
            let p = std::array::from_fn(|a| if corner >> a & 1 == 0 { low[a] } else { high[a] });
            let p_world = instance.to_world(p);
            if !p_world.iter().all(|c| c.is_finite()) {
                let what = format!("a vertex as node {:?} places it", instance.name);
                return Err(Error::NotFinite { path: path.to_owned(), what });
            }
            spread |= *first.get_or_insert(p_world) != p_world;
        }
    }
    if spread { Ok(()) } else { Err(Error::ZeroExtent { path: path.to_owned() }) }
}
