//! The help: every key, and the mouse.

use crate::command::Command;
use crate::keys::{KEYS, MOUSE};

pub(super) fn show(ctx: &egui::Context, commands: &mut Vec<Command>) {
    let mut open = true;
    egui::Window::new("Keys and mouse")
        .open(&mut open)
        .collapsible(false)
        .resizable(false)
        .anchor(egui::Align2::CENTER_CENTER, [0.0, 0.0])
        .show(ctx, |ui| {
            egui::Grid::new("keys").num_columns(2).spacing([24.0, 4.0]).show(ui, |ui| {
                for (key, what) in KEYS.iter().chain(MOUSE) {
                    ui.monospace(*key);
                    ui.label(*what);
                    ui.end_row();
                }
            });
        });
    if !open {
        commands.push(Command::Help(false));
    }
}
