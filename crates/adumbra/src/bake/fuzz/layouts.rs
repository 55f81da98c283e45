//! Builders and layouts against each other: the same scene must have the same columns, whoever finds them and however they are kept.

use std::sync::atomic::AtomicBool;

use super::dice::Dice;
use super::totals::Totals;
use crate::bake::agreement::{BothBuffers, Column, for_each_column};
use crate::bake::plan::Plan;
use crate::bake::{Builder, Options, bake, bake_both, bake_hierarchy, bake_packed};
use crate::dag::packed::PackedDag;
use crate::dag::{Dag, Slabs, Trail};
use crate::hierarchy::Hierarchy;
use crate::scene::Scene;

/// Everything that one scene was baked into.
pub(super) struct Layouts {
    /// The fast builder's graph.
    pub(super) fast: Dag,
    /// The plain builder's graph.
    pub(super) plain: Dag,
    /// The fast builder's graph, packed.
    pub(super) packed: PackedDag,
    /// The fast builder's other layout.
    pub(super) hierarchy: Hierarchy,
}

impl Layouts {
    /// Bakes each of them and has each one's validator look at it.
    pub(super) fn bake(scene: &Scene, options: &Options) -> Result<Self, String> {
        let never = AtomicBool::new(false);
        let text = |e: crate::Error| e.to_string();
        let both = bake_both(scene, options, &|_| {}, &never).map_err(text)?;
        let plain_options = Options { builder: Builder::Plain, ..options.clone() };
        let plain = bake(scene, &plain_options, &|_| {}, &never).map_err(text)?.dag;
        let fast = bake(scene, options, &|_| {}, &never).map_err(text)?.dag;
        if fast != both.dag {
            return Err("bake and bake_both make different graphs".to_owned());
        }
        let packed = bake_packed(scene, options, &|_| {}, &never).map_err(text)?.packed;
        let of_dag = PackedDag::of_dag(&fast).map_err(|e| format!("the graph cannot be packed: {e}"))?;
        if packed != of_dag {
            return Err("bake_packed and PackedDag::of_dag differ".to_owned());
        }
        let back = packed.to_dag().map_err(|e| format!("the packed graph cannot be unpacked: {e}"))?;
        if back != fast {
            return Err("the graph is not the same after it was packed and unpacked".to_owned());
        }
        let unmerged = bake_hierarchy(scene, options, false, &|_| {}, &never).map_err(text)?.hierarchy;
        for (name, dag) in [("fast", &fast), ("plain", &plain)] {
            dag.validate().map_err(|e| format!("the {name} graph is not valid: {e}"))?;
        }
        packed.validate().map_err(|e| format!("the packed graph is not valid: {e}"))?;
        for (name, hierarchy) in [("merged", &both.hierarchy), ("unmerged", &unmerged)] {
            hierarchy.validate().map_err(|e| format!("the {name} hierarchy is not valid: {e}"))?;
        }
        let [nx, ny, _] = both.hierarchy.size;
        let differs = |i: u32, j: u32| both.hierarchy.value(i, j) != unmerged.value(i, j);
        if let Some((i, j)) = (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j))).find(|&(i, j)| differs(i, j))
        {
            return Err(format!("column ({i}, {j}) of the hierarchy changes when shapes are merged"));
        }
        Ok(Self { fast, plain, packed, hierarchy: both.hierarchy })
    }

    /// Each of them by name.
    pub(super) fn each(&self) -> [(&'static str, &dyn Slabs); 4] {
        [
            ("fast graph", &self.fast),
            ("plain graph", &self.plain),
            ("packed graph", &self.packed),
            ("hierarchy", &self.hierarchy),
        ]
    }

    /// Holds every column of every layout against the plain builder's interval.
    pub(super) fn check_columns(
        &self,
        plan: &Plan<'_>,
        dice: &mut Dice,
        totals: &mut Totals,
    ) -> Result<(), String> {
        let mut buffers = BothBuffers::default();
        let mut outcome = Ok(());
        for tile in 0..plan.tiles() {
            for_each_column(plan, tile, &mut buffers, |column| {
                if outcome.is_ok() {
                    totals.columns += 1;
                    totals.drawn += u64::from(column.drawn);
                    outcome = self.check_column(&column, dice);
                }
            });
        }
        outcome
    }

    fn check_column(&self, column: &Column, dice: &mut Dice) -> Result<(), String> {
        let &Column { at: [i, j], plain: [e, x], .. } = column;
        if !column.agrees() {
            return Err(format!("the builders disagree: {column:?}"));
        }
        let depth = self.fast.size[2];
        let switch = self.hierarchy.value(i, j).min(depth);
        if switch < e || (x < depth && switch > x) {
            return Err(format!("the hierarchy switches at {switch}: {column:?}"));
        }
        let anywhere = dice.below(depth as usize) as u32;
        let near_ends =
            [e.wrapping_sub(1), e, x.wrapping_sub(1), x, switch.wrapping_sub(1), switch, anywhere];
        for k in near_ends.into_iter().filter(|&k| k < depth) {
            for (name, slabs) in self.each() {
                let slab = slabs.slab(i, j, k);
                let lit = slab >> ((j & 7) * 8 + (i & 7)) & 1 == 1;
                if (k < e && !lit) || (k >= x && lit) {
                    return Err(format!("voxel {k} of the {name} has lit = {lit}: {column:?}"));
                }
                let mut cube = [0; 8];
                let known = slabs.fill_along(&mut Trail::new(), [i, j, k], &mut cube);
                if known >> (k & 7) & 1 == 0 || cube[(k & 7) as usize] != slab {
                    return Err(format!("cube and slab of voxel {k} of the {name} differ: {column:?}"));
                }
            }
            if (self.hierarchy.slab(i, j, k) >> ((j & 7) * 8 + (i & 7)) & 1 == 1) != (k < switch) {
                return Err(format!("the hierarchy's slab at {k} is not its value {switch}: {column:?}"));
            }
            if self.packed.slab(i, j, k) != self.fast.slab(i, j, k) {
                return Err(format!("the packed graph's slab at {k} is not the graph's: {column:?}"));
            }
        }
        Ok(())
    }
}
