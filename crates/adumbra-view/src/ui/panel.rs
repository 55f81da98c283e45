//! The panel: controls for what is shown, and how.

use adumbra_program::format::grouped;
use adumbra_render::SpecText;
use adumbra_render::layers::Layer;
use adumbra_render::occlusion::{self, OCCLUSIONS};

use super::{legend, parameters, side, times};
use crate::app::App;
use crate::command::{Command, Side};
use crate::navigation;
use crate::settings::Shown;

const WIDTH: f32 = 310.0;

pub(super) fn show(ctx: &egui::Context, app: &App, commands: &mut Vec<Command>) {
    let height = ctx.content_rect().height();
    egui::Window::new("adumbra")
        .default_pos([8.0, 8.0])
        .default_width(WIDTH)
        .default_height(height - 60.0)
        .max_height(height - 60.0)
        .resizable([false, true])
        .vscroll(true)
        .show(ctx, |ui| {
            scene(ui, app);
            section(ui, "Shown", true, |ui| shown(ui, app, commands));
            section(ui, "First side", true, |ui| side::show(ui, app, Side::First, commands));
            section(ui, "Second side", app.settings.shows_both(), |ui| {
                side::show(ui, app, Side::Second, commands);
            });
            section(ui, "Ambient occlusion", true, |ui| ambient(ui, app, commands));
            section(ui, "Sun", true, |ui| sun(ui, app, commands));
            section(ui, "Shadow file", true, |ui| file(ui, app, commands));
            section(ui, "Open", false, |ui| open(ui, commands));
            section(ui, "Camera, time", false, |ui| camera(ui, app, commands));
            section(ui, "Milliseconds", true, |ui| times::show(ui, app));
        });
}

fn section(ui: &mut egui::Ui, title: &str, open: bool, add: impl FnOnce(&mut egui::Ui)) {
    // A section opens when it first becomes relevant, and keeps the user's choice from then on.
    egui::CollapsingHeader::new(title).id_salt((title, open)).default_open(open).show(ui, add);
}

/// A path to open, because not every desktop supports dropping files on windows.
fn open(ui: &mut egui::Ui, commands: &mut Vec<Command>) {
    let id = ui.scope_id().with("open");
    let mut path: String = ui.data(|d| d.get_temp(id)).unwrap_or_default();
    let hint = "scene, shadow file or camera";
    let edited = ui.add(egui::TextEdit::singleline(&mut path).hint_text(hint).desired_width(f32::INFINITY));
    let done = edited.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter)) && !path.is_empty();
    if done {
        commands.push(Command::Drop(std::mem::take(&mut path).into()));
    }
    ui.data_mut(|d| d.insert_temp(id, path));
}

fn scene(ui: &mut egui::Ui, app: &App) {
    let Some(stage) = &app.stage else { return };
    let scene = stage.scene();
    let name = scene.path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    ui.horizontal_wrapped(|ui| {
        ui.strong(name);
        ui.label(format!("{} triangles", grouped(scene.whole.instanced_triangles())));
    });
    ui.small(format!("{}; ? for keys", app.adapter()));
}

fn shown(ui: &mut egui::Ui, app: &App, commands: &mut Vec<Command>) {
    let s = &app.settings;
    let mut layer = s.layer;
    egui::ComboBox::from_id_salt("layer").selected_text(layer.name()).show_ui(ui, |ui| {
        for each in Layer::ALL {
            ui.selectable_value(&mut layer, each, each.name());
        }
    });
    if layer != s.layer {
        commands.push(Command::Layer(layer.name().to_owned()));
    }
    legend::show(ui, app);
    ui.horizontal(|ui| {
        let mut choose = |ui: &mut egui::Ui, text: &str, on: bool, command: Command| {
            if ui.selectable_label(on, text).clicked() && !on {
                commands.push(command);
            }
        };
        choose(ui, "first alone", s.shown == Shown::Single, Command::Single);
        choose(ui, "split", matches!(s.shown, Shown::Split(_)), Command::Split(0.5));
        choose(ui, "difference", matches!(s.shown, Shown::Difference(_)), Command::Difference(2.0));
    });
    match s.shown {
        Shown::Single => {}
        Shown::Split(at) => {
            let mut moved = at;
            if slid(ui, egui::Slider::new(&mut moved, 0.0..=1.0).text("divider")) {
                commands.push(Command::Split(moved));
            }
        }
        Shown::Difference(gain) => {
            let mut moved = gain;
            if slid(ui, egui::Slider::new(&mut moved, 1.0..=20.0).logarithmic(true).text("gain")) {
                commands.push(Command::Difference(moved));
            }
        }
    }
    ui.horizontal(|ui| {
        switch(ui, "file bounds", s.show_box, commands, Command::Box);
        switch(ui, "4 samples", s.antialias > 1, commands, |on| Command::Antialias(if on { 2 } else { 1 }));
        switch(ui, "continuous", s.continuous, commands, Command::Continuous);
    });
}

fn switch(
    ui: &mut egui::Ui,
    text: &str,
    on: bool,
    commands: &mut Vec<Command>,
    command: impl FnOnce(bool) -> Command,
) {
    let mut now = on;
    ui.checkbox(&mut now, text);
    if now != on {
        commands.push(command(now));
    }
}

fn ambient(ui: &mut egui::Ui, app: &App, commands: &mut Vec<Command>) {
    let spec = &app.settings.ambient;
    let mut chosen = spec.name().to_owned();
    egui::ComboBox::from_id_salt("ambient").selected_text(&chosen).width(160.0).show_ui(ui, |ui| {
        for (name, what) in OCCLUSIONS {
            ui.selectable_value(&mut chosen, name.to_owned(), name).on_hover_text(what);
        }
    });
    if chosen != spec.name() {
        commands.push(Command::Ao(chosen));
        return;
    }
    let Some(stage) = &app.stage else { return };
    let radius = stage.default_radius();
    let describe = |spec: &SpecText| occlusion::describe(spec, radius).unwrap_or_default();
    if let Some(changed) = parameters::show(ui, "ambient", &describe(spec), &describe) {
        let next = changed.of(spec, |key, value| occlusion::change(spec, radius, key, value));
        commands.push(Command::Ao(next.to_string()));
    }
}

fn sun(ui: &mut egui::Ui, app: &App, commands: &mut Vec<Command>) {
    let [mut azimuth, mut elevation] = navigation::angles(app.settings.sun.towards());
    let turned = slid(ui, angle(&mut azimuth, 0.0..=360.0, "azimuth"));
    let raised = slid(ui, angle(&mut elevation, 1.0..=89.5, "elevation"));
    if turned || raised {
        commands.push(Command::Sun { azimuth, elevation });
    }
    if ui.button("reset").clicked() {
        commands.push(Command::ResetSun);
    }
}

fn angle<'v>(degrees: &'v mut f64, range: std::ops::RangeInclusive<f64>, text: &str) -> egui::Slider<'v> {
    egui::Slider::new(degrees, range).suffix("°").text(text.to_owned()).max_decimals(1)
}

/// Adds a slider and returns whether the user moved it. A value outside its range stays unchanged until then.
fn slid(ui: &mut egui::Ui, slider: egui::Slider<'_>) -> bool {
    ui.add(slider.clamping(egui::SliderClamping::Edits)).changed()
}

fn file(ui: &mut egui::Ui, app: &App, commands: &mut Vec<Command>) {
    let s = &app.settings;
    let mut resolution = s.resolution;
    ui.horizontal(|ui| {
        egui::ComboBox::from_id_salt("resolution").selected_text(resolution.to_string()).show_ui(ui, |ui| {
            for each in (9..=18).map(|log| 1 << log) {
                ui.selectable_value(&mut resolution, each, each.to_string());
            }
        });
        ui.label("texels");
        let bake = ui.button("bake").on_hover_text("bake again with this many texels on the longest side");
        if bake.clicked() || resolution != s.resolution {
            commands.push(Command::Bake(resolution));
        }
    });
    if let Some(bake) = app.shadows.running() {
        ui.horizontal(|ui| {
            let text = format!("baking {}", bake.resolution);
            ui.add(egui::ProgressBar::new(bake.share).desired_width(190.0).text(text));
            if ui.button("cancel").clicked() {
                commands.push(Command::CancelBake);
            }
        });
    }
    if let Some(file) = app.shadows.file() {
        file.lines().into_iter().for_each(|line| _ = ui.small(line));
    }
    let mut budget = s.budget_mib;
    let slider = egui::Slider::new(&mut budget, 1..=1024).logarithmic(true).suffix(" MiB").text("budget");
    let slider = ui.add(slider.clamping(egui::SliderClamping::Edits));
    // Each change reads the file again, so apply the new budget only when the slider is released.
    let id = ui.scope_id().with("budget");
    if slider.changed() {
        ui.data_mut(|d| d.insert_temp(id, budget));
    }
    if !slider.is_pointer_button_down_on()
        && let Some(budget) = ui.data_mut(|d| d.remove_temp::<u64>(id))
        && budget != s.budget_mib
    {
        commands.push(Command::Budget(budget));
    }
}

fn camera(ui: &mut egui::Ui, app: &App, commands: &mut Vec<Command>) {
    let c = &app.settings.camera;
    let place = |p: [f64; 3]| format!("{:.2}, {:.2}, {:.2}", p[0], p[1], p[2]);
    ui.monospace(format!("eye    {}", place(c.eye)));
    ui.monospace(format!("target {}", place(c.target)));
    ui.horizontal(|ui| {
        if ui.button("reset").clicked() {
            commands.push(Command::ResetCamera);
        }
        if ui.button("save").on_hover_text("as JSON for compare --camera").clicked() {
            commands.push(Command::SaveCamera(crate::keys::CAMERA.into()));
        }
        if ui.button("screenshot").clicked() {
            commands.push(Command::Screenshot(crate::keys::SCREENSHOT.into()));
        }
        if ui.button("command").on_hover_text("show the command line that reproduces this view").clicked() {
            commands.push(Command::SayLine);
        }
    });
    ui.horizontal(|ui| {
        switch(ui, "ball", app.settings.ball, commands, Command::Ball);
        if ui.button("look at it").clicked() {
            commands.push(Command::WatchBall);
        }
        switch(ui, "run time", app.settings.playing, commands, Command::Play);
    });
    if let Some(end) = app.stage.as_ref().and_then(crate::stage::Stage::end_seconds) {
        let mut seconds = app.settings.seconds;
        if slid(ui, egui::Slider::new(&mut seconds, 0.0..=end.max(0.1)).text("s")) {
            commands.push(Command::Time(seconds));
        }
    }
    if let Some(day) = &app.day {
        let mut hour = day.hour();
        let [first, last] = day.span().map(|seconds| (seconds - day.at_hour(0.0)) / 3600.0);
        let slider =
            egui::Slider::new(&mut hour, first..=last).show_value(false).text(day.shown(day.seconds()));
        if slid(ui, slider) {
            commands.push(Command::Hour(hour));
        }
        ui.small(day.line());
    }
    if ui.button("reset everything").clicked() {
        commands.push(Command::ResetAll);
    }
}
