//! The technique of one side: its name, its parameters, and its notes.

use adumbra_render::technique::{Parameter, ParameterKind};
use adumbra_render::{Reads, SpecText, TECHNIQUES, TechniqueFiles, TechniqueSpec};

use super::parameters;
use crate::app::App;
use crate::command::{Command, Side};
use crate::shadow_file::ShownFile;

/// Returns the technique's parameters. They include those that the current file does not support, such as
/// penumbrae, because another file is baked if they are requested.
fn describe(spec: &TechniqueSpec, baked: TechniqueFiles<'_>) -> Vec<Parameter> {
    let of_any = spec.describe(TechniqueFiles::default()).unwrap_or_default();
    let Ok(mut of_file) = spec.describe(baked) else { return of_any };
    for p in &mut of_file {
        if let (ParameterKind::Word { .. }, Some(any)) = (&p.kind, of_any.iter().find(|any| any.key == p.key))
        {
            p.kind = any.kind.clone();
        }
    }
    of_file
}

const WARNING: egui::Color32 = egui::Color32::from_rgb(255, 190, 110);

pub(super) fn show(ui: &mut egui::Ui, app: &App, side: Side, commands: &mut Vec<Command>) {
    let spec = app.settings.shadow(side);
    let mut chosen = spec.name().to_owned();
    egui::ComboBox::from_id_salt(("technique", side as u8)).selected_text(&chosen).width(160.0).show_ui(
        ui,
        |ui| {
            for t in TECHNIQUES {
                ui.selectable_value(&mut chosen, t.name.to_owned(), t.name).on_hover_text(t.summary);
            }
        },
    );
    if chosen != spec.name() {
        commands.push(Command::Shadow { side, technique: chosen });
    }
    let baked = app.shadows.file().map(ShownFile::baked).unwrap_or_default();
    let of_nested = |text: &SpecText| {
        let nested = spec.techniques().parse(&text.to_string());
        nested.map(|nested| describe(&nested, baked)).unwrap_or_default()
    };
    if let Some(changed) = parameters::show(ui, &format!("{side:?}"), &describe(spec, baked), &of_nested) {
        let next = changed.of(spec.text(), |key, value| {
            let change = |baked| spec.change(baked, key, value);
            change(baked).or_else(|_| change(TechniqueFiles::default())).map(|next| next.text().clone())
        });
        commands.push(Command::Shadow { side, technique: next.to_string() });
    }
    if let Some(stage) = &app.stage {
        let view = stage.side(side);
        if view.bytes() > 0 {
            ui.small(format!("{:.1} MB on the device", view.bytes() as f64 * 1e-6));
        }
        let reads_file = spec.reads() == Reads::LightFile;
        let is_outdated = |file: &ShownFile| reads_file && !file.serves(&app.settings);
        if app.shadows.file().is_some_and(is_outdated) {
            ui.small(egui::RichText::new("its shadows are for another sun").color(WARNING));
        }
        let missing = stage.missing(side, app.settings.layer);
        for note in view.note().map(str::to_owned).into_iter().chain(missing) {
            ui.small(egui::RichText::new(note).color(WARNING));
        }
    }
}
