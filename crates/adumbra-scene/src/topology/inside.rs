//! Finds the shells that are inside solids by signed ray crossings. All shells in a solid are tested in one
//! pass over its triangles.
//!
//! The ray runs almost along +Y, with an irregular shear so that it hits no edge of an axis-aligned model.
//! Points are first sheared onto a plane, identically for every use of a vertex, and the side of an edge is
//! antisymmetric in its ends even after rounding. Adjacent triangles therefore agree about a ray that passes
//! between them.

use crate::topology::{Component, Mesh, PartBounds, corners};
use adumbra::grid::vec3::{cross, dot};

/// The ray's slope in x and z per unit of y.
const SHEAR: [f64; 2] = [0.007_320_508_075_688_772, 0.004_142_135_623_730_951];

/// Solids are scanned in blocks of this many.
const BLOCK: usize = 64;

/// A mesh cut into components.
pub(super) struct Components<'a> {
    pub(super) mesh: &'a Mesh,
    /// Component c has `members[starts[c]..starts[c + 1]]`.
    pub(super) starts: &'a [u32],
    pub(super) members: &'a [u32],
    pub(super) boxes: &'a [PartBounds],
}

impl Components<'_> {
    fn triangles(&self, component: u32) -> &[u32] {
        let c = component as usize;
        &self.members[self.starts[c] as usize..self.starts[c + 1] as usize]
    }
}

/// A sheared point of a shell: `u` and `v` across the ray, `height` along it.
#[derive(Clone, Copy)]
struct Probe {
    u: f64,
    v: f64,
    height: f64,
    shell: u32,
    winding: i64,
}

/// Those of `shells` that are inside one of the components already marked solid.
///
/// Cost: box tests first, by blocks of solids sorted along x. Then, for each solid, one pass over its
/// triangles, each tested against the probes in its range of u.
pub(super) fn shells_inside_solids(
    parts: &Components<'_>,
    components: &[Component],
    shells: &[u32],
) -> Vec<u32> {
    let mut found = Vec::new();
    for (solid, mut probes) in candidates(parts, components, shells) {
        probes.sort_unstable_by(|a, b| a.u.total_cmp(&b.u));
        for &t in parts.triangles(solid) {
            count_crossings(corners(parts.mesh, t).map(shear), &mut probes);
        }
        found.extend(probes.iter().filter(|p| p.winding > 0).map(|p| p.shell));
    }
    found.sort_unstable();
    found.dedup();
    found
}

/// For each solid, the probes of the shells whose boxes are strictly inside its box.
fn candidates(parts: &Components<'_>, components: &[Component], shells: &[u32]) -> Vec<(u32, Vec<Probe>)> {
    if shells.is_empty() {
        return Vec::new();
    }
    let low_x = |c: u32| parts.boxes[c as usize][0][0];
    let high_x = |c: u32| parts.boxes[c as usize][1][0];
    let mut solids: Vec<u32> =
        (0..components.len() as u32).filter(|&c| components[c as usize].solid).collect();
    solids.sort_unstable_by(|&a, &b| low_x(a).total_cmp(&low_x(b)));
    let block_highs: Vec<f32> =
        solids.chunks(BLOCK).map(|b| b.iter().fold(f32::NEG_INFINITY, |m, &c| m.max(high_x(c)))).collect();
    let mut probes_of_solid = vec![Vec::new(); solids.len()];
    for &shell in shells {
        let inner = &parts.boxes[shell as usize];
        let mut probe = None;
        for (b, block) in solids.chunks(BLOCK).enumerate() {
            if low_x(block[0]) >= inner[0][0] {
                break;
            }
            if block_highs[b] <= inner[1][0] {
                continue;
            }
            for (s, &solid) in block.iter().enumerate() {
                let outer = &parts.boxes[solid as usize];
                if (0..3).all(|a| outer[0][a] < inner[0][a] && inner[1][a] < outer[1][a]) {
                    let probe = probe.get_or_insert_with(|| probe_of(parts, shell));
                    probes_of_solid[b * BLOCK + s].push(*probe);
                }
            }
        }
    }
    solids.into_iter().zip(probes_of_solid).filter(|(_, probes)| !probes.is_empty()).collect()
}

/// The centroid of the shell's largest triangle, which is less likely than a corner to touch surrounding
/// geometry.
fn probe_of(parts: &Components<'_>, shell: u32) -> Probe {
    let mut best = (f64::NEG_INFINITY, [[0.0; 3]; 3]);
    for &t in parts.triangles(shell) {
        let [a, b, c] = corners(parts.mesh, t);
        let n = cross(sub(b, a), sub(c, a));
        // If areas are equal, the smaller corners win, so that the order of the triangles does not matter.
        let area = dot(n, n);
        if area > best.0 || area == best.0 && [a, b, c] < best.1 {
            best = (area, [a, b, c]);
        }
    }
    let [a, b, c] = best.1;
    let [u, height, v] = shear([0, 1, 2].map(|i| (a[i] + b[i] + c[i]) / 3.0));
    Probe { u, v, height, shell, winding: 0 }
}

/// Updates the winding of the probes below a triangle: +1 if its front faces up the ray, otherwise -1.
fn count_crossings(triangle: [[f64; 3]; 3], probes: &mut [Probe]) {
    let us = triangle.map(|p| p[0]);
    let first = probes.partition_point(|p| p.u < us[0].min(us[1]).min(us[2]));
    let highest = us[0].max(us[1]).max(us[2]);
    for probe in probes[first..].iter_mut().take_while(|p| p.u <= highest) {
        let [a, b, c] = triangle.map(|p| [p[0] - probe.u, p[2] - probe.v]);
        let sides = [side(b, c), side(c, a), side(a, b)];
        let positive = sides.iter().all(|&s| s > 0.0);
        if !positive && !sides.iter().all(|&s| s < 0.0) {
            continue;
        }
        let [h0, h1, h2] = triangle.map(|p| p[1] - probe.height);
        let above = (sides[0] * h0 + sides[1] * h1 + sides[2] * h2) / (sides[0] + sides[1] + sides[2]);
        if above > 0.0 {
            // Counter-clockwise in (x, z) faces down, as z × x = y.
            probe.winding += if positive { -1 } else { 1 };
        }
    }
}

/// On which side of the edge from `a` to `b` the origin is; exactly opposite for the edge from `b` to `a`.
fn side(a: [f64; 2], b: [f64; 2]) -> f64 {
    let area = a[0] * b[1] - a[1] * b[0];
    if area != 0.0 {
        area
    } else {
        let across = if a[1] != b[1] { b[1] - a[1] } else { a[0] - b[0] };
        f64::MIN_POSITIVE.copysign(across)
    }
}

/// Moves a point along x and z so that the ray becomes vertical.
fn shear(p: [f64; 3]) -> [f64; 3] {
    [p[0] - SHEAR[0] * p[1], p[1], p[2] - SHEAR[1] * p[1]]
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
