//! Bakes whose voxels a test inspects.

use adumbra::layout::depths::DepthTree;
use adumbra::layout::plain::Dag;
use adumbra::{FileSettings, LightBody, LightGrid, ShadowFile};
use adumbra_bake::{BakeOptions, LayoutChoice, Report, Result, Watch, bake};
use adumbra_scene::Scene;

/// A bake in the plain layout, in its parts.
#[derive(Debug)]
pub struct BakedGraph {
    /// The voxel grid in the world.
    pub grid: LightGrid,
    /// The settings of the bake.
    pub settings: FileSettings,
    /// The voxels.
    pub dag: Dag,
    /// The report of the bake.
    pub report: Report,
}

/// Bakes the graph that `options` ask for, whatever layout they name.
///
/// # Errors
/// Returns the errors of [`bake`].
pub fn bake_graph(scene: &Scene, options: &BakeOptions) -> Result<BakedGraph> {
    let options = BakeOptions { layout: LayoutChoice::Plain, ..options.clone() };
    let baked = bake(scene, &options, Watch::none())?;
    let LightBody::Plain(dag) = baked.file.body else { unreachable!("the plain layout was requested") };
    Ok(BakedGraph { grid: baked.file.grid, settings: baked.file.settings, dag, report: baked.report })
}

/// Bakes the file that `options` ask for, in the given layout.
///
/// # Errors
/// Returns the errors of [`bake`].
pub fn bake_file(scene: &Scene, options: &BakeOptions, layout: LayoutChoice) -> Result<ShadowFile> {
    Ok(bake(scene, &BakeOptions { layout, ..options.clone() }, Watch::none())?.file)
}

/// Bakes the depths that `options` ask for, whatever layout they name.
///
/// # Errors
/// Returns the errors of [`bake`].
pub fn bake_depths(scene: &Scene, options: &BakeOptions) -> Result<DepthTree> {
    let options = BakeOptions { layout: LayoutChoice::Depths, ..options.clone() };
    let baked = bake(scene, &options, Watch::none())?;
    let LightBody::Depths(depths) = baked.file.body else { unreachable!("depths were requested") };
    Ok(depths)
}
