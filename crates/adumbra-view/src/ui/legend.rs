//! The meaning of the colours of a tinted layer.

use adumbra_render::layers::{LEVEL_COLORS, Layer};
use egui::{Color32, Sense, Ui, Vec2};

use crate::app::App;
use crate::command::Side;
use crate::shadow_file::ShownFile;

const SWATCH: Vec2 = Vec2::new(14.0, 10.0);

pub(super) fn show(ui: &mut Ui, app: &App) {
    let layer = app.settings.layer;
    let Some((_, colors)) = layer.tint() else { return };
    let voxel = app.stage.as_ref().and_then(|s| s.side(Side::First).voxel_world());
    let count = match layer {
        Layer::Cascades => cascades(app),
        Layer::ResidentLevel => levels(app),
        _ => colors.len(),
    };
    ui.horizontal_wrapped(|ui| {
        for (i, color) in (0_u32..).zip(colors.iter().take(count)) {
            let text = match (layer, voxel) {
                (Layer::VoxelSize, Some(voxel)) => short(voxel * f64::from(1_u32 << i)),
                (Layer::HybridLevels | Layer::ResidentLevel, _) if i == 0 => "finest".to_owned(),
                (Layer::Cascades, _) if i == 0 => "nearest".to_owned(),
                _ => (i + 1).to_string(),
            };
            let (rect, _) = ui.allocate_exact_size(SWATCH, Sense::hover());
            let [r, g, b] = color.map(egui::ecolor::gamma_u8_from_linear_f32);
            ui.painter().rect_filled(rect, 2.0, Color32::from_rgb(r, g, b));
            ui.small(text);
        }
    });
}

/// Returns the number of cascades of the first side's technique.
fn cascades(app: &App) -> usize {
    let baked = app.shadows.file().map(ShownFile::baked).unwrap_or_default();
    let parameters = app.settings.shadow(Side::First).describe(baked);
    let found = parameters.ok().and_then(|list| list.into_iter().find(|p| p.key == "cascades"));
    found.and_then(|p| p.value.parse().ok()).unwrap_or(0)
}

/// Returns the number of levels of a streamed file that are in use.
fn levels(app: &App) -> usize {
    let streamed = app.shadows.file().and_then(ShownFile::streamed);
    streamed.map_or(0, |file| file.streamer().resident().grids().len().min(LEVEL_COLORS.len()))
}

/// Formats a value with two significant digits.
fn short(value: f64) -> String {
    let decimals = if value > 0.0 { (1.0 - value.log10().floor()).clamp(0.0, 6.0) as usize } else { 0 };
    format!("{value:.decimals$}")
}
