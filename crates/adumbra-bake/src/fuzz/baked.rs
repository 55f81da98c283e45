//! Compares builders with each other: the same scene must have the same columns, whichever builder finds
//! them, and whatever the order of its triangles.

use crate::Bake;
use crate::fuzz::dice::Dice;
use crate::fuzz::totals::Totals;
use crate::options::{BakeOptions, ColumnBuilder};
use crate::plain::agreement::{BothBuffers, Column, for_each_column};
use crate::plan::Plan;
use crate::test_bakes::bake_depths;
use adumbra::ShadowFile;
use adumbra::layout::depths::DepthTree;
use adumbra::layout::depths::code::ColumnNode;
use adumbra_scene::Scene;

/// The files into which one scene is baked.
pub(crate) struct BakedPair {
    /// The fast builder's.
    pub(crate) fast: ShadowFile,
    /// The plain builder's.
    pub(crate) plain: ShadowFile,
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

impl BakedPair {
    /// Bakes both files. Checks that neither the order of triangles nor merging shapes changes the depths.
    pub(crate) fn new(seed: u64, scene: &Scene, options: &BakeOptions) -> Result<Self, String> {
        let text = |e: crate::Error| e.to_string();
        let [fast, plain] = [options.builder, ColumnBuilder::Plain]
            .map(|builder| BakeOptions { builder, levels: 1, ..options.clone() })
            .map(|options| Bake::with_options(scene, &options).in_memory());
        let (fast, plain) = (fast.map_err(text)?, plain.map_err(text)?);
        let unmerged = bake_depths(scene, options, false).map_err(text)?.0;
        let shuffled = bake_depths(&shuffled(scene, &mut Dice::new(seed, 2)), options, true).map_err(text)?.0;
        if shuffled != *fast.tree {
            return Err("the depths change when triangles are shuffled and their corners turned".to_owned());
        }
        let [nx, ny, _] = unmerged.size();
        let differs = |i: u32, j: u32| fast.tree.value(i, j) != unmerged.value(i, j);
        if let Some((i, j)) = (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j))).find(|&(i, j)| differs(i, j))
        {
            return Err(format!("column ({i}, {j}) of the depths changes when shapes are merged"));
        }
        Ok(Self { fast, plain })
    }

    /// Returns each file with the name of its builder.
    pub(crate) fn each(&self) -> [(&'static str, &ShadowFile); 2] {
        [("fast builder", &self.fast), ("plain builder", &self.plain)]
    }

    /// Checks every column of both files against the plain builder's interval.
    pub(crate) fn check_columns(&self, plan: &Plan<'_>, totals: &mut Totals) -> Result<(), String> {
        let mut buffers = BothBuffers::default();
        let mut outcome = Ok(());
        for root_block in 0..plan.root_blocks.count() {
            for_each_column(plan, root_block, &mut buffers, |column| {
                if outcome.is_ok() {
                    totals.columns += 1;
                    totals.drawn += u64::from(column.drawn);
                    outcome = self.check_column(&column);
                }
            });
        }
        outcome
    }

    fn check_column(&self, column: &Column) -> Result<(), String> {
        let &Column { at: [i, j], plain: [e, x], .. } = column;
        if !column.agrees() {
            return Err(format!("the builders disagree: {column:?}"));
        }
        for (name, file) in self.each() {
            let depth = file.tree.size()[2];
            let switch = file.tree.value(i, j).min(depth);
            if switch < e || (x < depth && switch > x) {
                return Err(format!("the depths of the {name} switch at {switch}: {column:?}"));
            }
            if in_leaf(&file.tree, [i, j]).is_some_and(|of_leaf| of_leaf.min(depth) != switch) {
                return Err(format!("the leaf of the {name} does not have its value {switch}: {column:?}"));
            }
        }
        Ok(())
    }
}

/// Returns the depth of a column, read with all others of its leaf; `None` if the column is in no leaf.
fn in_leaf(depths: &DepthTree, [i, j]: [u32; 2]) -> Option<u32> {
    let ColumnNode::Leaf { at, base } = depths.place(i, j).0 else { return None };
    Some(depths.shapes().leaf(at, base).values()[((j & 7) * 8 + (i & 7)) as usize])
}
