//! Every estimator on the truth cameras, compared with current engines.

use std::path::Path;

use adumbra_program::output::note_input;
use adumbra_program::scene::load_scene;
use adumbra_render::occlusion::{Estimator, OcclusionPasses, OcclusionSettings};
use adumbra_render::{Gpu, SceneOptions};
use adumbra_scene::LoadOptions;

use super::measure::unfiltered;
use crate::args::BenchAo;
use crate::bench::peers::scene_file;
use crate::occlusion::{OcclusionStage, TunedOn, with_tuned};
use crate::peers::RowSource;
use crate::peers::occlusion::{OcclusionRow, SCENES, engines, figures};
use adumbra_compare::Result;
use adumbra_compare::truth::TruthView;

/// Returns the name of one of our rows.
pub(super) fn name(estimator: Estimator, samples: u32, filtered: bool) -> String {
    format!("{estimator}, {samples} samples{}", if filtered { " and filter" } else { "" })
}

/// Returns our rows, those of the engines, and the aim.
pub(super) fn rows(args: &BenchAo, truth: &Path) -> Result<Vec<OcclusionRow>> {
    let kinds: Vec<(Estimator, bool)> =
        Estimator::ALL.iter().flat_map(|e| [(*e, true), (*e, false)]).collect();
    let samples = OcclusionSettings::new(Estimator::Issao, 1.0).samples;
    let row = |(e, filtered): &(Estimator, bool)| OcclusionRow {
        name: name(*e, samples, *filtered),
        source: RowSource::Here,
        scenes: [None; 3],
    };
    let mut rows: Vec<OcclusionRow> = kinds.iter().map(row).collect();
    for (column, scene) in SCENES.into_iter().enumerate() {
        let path = truth.join(format!("{scene}.npz"));
        note_input("the truth file itself", &path);
        let view = TruthView::read(&path)?;
        let options = LoadOptions { ignore_alpha: true, ..LoadOptions::default() };
        let loaded = load_scene(&scene_file(&args.scenes, scene)?, &options)?;
        let gpu = Gpu::request(&args.common.device.gpu_options())?;
        let stage = OcclusionStage::new(gpu, &loaded, SceneOptions { ignore_alpha: true }, view.camera)?;
        for ((estimator, filtered), row) in kinds.iter().zip(&mut rows) {
            let settings = OcclusionSettings::new(*estimator, view.ambient_radius_world);
            let settings = with_tuned(settings, TunedOn::without(scene));
            let settings = if *filtered { settings } else { unfiltered(settings) };
            let visibility = stage.visibility(&mut OcclusionPasses::new(stage.gpu(), settings))?;
            let found = figures(&visibility, &view)?;
            adumbra_program::note!("{scene} {}: {:.3}", row.name, found.rmse);
            row.scenes[column] = Some(found);
        }
    }
    rows.extend(engines());
    Ok(rows)
}
