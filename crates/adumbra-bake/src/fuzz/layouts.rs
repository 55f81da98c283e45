//! Compares builders and layouts with each other: the same scene must have the same columns, whichever builder finds
//! them and whichever layout stores them.

use crate::convert::unpack;
use crate::fuzz::dice::Dice;
use crate::fuzz::totals::Totals;
use crate::options::{BakeOptions, Builder};
use crate::plain::agreement::{BothBuffers, Column, for_each_column};
use crate::plan::Plan;
use crate::test_bakes::{bake_both, bake_depths, bake_graph};
use crate::{LayoutChoice, Watch, bake, pack};
use adumbra::LightBody;
use adumbra::layout::depths::DepthTree;
use adumbra::layout::packed::PackedDag;
use adumbra::layout::plain::Dag;
use adumbra::layout::{LeafMasks, Trail};
use adumbra_scene::Scene;

/// Every form into which one scene is baked.
pub(crate) struct Layouts {
    /// The fast builder's graph.
    pub(crate) fast: Dag,
    /// The plain builder's graph.
    pub(crate) plain: Dag,
    /// The fast builder's graph, packed.
    pub(crate) packed: PackedDag,
    /// The fast builder's depths.
    pub(crate) depths: DepthTree,
}

/// Returns the scene with the triangles of each mesh in another order, each from another of its corners on.
fn shuffled(scene: &Scene, dice: &mut Dice) -> Scene {
    let mut scene = scene.clone();
    for mesh in &mut scene.meshes {
        for t in (0..mesh.triangles.len()).rev() {
            let other = dice.below(t + 1);
            mesh.triangles.swap(t, other);
            mesh.triangle_materials.swap(t, other);
            mesh.triangles[t].rotate_left(dice.below(3));
        }
    }
    scene
}

impl Layouts {
    /// Bakes all of them and validates each.
    pub(crate) fn bake(seed: u64, scene: &Scene, options: &BakeOptions) -> Result<Self, String> {
        let text = |e: crate::Error| e.to_string();
        let ((both, depths), _) = bake_both(scene, options).map_err(text)?;
        let plain_options = BakeOptions { builder: Builder::Plain, ..options.clone() };
        let plain = bake_graph(scene, &plain_options).map_err(text)?.dag;
        let fast = bake_graph(scene, options).map_err(text)?.dag;
        if fast != both {
            return Err("the graph changes when depths are built alongside it".to_owned());
        }
        let packed_options = BakeOptions { layout: LayoutChoice::Packed, ..options.clone() };
        let baked = bake(scene, &packed_options, Watch::none()).map_err(text)?;
        let LightBody::Packed(packed) = baked.file.body else {
            unreachable!("the packed layout was requested")
        };
        let from_dag = pack(&fast).map_err(|e| format!("the graph cannot be packed: {e}"))?;
        if packed != from_dag {
            return Err("the packed bake is not the packed graph".to_owned());
        }
        let back = unpack(&packed).map_err(|e| format!("the packed graph cannot be unpacked: {e}"))?;
        if back != fast {
            return Err("the graph is not the same after it was packed and unpacked".to_owned());
        }
        let unmerged = bake_depths(scene, options, false).map_err(text)?.0;
        for (name, dag) in [("fast", &fast), ("plain", &plain)] {
            dag.validate().map_err(|e| format!("the {name} graph is not valid: {e}"))?;
        }
        packed.validate().map_err(|e| format!("the packed graph is not valid: {e}"))?;
        for (name, depths) in [("merged", &depths), ("unmerged", &unmerged)] {
            depths.validate().map_err(|e| format!("the {name} depths are not valid: {e}"))?;
        }
        let shuffled = bake_depths(&shuffled(scene, &mut Dice::new(seed, 2)), options, true).map_err(text)?.0;
        if shuffled != depths {
            return Err("the depths change when triangles are shuffled and their corners turned".to_owned());
        }
        let [nx, ny, _] = depths.size;
        let differs = |i: u32, j: u32| depths.value(i, j) != unmerged.value(i, j);
        if let Some((i, j)) = (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j))).find(|&(i, j)| differs(i, j))
        {
            return Err(format!("column ({i}, {j}) of the depths changes when shapes are merged"));
        }
        Ok(Self { fast, plain, packed, depths })
    }

    /// Returns each of them with its name.
    pub(crate) fn each(&self) -> [(&'static str, &dyn LeafMasks); 4] {
        [
            ("fast graph", &self.fast),
            ("plain graph", &self.plain),
            ("packed graph", &self.packed),
            ("depths", &self.depths),
        ]
    }

    /// Checks every column of every layout against the plain builder's interval.
    pub(crate) fn check_columns(
        &self,
        plan: &Plan<'_>,
        dice: &mut Dice,
        totals: &mut Totals,
    ) -> Result<(), String> {
        let mut buffers = BothBuffers::default();
        let mut outcome = Ok(());
        for tile in 0..plan.tiles.count() {
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
        let switch = self.depths.value(i, j).min(depth);
        if switch < e || (x < depth && switch > x) {
            return Err(format!("the depths switch at {switch}: {column:?}"));
        }
        let anywhere = dice.below(depth as usize) as u32;
        let near_ends =
            [e.wrapping_sub(1), e, x.wrapping_sub(1), x, switch.wrapping_sub(1), switch, anywhere];
        for k in near_ends.into_iter().filter(|&k| k < depth) {
            for (name, leaf_masks) in self.each() {
                let leaf_mask = leaf_masks.look_up(i, j, k);
                let lit = leaf_masks.voxel(i, j, k);
                if (k < e && !lit) || (k >= x && lit) {
                    return Err(format!("voxel {k} of the {name} has lit = {lit}: {column:?}"));
                }
                let mut cube = [0; 8];
                let known = leaf_masks.fill(&mut Trail::new(), [i, j, k], &mut cube);
                if known >> (k & 7) & 1 == 0 || cube[(k & 7) as usize] != leaf_mask {
                    return Err(format!("cube and leaf mask of voxel {k} of the {name} differ: {column:?}"));
                }
            }
            if self.depths.voxel(i, j, k) != (k < switch) {
                return Err(format!("the depths' leaf mask at {k} is not its value {switch}: {column:?}"));
            }
            if self.packed.look_up(i, j, k) != self.fast.look_up(i, j, k) {
                return Err(format!("the packed graph's leaf mask at {k} is not the graph's: {column:?}"));
            }
        }
        Ok(())
    }
}
