//! Handles the results of other threads: scenes, files, levels of bakes, traced rays, and the ball's path.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use adumbra_files::{FileWatch, folder_of};
use adumbra_program::sun::{SunSource, sun_of_scene};
use adumbra_scene::{Camera, Projection};
use adumbra_truth::movers::BallPath;

use super::{App, BallState};
use crate::error::{OptionField, Result, ViewError};
use crate::event::Event;
use crate::loaded_scene::LoadedScene;
use crate::loading::{self, Loads};
use crate::shadow_file::ShownFile;
use crate::stage::{Stage, is_fatal};

impl App {
    /// Handles an event from another thread.
    ///
    /// # Errors
    /// Returns an error if the view cannot continue: its first scene cannot be loaded, or the device is lost.
    pub(crate) fn receive(&mut self, event: Event) -> Result<()> {
        // Progress only changes the panel.
        self.dirty |= !matches!(event, Event::Baking { .. });
        match event {
            Event::Scene { load, loaded: Ok(scene) } => {
                if self.loads.came(load) {
                    self.enter(load, &scene)?;
                }
            }
            Event::Scene { load, loaded: Err(error) } => {
                self.loads.failed(load);
                if self.stage.is_none() && self.loads.are_done() {
                    return Err(error);
                }
                self.messages.error(error.to_string());
                self.enter_held()?;
            }
            Event::Changed => self.load_again(),
            Event::File { path, read } => {
                self.reading -= 1;
                match read {
                    Ok(file) if !self.loads.are_done() => self.held_file = Some((file, path)),
                    Ok(file) => self.enter_file(file, path)?,
                    Err(what) => self.messages.error(what),
                }
            }
            Event::Baking { bake, resolution, share } => self.shadows.progress(bake, resolution, share),
            Event::Baked { bake, file, last } => {
                if self.shadows.landed(bake, ShownFile::whole(*file), last, &self.settings) {
                    self.forget_file();
                }
            }
            // The next tick reads the key.
            Event::Key => {}
            Event::BakeEnded { bake, error } => {
                if let Some(error) = &error {
                    self.messages.error(format!("the bake failed: {error}"));
                }
                self.shadows.ended(bake, error);
            }
            Event::Traced(traced) => {
                if let Some(stage) = &mut self.stage {
                    stage.set_traced(traced);
                }
            }
            Event::NotTraced { error } => {
                self.messages.error(format!("ray tracing failed: {error}"));
                self.trace_fault = Some(error);
            }
            Event::Ball { scene, found, .. } => self.enter_ball(scene, found)?,
        }
        Ok(())
    }

    fn enter(&mut self, load: u64, scene: &Arc<LoadedScene>) -> Result<()> {
        let is_only = self.stage.is_none() && self.loads.are_done();
        let stage = match Stage::new(&self.gpu, scene.clone()) {
            Ok(stage) => stage,
            Err(error) if is_only || is_fatal(&error) => return Err(error.into()),
            Err(error) => {
                self.messages.error(error.to_string());
                return self.enter_held();
            }
        };
        self.options.inputs.extend_from_slice(&scene.named_files);
        for note in &scene.notes {
            self.messages.note(format!("{}: {note}", scene.path.display()));
        }
        let bounds = stage.bounds();
        self.stage = Some(stage);
        self.follow_files(scene);
        if self.again == Some(load) {
            (self.ball, self.viewpoint) = (BallState::None, None);
            if let Err(what) = self.seek_ball() {
                self.messages.error(what);
            }
            return self.enter_held();
        }
        self.take_sun_of(scene)?;
        let fov = match self.options.projection {
            Projection::Perspective { fov_degrees } => fov_degrees,
            Projection::Orthographic { .. } => 45.0,
        };
        let whole = Camera::overview(&bounds, fov);
        let Camera { width, height, .. } = self.settings.camera;
        let is_first = load == Loads::FIRST;
        let given = |place: Option<[f64; 3]>| place.filter(|_| is_first);
        self.initial.camera = Camera {
            eye: given(self.options.eye).unwrap_or(whole.eye),
            target: given(self.options.target).unwrap_or(whole.target),
            projection: self.options.projection,
            width,
            height,
        };
        if self.initial.camera.eye == self.initial.camera.target {
            let what = "the camera's eye is at the scene's centre; give its target too".to_owned();
            return Err(ViewError::Options { field: OptionField::Target, what });
        }
        let held = self.held_camera.take();
        self.reset_camera();
        self.held_camera = held;
        if !is_first {
            self.shadows.clear();
            self.settings.ball = false;
        }
        (self.ball, self.viewpoint) = (BallState::None, None);
        self.times.clear();
        if let Err(what) = self.seek_ball() {
            self.messages.error(what);
        }
        self.enter_held()
    }

    /// Loads the scene and the shadow file again, because some of their files have changed.
    fn load_again(&mut self) {
        let Some(scene) = self.stage.as_ref().map(|stage| stage.scene().path.clone()) else { return };
        self.messages.note(format!("{} has changed", scene.display()));
        self.again = Some(self.load(scene));
        if let Some(file) = self.shadows.given_path(&self.settings).map(Path::to_owned) {
            self.reading += 1;
            loading::read_file(file, self.settings.stream_options(), self.sender.clone());
        }
    }

    /// Watches the files of the shown scene, if that was requested.
    fn follow_files(&mut self, scene: &LoadedScene) {
        if !self.options.watch {
            return;
        }
        let named = scene.named_files.iter().filter(|file| folder_of(file).is_dir());
        let files: Vec<PathBuf> =
            [&scene.path].into_iter().chain(named).chain(&self.options.shadow_file).cloned().collect();
        if self.followed.as_ref().is_some_and(|(followed, _)| *followed == files) {
            return;
        }
        let sender = self.sender.clone();
        match FileWatch::new(&files, move || sender.send(Event::Changed)) {
            Ok(watch) => self.followed = Some((files, watch)),
            Err(error) => self.messages.error(error.to_string()),
        }
    }

    /// Uses the scene's sun, unless an option or a shadow file gives one. A scene that replaces another and
    /// has no light leaves the sun as it is.
    fn take_sun_of(&mut self, scene: &LoadedScene) -> Result<()> {
        if self.options.sun.is_some() || self.options.shadow_file.is_some() {
            return Ok(());
        }
        let (chosen, messages) = sun_of_scene(&scene.whole)?;
        let path = scene.path.display();
        messages.into_iter().for_each(|message| self.messages.note(format!("{path}: {message}")));
        if chosen.origin.source == SunSource::Light {
            self.messages.note(format!("{path}: {chosen}"));
            self.initial.sun = chosen.sun;
            self.settings.sun = chosen.sun;
        }
        Ok(())
    }

    /// Applies the camera and the file that arrived while scenes were loading, once no scene is loading any
    /// more.
    fn enter_held(&mut self) -> Result<()> {
        if !self.loads.are_done() {
            return Ok(());
        }
        if let Some(camera) = self.held_camera.take() {
            let Camera { width, height, .. } = self.settings.camera;
            self.settings.camera = Camera { width, height, ..camera };
        }
        self.held_file.take().map_or(Ok(()), |(file, path)| self.enter_file(file, path))
    }

    fn enter_file(&mut self, file: ShownFile, path: PathBuf) -> Result<()> {
        self.settings.sun = file.sun();
        if let Some(stage) = &self.stage {
            let b = stage.bounds();
            let middle = std::array::from_fn(|a| 0.5 * (b.min[a] + b.max[a]));
            if !file.contains(middle) {
                let path = path.display();
                self.messages.note(format!(
                    "{path}: it does not contain this scene's centre; was it baked from another scene?"
                ));
            }
            if file.settings().ignore_alpha != stage.scene().ignore_alpha {
                let path = path.display();
                self.messages.note(format!(
                    "{path}: it was baked with a different setting for ignoring alpha than this view uses"
                ));
            }
        }
        if !self.settings.uses_file() {
            self.settings.shadows[0] = "voxel".parse()?;
        }
        self.shadows.give(file, Some(path));
        self.forget_file();
        Ok(())
    }

    fn forget_file(&mut self) {
        if let Some(stage) = &mut self.stage {
            stage.forget_file();
        }
    }

    fn enter_ball(&mut self, scene: u64, found: Result<(BallPath, [[f64; 3]; 2]), String>) -> Result<()> {
        let Some(stage) = self.stage.as_mut().filter(|s| s.scene().number == scene) else { return Ok(()) };
        if self.ball != BallState::Sought {
            return Ok(());
        }
        self.ball = BallState::Known;
        match found {
            Ok((path, viewpoint)) => {
                stage.set_ball(Some(path))?;
                let Camera { width, height, .. } = self.initial.camera;
                let untouched = Camera { width, height, ..self.settings.camera } == self.initial.camera;
                if self.viewpoint.is_none() && self.options.ball.is_some() && untouched {
                    // As in `render`: the camera looks at the ball unless the user placed it.
                    let [eye, target] = viewpoint;
                    let camera = &mut self.initial.camera;
                    camera.eye = self.options.eye.unwrap_or(eye);
                    camera.target = self.options.target.unwrap_or(target);
                    self.reset_camera();
                }
                self.viewpoint = Some(viewpoint);
            }
            Err(what) => {
                self.settings.ball = false;
                self.ball = BallState::None;
                self.messages.error(what);
            }
        }
        Ok(())
    }
}
