//! A technique of one side: its name, its parameters, what it says.

use adumbra_render::technique::{self, Parameter, ParameterKind};
use adumbra_render::{Baked, TECHNIQUES, TechniqueSpec};

use super::parameters;
use crate::app::App;
use crate::command::{Command, Side};
use crate::settings::shadow_names;
use crate::shadow_file::{is_same_sun, sun_of};

/// Its parameters: of a file that has no penumbrae too, for another is baked where they are asked for.
fn describe(spec: &TechniqueSpec, baked: Baked<'_>) -> Vec<Parameter> {
    let of_any = technique::describe(spec, Baked::default()).unwrap_or_default();
    let Ok(mut of_file) = technique::describe(spec, baked) else { return of_any };
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
            for name in shadow_names() {
                let what =
                    TECHNIQUES.iter().find(|(n, _)| *n == name).map_or("rays, on the CPU", |(_, what)| *what);
                ui.selectable_value(&mut chosen, name.to_owned(), name).on_hover_text(what);
            }
        },
    );
    if chosen != spec.name() {
        commands.push(Command::Shadow { side, technique: chosen });
    }
    let baked = app.shadows.files.baked();
    let describe = |spec: &TechniqueSpec| describe(spec, baked);
    if let Some(changed) = parameters::show(ui, &format!("{side:?}"), &describe(spec), &describe) {
        let next = changed.of(spec, |key, value| {
            technique::change(spec, baked, key, value)
                .or_else(|_| technique::change(spec, Baked::default(), key, value))
        });
        commands.push(Command::Shadow { side, technique: next.to_string() });
    }
    if let Some(stage) = &app.stage {
        let view = stage.side(side);
        if view.bytes() > 0 {
            ui.small(format!("{:.1} MB on the device", view.bytes() as f64 * 1e-6));
        }
        if app.shadows.files.of(spec).is_some_and(|f| !is_same_sun(&sun_of(f), &app.settings.sun)) {
            ui.small(egui::RichText::new("its shadows are of another sun").color(WARNING));
        }
        let missing = stage.missing(side, app.settings.layer);
        for note in view.note().map(str::to_owned).into_iter().chain(missing) {
            ui.small(egui::RichText::new(note).color(WARNING));
        }
    }
}
