//! The view without its window: executes commands, keeps everything in step, and draws. `results` handles the
//! events of other threads, and `playing` plays the script.

mod playing;
mod results;

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

use adumbra_compare::camera_file::CameraFile;
use adumbra_files::{FileWatch, replace_file, same_file};
use adumbra_program::output::png;
use adumbra_render::{FrameTimes, Gpu, RenderError};
use adumbra_scene::Camera;
use adumbra_truth::movers::MoveSpec;
use adumbra_truth::picture::Picture;

use crate::command::{Command, Side};
use crate::day::{Change, Day};
use crate::error::Result;
use crate::event::EventSender;
use crate::loading::{self, DropKind, Loads};
use crate::messages::{Messages, Say};
use crate::options::ViewOptions;
use crate::player::Player;
use crate::settings::Settings;
use crate::shadow_file::{ShownFile, is_same_sun};
use crate::shadows::Shadows;
use crate::stage::{FrameContext, Stage, is_fatal};
use crate::startup::{StartingDay, Startup};
use crate::tracing::TraceThread;
use crate::{ball, command_line, keys, wireframes};

/// Number of frames in the plot of times.
const HISTORY: usize = 240;
/// Speed of flight, in distances from eye to target per second.
const FLIGHT_PER_SECOND: f64 = 0.8;

/// Flight per key press of a script or per short press, in distances from eye to target.
const KEY_FLIGHT: f64 = 0.04;

/// Whether a command moves the camera relative to its position, which needs a scene.
fn is_relative(command: &Command) -> bool {
    use Command::{Fly, Look, Orbit, Pan, Zoom};
    matches!(command, Orbit(_) | Look(_) | Pan(_) | Fly(_) | Zoom(_))
}

/// The state of the search for the ball's path.
#[derive(Clone, Copy, Debug, PartialEq)]
enum BallState {
    None,
    Sought,
    /// The path was found. Later changes of the sun do not change it.
    Known,
}

/// The view.
pub(crate) struct App {
    options: ViewOptions,
    gpu: Gpu,
    sender: EventSender,
    pub(crate) settings: Settings,
    /// The settings that the view started with.
    pub(crate) initial: Settings,
    pub(crate) stage: Option<Stage>,
    pub(crate) loads: Loads,
    /// Number of the load that reloads the shown scene after a change. It keeps the camera and the sun.
    again: Option<u64>,
    /// The watched files.
    followed: Option<(Vec<PathBuf>, FileWatch)>,
    pub(crate) shadows: Shadows,
    /// The day that is played.
    pub(crate) day: Option<Day>,
    tracing: TraceThread,
    /// The reason why the rays requested last could not be traced.
    trace_fault: Option<String>,
    ball: BallState,
    /// Eye and target of a camera that sees the ball's path.
    viewpoint: Option<[[f64; 3]; 2]>,
    pub(crate) messages: Messages,
    player: Option<Player>,
    /// Times of both sides per frame, the latest last.
    pub(crate) times: VecDeque<[FrameTimes; 2]>,
    /// Whether something changed since the last frame.
    dirty: bool,
    /// Number of shadow files being read; the script waits for them.
    reading: u32,
    /// The file that was read last while a scene was loading; it belongs to that scene.
    held_file: Option<(ShownFile, PathBuf)>,
    /// A camera that was requested while a scene was loading; it belongs to that scene.
    held_camera: Option<Camera>,
    pub(crate) resize: Option<[u32; 2]>,
    /// Output path for a picture of the whole window, written when it is drawn next.
    pub(crate) window_shot: Option<PathBuf>,
    /// The result of writing that picture.
    pub(crate) window_shot_done: Option<Result<(), String>>,
    pub(crate) quit: bool,
}

impl App {
    /// Creates the view and starts to load the scene.
    pub(crate) fn new(startup: Startup, gpu: Gpu, sender: EventSender, say: Say) -> Self {
        let Startup { mut options, settings, file, day } = startup;
        let player = options.script.take().map(Player::new);
        let mut shadows = Shadows::new(options.max_memory_bytes, sender.clone());
        if let Some(file) = file {
            shadows.give(file, options.shadow_file.clone());
        }
        let mut fault = None;
        let day = day.map(|StartingDay { mut day, path }| {
            fault = path.and_then(|path| day.read(path, sender.clone()).err());
            day
        });
        let mut app = Self {
            day,
            gpu,
            tracing: TraceThread::start(sender.clone()),
            sender,
            initial: settings.clone(),
            settings,
            stage: None,
            loads: Loads::default(),
            again: None,
            followed: None,
            shadows,
            trace_fault: None,
            ball: BallState::None,
            viewpoint: None,
            messages: Messages::new(say),
            player,
            times: VecDeque::new(),
            dirty: true,
            reading: 0,
            held_file: None,
            held_camera: None,
            resize: None,
            window_shot: None,
            window_shot_done: None,
            quit: false,
            options,
        };
        for note in app.gpu.missing_features() {
            let name = app.gpu.name();
            app.messages.note(format!("{name}: {note}"));
        }
        if let Some(fault) = fault {
            app.messages.error(fault.to_string());
        }
        app.load(app.options.scene.clone());
        app
    }

    fn load(&mut self, path: PathBuf) -> u64 {
        let load = self.loads.begin(path.clone());
        loading::load_scene(load, path, self.options.load.clone(), self.sender.clone());
        load
    }

    /// Executes a user's command; errors are shown as messages.
    pub(crate) fn command(&mut self, command: &Command) {
        if self.stage.is_none() && is_relative(command) {
            // Without a scene there is nothing to move, and the window shows that it is loading.
            return;
        }
        if let Err(what) = self.try_command(command) {
            self.messages.error(what);
        }
    }

    fn try_command(&mut self, command: &Command) -> Result<(), String> {
        self.dirty = true;
        let needs_scene =
            is_relative(command) || matches!(command, Command::SaveCamera(_) | Command::SayLine);
        if needs_scene && self.stage.is_none() {
            return Err("no scene is loaded yet".to_owned());
        }
        if self.settings.apply(command)? {
            match command {
                Command::Camera { .. } => self.hold_camera(),
                Command::Ball(_) => self.seek_ball()?,
                Command::Bake(_) => self.shadows.rebake(),
                Command::Budget(_) => self.read_again(),
                _ => {}
            }
            return Ok(());
        }
        match command {
            Command::Key(key) => {
                let flight = || keys::flight(key).map(|way| Command::Fly(way.map(|w| KEY_FLIGHT * w)));
                let command = keys::command(key, &self.settings).or_else(flight);
                let command = command.ok_or_else(|| format!("{key} does nothing; press ? for help"))?;
                return self.try_command(&command);
            }
            Command::Hour(hour) => {
                let day = self.day.as_mut().ok_or("no day is played; start with --day")?;
                if !hour.is_finite() {
                    return Err(format!("hour {hour}: give a number"));
                }
                day.set(day.at_hour(*hour));
                self.settings.sun = day.sun();
            }
            Command::LoadCamera(path) => {
                let file = CameraFile::read(path).map_err(|e| e.to_string())?;
                let Camera { width, height, .. } = self.settings.camera;
                self.settings.camera = Camera { width, height, ..file.camera };
                if let Some(sun) = file.sun.filter(|sun| !is_same_sun(sun, &self.settings.sun)) {
                    self.settings.sun = sun;
                }
                self.hold_camera();
            }
            Command::ResetSun => self.settings.sun = self.initial.sun,
            Command::ResetCamera => self.reset_camera(),
            Command::ResetAll => {
                let Camera { width, height, .. } = self.settings.camera;
                self.settings = self.initial.clone();
                (self.settings.camera.width, self.settings.camera.height) = (width, height);
                self.held_camera = None;
                self.shadows.return_to_given();
                self.seek_ball()?;
            }
            Command::WatchBall => {
                let [eye, target] = self.viewpoint.ok_or("there is no ball; press b to add one")?;
                (self.settings.camera.eye, self.settings.camera.target) = (eye, target);
            }
            Command::CancelBake => {
                let stage = self.stage.as_ref().ok_or("no bake is running")?;
                if !self.shadows.cancel(&self.settings, stage.scene()) {
                    return Err("no bake is running".to_owned());
                }
                let rest = if self.shadows.has_landed(&self.settings) {
                    "completed levels are kept"
                } else {
                    "no level is complete for this sun"
                };
                self.messages.note(format!("the bake was stopped; {rest}"));
            }
            Command::Drop(path) => self.take_file(path)?,
            Command::Resize(size) => {
                if size.iter().any(|s| !(16..=16_384).contains(s)) {
                    return Err(format!("{} x {}: give 16 to 16384 pixels per side", size[0], size[1]));
                }
                self.resize = Some(*size);
            }
            Command::Screenshot(path) => self.screenshot(path)?,
            Command::WindowShot(path) => self.window_shot = Some(path.clone()),
            Command::SaveCamera(path) => {
                let file = CameraFile { camera: self.settings.camera, sun: Some(self.settings.sun) };
                self.refuse_inputs(path)?;
                file.write(path).map_err(|e| e.to_string())?;
                self.messages.note(format!("camera saved: {}", path.display()));
            }
            Command::SayLine => self.messages.note(self.command_line()),
            Command::Quit => self.quit = true,
            _ => {}
        }
        Ok(())
    }

    fn take_file(&mut self, path: &Path) -> Result<(), String> {
        match loading::drop_kind(path)? {
            DropKind::Scene => _ = self.load(path.to_owned()),
            DropKind::ShadowFile => {
                self.reading += 1;
                loading::read_file(path.to_owned(), self.settings.stream_options(), self.sender.clone());
            }
            DropKind::Camera => self.try_command(&Command::LoadCamera(path.to_owned()))?,
        }
        Ok(())
    }

    /// Keeps a camera that was requested while a scene is loading, because it belongs to that scene.
    fn hold_camera(&mut self) {
        if !self.loads.are_done() {
            self.held_camera = Some(self.settings.camera);
        }
    }

    fn reset_camera(&mut self) {
        self.held_camera = None;
        let Camera { width, height, .. } = self.settings.camera;
        self.settings.camera = Camera { width, height, ..self.initial.camera };
    }

    /// Starts the search for the ball's path if it is unknown, and removes the ball if it is switched off.
    fn seek_ball(&mut self) -> Result<(), String> {
        let Some(stage) = &mut self.stage else { return Ok(()) };
        if !self.settings.ball {
            (self.ball, self.viewpoint) = (BallState::None, None);
            if stage.ball().is_some() {
                stage.set_ball(None).map_err(|e| e.to_string())?;
            }
        } else if self.ball == BallState::None {
            self.ball = BallState::Sought;
            let spec = self.options.ball.clone().map_or_else(|| "sphere".parse::<MoveSpec>(), Ok);
            let spec = spec.map_err(|e| e.to_string())?;
            ball::find(stage.scene().clone(), spec, self.settings.sun.towards(), self.sender.clone());
        }
        Ok(())
    }

    fn screenshot(&mut self, path: &Path) -> Result<(), String> {
        self.try_draw().map_err(|e| e.to_string())?;
        let stage = self.stage.as_ref().ok_or("no scene is loaded yet")?;
        let picture = stage.screenshot(&self.settings).map_err(|e| e.to_string())?;
        self.write_picture(path, &picture)
    }

    /// Returns an error if `output` is one of the input files, which would be overwritten.
    fn refuse_inputs(&self, output: &Path) -> Result<(), String> {
        let ViewOptions { scene: first, shadow_file, inputs, .. } = &self.options;
        let scene = self.stage.as_ref().map_or(first, |stage| &stage.scene().path);
        let given = [scene, first].into_iter().chain(shadow_file).chain(inputs);
        let mut inputs = given.map(|path| &**path).chain(self.shadows.given_path(&self.settings));
        if let Some(input) = inputs.find(|input| same_file(output, input)) {
            return Err(format!(
                "{}: it would overwrite {}, which is in use; give another path",
                output.display(),
                input.display()
            ));
        }
        Ok(())
    }

    /// Writes a picture of what is shown, and reports it as a message.
    pub(crate) fn write_picture(&mut self, path: &Path, picture: &Picture) -> Result<(), String> {
        self.refuse_inputs(path)?;
        let bytes = png(path, picture).map_err(|e| e.to_string())?;
        replace_file(path, |file| {
            use std::io::Write as _;
            file.write_all(&bytes).map(|()| bytes.len() as u64)
        })
        .map_err(|e| e.to_string())?;
        self.messages.note(format!(
            "screenshot: {} ({} x {})",
            path.display(),
            picture.width,
            picture.height
        ));
        Ok(())
    }

    /// Returns the device's name and driver.
    pub(crate) fn adapter(&self) -> String {
        self.gpu.name()
    }

    /// Returns the command line that reproduces this view. It includes a shadow file that was given or
    /// dropped, if it was baked for the current sun.
    pub(crate) fn command_line(&self) -> String {
        let scene = self.stage.as_ref().map_or(&self.options.scene, |s| &s.scene().path);
        let ball = self.options.ball_text.as_deref();
        let of_day =
            self.options.shadow_file.as_deref().filter(|_| self.day.as_ref().is_some_and(Day::is_read));
        let file = self.shadows.given_path(&self.settings).or(of_day);
        let day = self.day.as_ref().map(|day| (self.options.day.as_ref(), day.hour()));
        let words = command_line::of(scene, file, day, ball, &self.settings);
        [&[words], &self.options.repeated[..]].concat().join(" ")
    }

    /// Sets the size of the window, in pixels.
    pub(crate) fn set_size(&mut self, [width, height]: [u32; 2]) {
        let camera = &mut self.settings.camera;
        if [camera.width, camera.height] != [width, height] && width > 0 && height > 0 {
            (camera.width, camera.height) = (width, height);
            self.dirty = true;
        }
    }

    /// Advances by `seconds`: time, flight, bakes, rays, and the script.
    ///
    /// # Errors
    /// Returns an error if a step of the script failed.
    pub(crate) fn tick(&mut self, seconds: f64, flight: [f64; 3]) -> Result<()> {
        if flight != [0.0; 3] {
            let step = FLIGHT_PER_SECOND * seconds.min(0.25);
            self.command(&Command::Fly(flight.map(|f| f * step)));
        }
        let Some(stage) = &mut self.stage else { return self.play() };
        if self.settings.playing
            && let Some(end) = stage.end_seconds()
        {
            self.settings.seconds = (self.settings.seconds + seconds) % end.max(1e-3);
            self.dirty = true;
        }
        if let Some(day) = &mut self.day {
            if self.settings.playing {
                day.advance(seconds);
            }
            if self.settings.playing || day.is_read() {
                self.dirty |= !is_same_sun(&self.settings.sun, &day.sun());
                self.settings.sun = day.sun();
            }
            match day.follow(&self.settings, stage.scene(), self.options.max_memory_bytes, &self.sender) {
                Change::None => {}
                Change::Redraw => self.dirty = true,
                Change::Begin(light) => {
                    self.shadows.follow(ShownFile::Moving(light));
                    stage.forget_file();
                    self.dirty = true;
                }
            }
            if let Some(fault) = day.take_fault() {
                self.messages.error(format!("no more keys of the day: {fault}"));
            }
        } else if self.shadows.reconcile(&self.settings, stage.scene()) {
            stage.forget_file();
            self.dirty = true;
        }
        if let Some(streamed) = self.shadows.file().and_then(ShownFile::streamed) {
            for fault in streamed.take_faults() {
                self.messages.error(format!("the shadow file: {fault}"));
            }
        }
        match stage.trace_key(&self.settings).filter(|key| !self.settings.playing && !stage.has_traced(key)) {
            Some(key) => {
                if self.tracing.ask(key, stage.scene(), stage.ball()) {
                    self.trace_fault = None;
                }
            }
            None => self.tracing.cancel(),
        }
        self.play()
    }

    /// Whether a frame must be drawn.
    pub(crate) fn needs_frame(&self) -> bool {
        self.dirty || self.settings.continuous || self.shadows.is_streaming(&self.settings)
    }

    /// Reads the shown file again, after a change of the budget.
    fn read_again(&mut self) {
        if let Some(path) = self.shadows.given_path(&self.settings).map(Path::to_owned) {
            self.reading += 1;
            loading::read_file(path, self.settings.stream_options(), self.sender.clone());
        }
    }

    /// Whether anything progresses without user input, so that the event loop must not sleep.
    pub(crate) fn is_busy(&self) -> bool {
        let moves = self.day.is_some() || self.stage.as_ref().is_some_and(|s| s.end_seconds().is_some());
        let plays = self.settings.playing && moves;
        plays
            || self.settings.continuous
            || self.player.is_some()
            || self.shadows.is_streaming(&self.settings)
    }

    /// Draws the scene, if there is one.
    ///
    /// # Errors
    /// Returns an error if the device is lost.
    pub(crate) fn draw(&mut self) -> Result<()> {
        match self.try_draw() {
            Err(error) if is_fatal(&error) => Err(error.into()),
            Err(error) => {
                self.messages.error(error.to_string());
                Ok(())
            }
            Ok(()) => Ok(()),
        }
    }

    fn try_draw(&mut self) -> Result<(), RenderError> {
        self.dirty = false;
        let Some(stage) = &mut self.stage else { return Ok(()) };
        let lines = if self.settings.show_box {
            self.shadows
                .file()
                .filter(|_| self.settings.uses_file())
                .map(|file| wireframes::of_grid(&file.grid()))
                .unwrap_or_default()
        } else {
            Vec::new()
        };
        let context = FrameContext { file: self.shadows.file(), lines: &lines };
        let drawn = stage.draw(&self.settings, &context);
        stage.take_faults().for_each(|what| self.messages.error(what));
        drawn?;
        if self.times.len() == HISTORY {
            self.times.pop_front();
        }
        self.times.push_back([Side::First, Side::Second].map(|side| *stage.side(side).times()));
        if let Some(player) = &mut self.player {
            player.frame();
        }
        Ok(())
    }
}
