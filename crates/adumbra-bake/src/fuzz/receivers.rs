//! Compares look-ups at receivers with rays.
//!
//! The guarantee: a look-up samples the column of a texel at the depth of the receiver's plane at the texel's
//! centre, less the receiver's bias, and it finds what a ray from that point to the sun finds. `truth.rs`
//! defines where nothing is guaranteed. `Receivers::Static` guarantees as much, because its columns hold for
//! every static surface and only surfaces are looked up here. So do `assume_ground`, which frees only columns
//! that no surface samples, and `closed_regions = false`, which makes solids open.

use crate::fuzz::baked::BakedPair;
use crate::fuzz::dice::Dice;
use crate::fuzz::totals::{Skip, Totals};
use crate::fuzz::truth::Truth;
use adumbra::grid::vec3::{cross, dot};
use adumbra::layout::depths::DepthTree;
use adumbra::query::{FIXED_BITS, FixedReceiver, GRADIENT_BITS, receiver};
use adumbra::{Bias, Filter};
use adumbra_scene::Scene;

/// Number of receivers tried per scene.
const RECEIVERS: usize = 400;
/// Two in this many receivers have their filters checked too.
const FILTERED_SHARE: usize = 12;
/// Slope of the steepest receivers that are compared with rays, a little less than what look-ups support.
const STEEPEST: f64 = 100.0;
/// Reach of the widest filter, texels.
const REACH: i64 = 4;

/// A point on a triangle, with its normal on the sunward side.
struct Point {
    own: usize,
    p_world: [f64; 3],
    normal: [f64; 3],
}

/// Everything that is needed to check look-ups in one scene.
pub(crate) struct Checker<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) truth: &'a Truth<'a>,
    pub(crate) baked: &'a BakedPair,
    pub(crate) bias: Bias,
}

impl Checker<'_> {
    pub(crate) fn check(&self, dice: &mut Dice, totals: &mut Totals) -> Result<(), String> {
        for n in 0..RECEIVERS {
            let own = if n % 2 == 0 { self.any_triangle(dice) } else { self.triangle_at_a_texel(dice) };
            let Some(point) = own.and_then(|own| self.point_on(own, dice)) else {
                totals.skip(Skip::NoReceiver);
                continue;
            };
            let outcome = self.check_point(&point, n % FILTERED_SHARE < 2, totals);
            outcome.map_err(|reason| {
                let own = &self.truth.triangles[point.own];
                let at = format!("at {:?}, normal {:?}", point.p_world, point.normal);
                format!("instance {}, triangle {}, {at}: {reason}", own.instance, own.triangle)
            })?;
        }
        Ok(())
    }

    fn any_triangle(&self, dice: &mut Dice) -> Option<usize> {
        Some(dice.below(self.truth.triangles.len()))
    }

    /// Picks one of the triangles over the centre of a random texel, so that triangles are chosen in
    /// proportion to their area.
    fn triangle_at_a_texel(&self, dice: &mut Dice) -> Option<usize> {
        let size = self.truth.grid.size;
        let [i, j] = [0, 1].map(|a| dice.below(size[a] as usize) as i64);
        let over = self.truth.triangles.iter().enumerate().filter(|(_, t)| t.shape.covers(i, j));
        let over: Vec<usize> = over.map(|(n, _)| n).collect();
        if over.is_empty() { None } else { Some(dice.pick(&over)) }
    }

    /// Picks a random point on a triangle. Returns `None` if the triangle receives no sunlight. Both sides of
    /// an open surface do.
    fn point_on(&self, own: usize, dice: &mut Dice) -> Option<Point> {
        let t = &self.truth.triangles[own];
        let instance = &self.scene.instances[t.instance as usize];
        let mesh = &self.scene.meshes[instance.mesh as usize];
        let corners =
            mesh.triangles[t.triangle as usize].map(|v| instance.to_world(mesh.positions[v as usize]));
        let edge = |n: usize| [0, 1, 2].map(|a| corners[n][a] - corners[0][a]);
        let (u, v) = (edge(1), edge(2));
        let outwards = cross(u, v);
        let length = dot(outwards, outwards).sqrt();
        let normal = outwards.map(|c| c / length);
        if !normal.iter().all(|c| c.is_finite()) {
            return None;
        }
        let mirrored = instance.determinant() < 0.0;
        let towards = dot(normal, self.truth.grid.sun.towards());
        if t.casts && t.solid && (towards < 0.0) != mirrored {
            return None;
        }
        let normal = if towards < 0.0 { normal.map(|c| -c) } else { normal };
        let (mut along_u, mut along_v) = (dice.unit(), dice.unit());
        if along_u + along_v > 1.0 {
            (along_u, along_v) = (1.0 - along_u, 1.0 - along_v);
        }
        let p_world = std::array::from_fn(|a| corners[0][a] + along_u * u[a] + along_v * v[a]);
        Some(Point { own, p_world, normal })
    }

    fn check_point(&self, point: &Point, filtered: bool, totals: &mut Totals) -> Result<(), String> {
        let Point { own, p_world, normal } = *point;
        let r = receiver(&self.truth.grid, &self.bias, p_world, Some(normal));
        let [gx, gy] = r.gradient;
        if gx.hypot(gy) > STEEPEST {
            totals.skip(Skip::Steep);
            return Ok(());
        }
        let fixed = FixedReceiver::new(&r, self.truth.grid.size);
        let texel = [0, 1].map(|a| fixed.p_fixed[a] >> FIXED_BITS);
        match self.expected(own, &fixed, texel)? {
            Err(reason) => totals.skip(reason),
            Ok(lit) => {
                totals.receivers[0] += 1;
                totals.receivers[1] += u64::from(lit);
                for (name, file) in self.baked.each() {
                    let found = file.sampler(Filter::Nearest).visibility(p_world, Some(normal));
                    if found != f32::from(u8::from(lit)) {
                        return Err(format!(
                            "rays say lit = {lit}, the file of the {name} says {found} in {texel:?}, {fixed:?}"
                        ));
                    }
                }
            }
        }
        if filtered {
            self.check_taps(own, &fixed, texel, totals)?;
            self.check_filters(&fixed, texel, totals)?;
        }
        Ok(())
    }

    /// Returns what the look-up must find in a texel.
    fn expected(
        &self,
        own: usize,
        fixed: &FixedReceiver,
        texel: [i64; 2],
    ) -> Result<Result<bool, Skip>, String> {
        let [nx, ny, nz] = self.truth.grid.size.map(i64::from);
        let bits = FIXED_BITS + GRADIENT_BITS;
        let depth = depth_at(fixed, texel);
        let inside = (0..nx).contains(&texel[0]) && (0..ny).contains(&texel[1]);
        if !inside || !(0..nz).contains(&(depth >> bits)) {
            return Ok(Err(Skip::OutsideGrid));
        }
        self.truth.is_lit(own, texel, depth as f64 / (1_u64 << bits) as f64)
    }

    /// Checks the taps of the widest filter. Skips taps in texels for which nothing is guaranteed.
    fn check_taps(
        &self,
        own: usize,
        fixed: &FixedReceiver,
        [i, j]: [i64; 2],
        totals: &mut Totals,
    ) -> Result<(), String> {
        for y in j - REACH..=j + REACH {
            for x in i - REACH..=i + REACH {
                let lit = match self.expected(own, fixed, [x, y])? {
                    Ok(lit) => lit,
                    Err(reason) => {
                        totals.skip(reason);
                        continue;
                    }
                };
                // Gradients are rounded to 1/256, so a few texels from the point the sample may be in the
                // voxel before the surface's own.
                let layer = depth_at(fixed, [x, y]) >> (FIXED_BITS + GRADIENT_BITS);
                if !lit && layer < self.truth.sampled_layer(own, [x, y]) {
                    totals.skip(Skip::Rounding);
                    continue;
                }
                totals.taps[0] += 1;
                totals.taps[1] += u64::from(lit);
                for (name, file) in self.baked.each() {
                    if tap(&file.tree, fixed, [x, y]) != lit {
                        return Err(format!(
                            "rays say lit = {lit} at tap ({x}, {y}), the file of the {name} does not: {fixed:?}"
                        ));
                    }
                }
            }
        }
        Ok(())
    }

    /// Compares filters with the sum of single voxels, counted for one receiver and for successive ones.
    fn check_filters(
        &self,
        fixed: &FixedReceiver,
        [i, j]: [i64; 2],
        totals: &mut Totals,
    ) -> Result<(), String> {
        for (name, file) in self.baked.each() {
            for filter in [Filter::Nearest, Filter::Box3, Filter::Box5, Filter::Box9] {
                let width = filter.width();
                let reach = i64::from(width) / 2;
                let taps = (j - reach..=j + reach).flat_map(|y| (i - reach..=i + reach).map(move |x| [x, y]));
                let expected = taps.filter(|&texel| tap(&file.tree, fixed, texel)).count() as u32;
                let sampler = file.sampler(filter);
                let found = [sampler.lit_taps(fixed), sampler.successive_lit_taps()(fixed)];
                totals.filters += 1;
                if found != [expected; 2] {
                    return Err(format!(
                        "{width} × {width} taps of the file of the {name}: {found:?} are lit, of single voxels {expected}: {fixed:?}"
                    ));
                }
            }
        }
        Ok(())
    }
}

/// Returns the depth of the receiver's plane at a texel's centre, 1/2^20 voxel.
fn depth_at(fixed: &FixedReceiver, texel: [i64; 2]) -> i64 {
    let half = 1 << (FIXED_BITS - 1);
    let along =
        |a: usize| i64::from(fixed.gradient[a]) * ((texel[a] << FIXED_BITS) + half - fixed.p_fixed[a]);
    (fixed.p_fixed[2] << GRADIENT_BITS) + along(0) + along(1)
}

/// Whether one tap is lit, straight from the definition: everything beside and before the grid is lit, and
/// behind the grid its last layer answers.
fn tap(tree: &DepthTree, fixed: &FixedReceiver, texel: [i64; 2]) -> bool {
    let [nx, ny, nz] = tree.size().map(i64::from);
    let [x, y] = texel;
    let layer = (depth_at(fixed, texel) >> (FIXED_BITS + GRADIENT_BITS)).min(nz - 1);
    if !(0..nx).contains(&x) || !(0..ny).contains(&y) || layer < 0 {
        return true;
    }
    tree.voxel(x as u32, y as u32, layer as u32)
}
