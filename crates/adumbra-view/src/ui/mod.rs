//! Everything over the picture: the panel, messages, the help. It reads the view and returns commands, but
//! changes nothing itself.

mod help;
mod legend;
mod panel;
mod parameters;
mod side;
mod times;

use egui::{Align2, Color32, RichText};

use crate::app::App;
use crate::command::Command;
use crate::settings::Shown;

/// Half the width of the area around the divider in which the mouse grabs it, in points.
pub(crate) const GRIP_POINTS: f32 = 6.0;

/// Draws everything and returns the user's commands.
pub(crate) fn show(ui: &mut egui::Ui, app: &App) -> Vec<Command> {
    let mut commands = Vec::new();
    let ctx = ui.ctx().clone();
    if app.settings.show_panel {
        panel::show(&ctx, app, &mut commands);
    }
    if app.settings.show_help {
        help::show(&ctx, &mut commands);
    }
    if let Some(path) = app.loads.newest() {
        let text = format!("loading {} …", path.display());
        label(&ctx, "loading", Align2::CENTER_CENTER, &[(text, Color32::WHITE)]);
    }
    let messages: Vec<(String, Color32)> = app
        .messages
        .shown()
        .map(|m| (m.text.clone(), if m.is_error { Color32::from_rgb(255, 140, 120) } else { Color32::WHITE }))
        .collect();
    label(&ctx, "messages", Align2::LEFT_BOTTOM, &messages);
    names(&ctx, app);
    commands
}

/// Draws lines of text over the picture.
fn label(ctx: &egui::Context, id: &str, align: Align2, lines: &[(String, Color32)]) {
    if lines.is_empty() {
        return;
    }
    egui::Area::new(egui::Id::unique(id)).anchor(align, [0.0, 0.0]).interactable(false).show(ctx, |ui| {
        egui::Frame::new().fill(Color32::from_black_alpha(170)).inner_margin(6.0).show(ui, |ui| {
            for (text, color) in lines {
                ui.add(egui::Label::new(RichText::new(text).color(*color)).extend());
            }
        });
    });
}

/// Labels the sides with their techniques.
fn names(ctx: &egui::Context, app: &App) {
    let [first, second] = &app.settings.shadows;
    let text = match app.settings.shown {
        Shown::Single => first.to_string(),
        Shown::Split(_) => format!("{first}  |  {second}"),
        Shown::Difference(_) => format!("{first} − {second}: red = the second is darker, blue = brighter"),
    };
    label(ctx, "names", Align2::CENTER_BOTTOM, &[(text, Color32::WHITE)]);
}
