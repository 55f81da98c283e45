//! The view without its window: takes commands, keeps everything in step, and draws; `arrivals` takes what other threads tell, `playing`
//! plays the script.

mod arrivals;
mod playing;

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

use adumbra::camera::Camera;
use adumbra::files::{replace_file, same_file};
use adumbra::format::AnyFile;
use adumbra::picture::Picture;
use adumbra_lab::camera_file::CameraFile;
use adumbra_lab::pictures::png;
use adumbra_render::movers::MoveSpec;
use adumbra_render::{FrameTimes, Gpu, RenderError};

use crate::beginning::Beginning;
use crate::boxes;
use crate::command::{Command, Side};
use crate::error::Result;
use crate::keys;
use crate::loading::{self, DropKind, Loads};
use crate::messages::{Messages, Say};
use crate::news::Teller;
use crate::options::ViewOptions;
use crate::player::Player;
use crate::settings::Settings;
use crate::shadow_file::is_same_sun;
use crate::shadows::Shadows;
use crate::stage::{FrameContext, Stage, is_fatal};
use crate::tracing::TraceThread;
use crate::{ball, command_line};

/// Frames that the plot of times shows.
const HISTORY: usize = 240;
/// Distances from eye to target that a second of flying is worth.
const FLIGHT_PER_SECOND: f64 = 0.8;

/// Of them a key that a script presses, or that is pressed for a moment, is worth.
const KEY_FLIGHT: f64 = 0.04;

/// Whether a command moves a camera from where it stands, for which a scene must be there.
fn is_relative(command: &Command) -> bool {
    use Command::{Fly, Look, Orbit, Pan, Zoom};
    matches!(command, Orbit(_) | Look(_) | Pan(_) | Fly(_) | Zoom(_))
}

/// Where the ball stands.
#[derive(Clone, Copy, Debug, PartialEq)]
enum BallState {
    None,
    Sought,
    /// It was found; a sun that moves later does not change it.
    Known,
}

/// The view.
pub(crate) struct App {
    options: ViewOptions,
    gpu: Gpu,
    teller: Teller,
    pub(crate) settings: Settings,
    /// As the view began.
    pub(crate) begin: Settings,
    pub(crate) stage: Option<Stage>,
    pub(crate) loads: Loads,
    pub(crate) shadows: Shadows,
    tracing: TraceThread,
    /// Why the rays that were asked for last do not come.
    trace_fault: Option<String>,
    ball: BallState,
    /// Eye and target that see the ball's way.
    viewpoint: Option<[[f64; 3]; 2]>,
    pub(crate) messages: Messages,
    player: Option<Player>,
    /// Times of both sides, the latest last.
    pub(crate) times: VecDeque<[FrameTimes; 2]>,
    /// Something changed since the last frame.
    dirty: bool,
    /// A scene or a file is read, after which the script goes on.
    reading: u32,
    /// Files that were read while a scene is loaded: they are the scene's.
    held_files: Vec<(AnyFile, PathBuf)>,
    /// The same of a camera.
    held_camera: Option<Camera>,
    pub(crate) resize: Option<[u32; 2]>,
    /// Where the whole window is to be written when it is drawn next.
    pub(crate) window_shot: Option<PathBuf>,
    /// How that went.
    pub(crate) window_shot_done: Option<Result<(), String>>,
    pub(crate) quit: bool,
}

impl App {
    /// Begins to load.
    pub(crate) fn new(beginning: Beginning, gpu: Gpu, teller: Teller, say: Say) -> Self {
        let Beginning { mut options, settings, files } = beginning;
        let player = options.script.take().map(Player::new);
        let mut shadows = Shadows::new(options.max_memory_bytes, teller.clone());
        for (file, path) in files.into_iter().zip(&options.shadow_files) {
            shadows.give(file, Some(path.clone()));
        }
        let mut app = Self {
            gpu,
            tracing: TraceThread::start(teller.clone()),
            teller,
            begin: settings.clone(),
            settings,
            stage: None,
            loads: Loads::default(),
            shadows,
            trace_fault: None,
            ball: BallState::None,
            viewpoint: None,
            messages: Messages::new(say),
            player,
            times: VecDeque::new(),
            dirty: true,
            reading: 0,
            held_files: Vec::new(),
            held_camera: None,
            resize: None,
            window_shot: None,
            window_shot_done: None,
            quit: false,
            options,
        };
        for note in app.gpu.left_out() {
            let name = app.gpu.name();
            app.messages.note(format!("{name}: {note}"));
        }
        app.load(app.options.scene.clone());
        app
    }

    fn load(&mut self, path: PathBuf) {
        let load = self.loads.begin(path.clone());
        loading::load_scene(load, path, self.options.load.clone(), self.teller.clone());
    }

    /// Does what a user asks; what goes wrong is shown.
    pub(crate) fn command(&mut self, command: &Command) {
        if self.stage.is_none() && is_relative(command) {
            // Whoever turns what is not there yet sees that it is loaded.
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
            return Err("there is no scene yet".to_owned());
        }
        if self.settings.apply(command)? {
            match command {
                Command::Camera { .. } => self.hold_camera(),
                Command::Ball(_) => self.seek_ball()?,
                Command::Bake(_) => self.shadows.rebake(),
                _ => {}
            }
            return Ok(());
        }
        match command {
            Command::Key(key) => {
                let flight = || keys::flight(key).map(|way| Command::Fly(way.map(|w| KEY_FLIGHT * w)));
                let command = keys::command(key, &self.settings).or_else(flight);
                let command = command.ok_or_else(|| format!("{key} does nothing; press ?"))?;
                return self.try_command(&command);
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
            Command::ResetSun => self.settings.sun = self.begin.sun,
            Command::ResetCamera => self.reset_camera(),
            Command::ResetAll => {
                let Camera { width, height, .. } = self.settings.camera;
                self.settings = self.begin.clone();
                (self.settings.camera.width, self.settings.camera.height) = (width, height);
                self.held_camera = None;
                self.shadows.return_to_given();
                self.seek_ball()?;
            }
            Command::WatchBall => {
                let [eye, target] = self.viewpoint.ok_or("there is no ball; b makes one")?;
                (self.settings.camera.eye, self.settings.camera.target) = (eye, target);
            }
            Command::CancelBake => {
                let stage = self.stage.as_ref().ok_or("there is no bake to stop")?;
                if !self.shadows.cancel(&self.settings, stage.scene()) {
                    return Err("there is no bake to stop".to_owned());
                }
                let rest = if self.shadows.has_landed(&self.settings) {
                    "what landed stays"
                } else {
                    "what is shown is of another sun, or nothing"
                };
                self.messages.note(format!("the bake is stopped; {rest}"));
            }
            Command::Drop(path) => self.take_file(path)?,
            Command::Resize(size) => {
                if size.iter().any(|s| !(16..=16_384).contains(s)) {
                    return Err(format!("{} x {}: give 16 to 16384 pixels a side", size[0], size[1]));
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
            DropKind::Scene => self.load(path.to_owned()),
            DropKind::ShadowFile => {
                self.reading += 1;
                loading::read_file(path.to_owned(), self.teller.clone());
            }
            DropKind::Camera => self.try_command(&Command::LoadCamera(path.to_owned()))?,
        }
        Ok(())
    }

    /// Keeps a camera that was asked for while a scene is loaded: it is the scene's.
    fn hold_camera(&mut self) {
        if !self.loads.are_done() {
            self.held_camera = Some(self.settings.camera);
        }
    }

    fn reset_camera(&mut self) {
        self.held_camera = None;
        let Camera { width, height, .. } = self.settings.camera;
        self.settings.camera = Camera { width, height, ..self.begin.camera };
    }

    /// Looks for the ball's way where it is not known, and puts the ball on it or takes it away.
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
            ball::find(stage.scene().clone(), spec, self.settings.sun.towards(), self.teller.clone());
        }
        Ok(())
    }

    fn screenshot(&mut self, path: &Path) -> Result<(), String> {
        self.try_draw().map_err(|e| e.to_string())?;
        let stage = self.stage.as_ref().ok_or("there is no scene yet")?;
        let picture = stage.screenshot(&self.settings).map_err(|e| e.to_string())?;
        self.write_picture(path, &picture)
    }

    /// That a path is none of what was read, which would be lost.
    fn refuse_inputs(&self, output: &Path) -> Result<(), String> {
        let ViewOptions { scene: first, shadow_files, inputs, .. } = &self.options;
        let scene = self.stage.as_ref().map_or(first, |stage| &stage.scene().path);
        let given = [scene, first].into_iter().chain(shadow_files).chain(inputs);
        let mut inputs = given.map(|path| &**path).chain(self.shadows.given_paths(&self.settings));
        if let Some(input) = inputs.find(|input| same_file(output, input)) {
            return Err(format!(
                "{}: it is {} itself, which is in use; give another path",
                output.display(),
                input.display()
            ));
        }
        Ok(())
    }

    /// Writes a picture of what is seen, and says so.
    pub(crate) fn write_picture(&mut self, path: &Path, picture: &Picture) -> Result<(), String> {
        self.refuse_inputs(path)?;
        let bytes = png(picture).map_err(|e| e.to_string())?;
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

    /// The device's name and driver.
    pub(crate) fn adapter(&self) -> String {
        self.gpu.name()
    }

    /// The command that shows this view again: with shadow files that were given or dropped, as long as the sun stands where they say.
    pub(crate) fn command_line(&self) -> String {
        let scene = self.stage.as_ref().map_or(&self.options.scene, |s| &s.scene().path);
        let ball = self.options.ball_text.as_deref();
        let files = self.shadows.given_paths(&self.settings);
        let words = command_line::of(scene, &files, ball, &self.settings);
        [&[words], &self.options.repeated[..]].concat().join(" ")
    }

    /// What the window is now, pixels.
    pub(crate) fn set_size(&mut self, [width, height]: [u32; 2]) {
        let camera = &mut self.settings.camera;
        if [camera.width, camera.height] != [width, height] && width > 0 && height > 0 {
            (camera.width, camera.height) = (width, height);
            self.dirty = true;
        }
    }

    /// Goes on by some seconds: time, flight, bakes, rays, the script.
    ///
    /// # Errors
    /// A step of the script that failed.
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
        if self.shadows.reconcile(&self.settings, stage.scene()) {
            stage.forget_files();
            self.dirty = true;
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

    /// Whether a frame is to be drawn.
    pub(crate) fn needs_frame(&self) -> bool {
        self.dirty || self.settings.continuous
    }

    /// Whether something goes on by itself, so that the window must not sleep.
    pub(crate) fn is_busy(&self) -> bool {
        let plays = self.settings.playing && self.stage.as_ref().is_some_and(|s| s.end_seconds().is_some());
        plays || self.settings.continuous || self.player.is_some()
    }

    /// Draws the scene, if there is one.
    ///
    /// # Errors
    /// A device that is gone.
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
            let file = self.settings.seen().iter().find_map(|s| self.shadows.files.of(s));
            file.map(boxes::of_file).unwrap_or_default()
        } else {
            Vec::new()
        };
        let context = FrameContext { files: &self.shadows.files, lines: &lines };
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
