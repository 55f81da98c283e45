//! `adumbra bake --watch`: bakes again whenever the scene's files change.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use adumbra_bake::{BakedParts, Baker, BestEffortCache, Error, Watch};
use adumbra_files::{self as files, FileWatch};
use adumbra_program::exit::{Failure, Outcome};
use adumbra_program::output::{format_bytes, print_json_line};
use adumbra_program::progress::{Reporter, Units};
use adumbra_program::say;
use adumbra_program::scene::load_scene_within;
use adumbra_program::sun::warn_of_low_sun;
use adumbra_program::threads::with_threads;
use adumbra_scene::Scene;
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::Bake;
use crate::cmd::ground::DecidedGround;

/// Interval at which a waiting program checks for changes.
const LOOK: Duration = Duration::from_millis(50);

/// What is printed with `--json` after each bake, in one line.
#[derive(Serialize, JsonSchema)]
pub(super) struct BakedAgain {
    /// The shadow file that was written.
    file: String,
    /// Wall time of loading the scene.
    load_seconds: f64,
    /// Wall time of finding what the edit touches.
    plan_seconds: f64,
    /// Wall time of baking that.
    bake_seconds: f64,
    /// Wall time of linking all pages to a file, and of writing it.
    link_seconds: f64,
    /// Number of parts that were baked.
    baked_parts: usize,
    /// Number of parts of the file.
    parts: usize,
    /// Length of the shadow file, in bytes.
    file_bytes: u64,
}

/// A bake that follows a scene.
struct Follower<'a> {
    args: &'a Bake,
    output: &'a Path,
    /// Set when the scene has changed.
    changed: Arc<AtomicBool>,
    /// Stops a bake, because there is something newer.
    stop: Arc<AtomicBool>,
}

pub(super) fn run(args: &Bake, output: &Path, cache: Option<BestEffortCache>) -> Outcome {
    with_threads(args.run.threads, || {
        let (changed, stop) = Default::default();
        Follower { args, output, changed, stop }.follow(cache)
    })?
}

impl Follower<'_> {
    fn follow(&self, cache: Option<BestEffortCache>) -> Outcome {
        let start = Instant::now();
        let scene = self.load()?;
        let load_seconds = start.elapsed().as_secs_f64();
        let sun = self.args.settings.sun.choose(&scene, &self.args.scene)?;
        warn_of_low_sun(&sun.sun);
        let mut followed = self.follow_files(&scene)?;
        let start = Instant::now();
        let mut options = self.args.settings.options(sun.sun, self.args.load.ignore_alpha).with(|o| {
            o.max_memory_bytes = self.args.run.memory_limit().share(scene.memory_bytes()).bytes();
            o.spill_folder = Some(files::target_folder(self.output));
        });
        let ground = DecidedGround::of(&scene, &mut options);
        if !self.args.run.json {
            say!("  {ground}");
        }
        let mut baker = match cache {
            Some(cache) => Baker::with_cache(scene, &options, cache.with_memory())?,
            None => Baker::new(scene, &options)?,
        };
        let mut times = [load_seconds, start.elapsed().as_secs_f64()];
        self.write_coarser(&mut baker)?;
        loop {
            match self.bake(&mut baker, times) {
                // The scene has changed: bake the newer one.
                Err(Failure::Bake(Error::Interrupted)) if self.changed.load(Ordering::Relaxed) => {}
                // The cache can no longer return these entries: bake them again.
                Err(Failure::Bake(Error::MissingParts { .. })) => {
                    baker.forget();
                    continue;
                }
                done => done?,
            }
            loop {
                let (scene, load_seconds) = self.next_scene();
                if followed.0 != self.files_of(&scene) {
                    followed = self.follow_files(&scene)?;
                }
                let start = Instant::now();
                match baker.replace(scene) {
                    Ok(()) => {
                        times = [load_seconds, start.elapsed().as_secs_f64()];
                        break;
                    }
                    Err(error) => adumbra_program::note!("warning: {error}; the shadow file is as before"),
                }
            }
        }
    }

    fn load(&self) -> Result<Scene, Failure> {
        load_scene_within(self.args.run.memory_limit(), &self.args.scene, &self.args.load.load_options()?)
    }

    /// Waits until the scene has changed and can be loaded; returns it with the seconds of loading.
    fn next_scene(&self) -> (Scene, f64) {
        loop {
            while !self.changed.swap(false, Ordering::Relaxed) {
                thread::sleep(LOOK);
            }
            self.stop.store(false, Ordering::Relaxed);
            let start = Instant::now();
            match self.load() {
                Ok(scene) => return (scene, start.elapsed().as_secs_f64()),
                Err(error) => adumbra_program::note!("warning: {error}; the shadow file is as before"),
            }
        }
    }

    /// Returns the files that make up the scene.
    fn files_of(&self, scene: &Scene) -> Vec<PathBuf> {
        let folder = files::folder_of(&self.args.scene);
        let named = scene.notes.named_files.iter().map(|name| folder.join(name));
        // Skip named files in missing folders, which cannot be watched.
        let named = named.filter(|file| files::folder_of(file).is_dir());
        let own = [Some(&self.args.scene), self.args.load.edit()].into_iter().flatten().cloned();
        own.chain(named).collect()
    }

    fn follow_files(&self, scene: &Scene) -> Result<(Vec<PathBuf>, FileWatch), Failure> {
        let files = self.files_of(scene);
        let (changed, stop) = (self.changed.clone(), self.stop.clone());
        let watch = FileWatch::new(&files, move || {
            changed.store(true, Ordering::Relaxed);
            stop.store(true, Ordering::Relaxed);
        })?;
        Ok((files, watch))
    }

    /// Writes a file of the coarser levels, long before the file of all levels is done. Does nothing if there
    /// is already a file.
    fn write_coarser(&self, baker: &mut Baker) -> Result<(), Failure> {
        if baker.grids().len() == 1 || self.output.exists() {
            return Ok(());
        }
        baker.bake_coarser(self.args.focus, Watch::none())?;
        baker.save_coarser(self.output, Watch::none())?;
        Ok(())
    }

    fn bake(&self, baker: &mut Baker, [load_seconds, plan_seconds]: [f64; 2]) -> Result<(), Failure> {
        let start = Instant::now();
        let reporter = Reporter::new(self.args.progress, Units::TEXELS);
        let progress = |p| reporter.update(p);
        let BakedParts { baked, .. } = baker.bake(self.args.focus, Watch::new(&progress, &self.stop))?;
        let bake_seconds = start.elapsed().as_secs_f64();
        let start = Instant::now();
        let watch = Watch::new(&|_| {}, &self.stop);
        let written = baker.save(self.output, watch)?;
        let link_seconds = start.elapsed().as_secs_f64();
        let parts = baker.plan().parts().len();
        if self.args.run.json {
            print_json_line(&BakedAgain {
                file: self.output.display().to_string(),
                load_seconds,
                plan_seconds,
                bake_seconds,
                link_seconds,
                baked_parts: baked,
                parts,
                file_bytes: written.bytes,
            })?;
        } else {
            let (file, bytes) = (self.output.display(), format_bytes(written.bytes));
            say!(
                "{file} ({bytes}): {baked} of {parts} parts; load {load_seconds:.2} s, plan {plan_seconds:.2} s, bake \
                 {bake_seconds:.2} s, link {link_seconds:.2} s"
            );
        }
        Ok(())
    }
}
