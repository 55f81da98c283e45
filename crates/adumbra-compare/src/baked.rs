//! The baked files that techniques sample: given, or baked on demand.

use std::any::Any;
use std::path::{Path, PathBuf};

use adumbra::{Filter, PathSampler, PointVisibility, ShadowFile, Sun, SunPath};
use adumbra_bake::{Bake, BakeOptions, Size};
use adumbra_program::exit::Failure;
use adumbra_program::lookup::LookupArgs;
use adumbra_program::memory::MemoryLimit;
use adumbra_program::moment::{PathMoment, TimeArg, moment, path_moment, shown, sun_path};
use adumbra_program::output::note_input;
use adumbra_render::voxel::LightFile;
use adumbra_render::{Reads, RenderError, TechniqueFiles, TechniqueSpec};
use adumbra_scene::{LoadedAs, Scene};

use crate::Result;
use crate::report::BakedFigures;

/// The properties of a baked file that a comparison needs.
#[derive(Clone, Copy, Debug)]
pub struct FileFacts {
    /// The sun that it was baked for.
    pub sun: Sun,
    /// How its scene was loaded.
    pub scene: LoadedAs,
}

/// Baked files of the kinds that a dependent crate adds, for its techniques.
pub trait MoreFiles: Send + Sync {
    /// Reads a file. `None` if it is not of these kinds.
    ///
    /// # Errors
    ///
    /// Returns an error if the file cannot be read, or if a file of its kind was already read.
    fn read(&mut self, path: &Path) -> Result<Option<FileFacts>>;

    /// Whether the file that a technique reads is present.
    fn serves(&self, spec: &TechniqueSpec) -> bool;

    /// Returns the message to print before [`MoreFiles::bake`] bakes for a technique.
    fn announcement(&self, spec: &TechniqueSpec, how: &BakeOnDemand<'_>) -> String;

    /// Bakes the file that a technique reads.
    ///
    /// # Errors
    ///
    /// Returns an error if the bake fails.
    fn bake(&mut self, spec: &TechniqueSpec, how: &BakeOnDemand<'_>) -> Result<()>;

    /// Returns the files in the form that the techniques expect as [`TechniqueFiles::other`].
    fn files(&self) -> &(dyn Any + Send + Sync);

    /// Returns the look-up of the file, for pictures on the CPU. `None` without a file.
    ///
    /// # Errors
    ///
    /// Returns an error for a look-up that does not exist.
    fn lookup(&self, args: &LookupArgs) -> Result<Option<Box<dyn PointVisibility + '_>>>;

    /// Returns the technique that looks up the file. `None` without a file.
    fn technique(&self, args: &LookupArgs) -> Option<String>;

    /// Returns the figures of the files for the report.
    fn figures(&self) -> Vec<BakedFigures>;
}

/// The baked files of a comparison, at most one of each kind.
#[derive(Default)]
pub struct BakedFiles {
    /// The light-aligned file.
    pub light: Option<ShadowFile>,
    /// A moment of a sun path, in place of a light-aligned file.
    between: Option<PathMoment>,
    /// Further kinds of files.
    pub more: Option<Box<dyn MoreFiles>>,
    /// The properties shared by the given files.
    given: Option<FileFacts>,
}

/// Options of bakes on demand.
pub struct BakeOnDemand<'a> {
    /// The scene to bake.
    pub scene: &'a Scene,
    /// The sun.
    pub sun: Sun,
    /// Whether alpha-masked materials count as opaque.
    pub ignore_alpha: bool,
    /// Texels along the longest side of a light-aligned file.
    pub resolution: u64,
    /// Memory limit of a bake in bytes.
    pub max_memory_bytes: Option<u64>,
}

impl BakeOnDemand<'_> {
    /// Returns the options of a bake.
    pub(crate) fn options(&self) -> BakeOptions {
        BakeOptions::new(self.sun, Size::Resolution(self.resolution)).with(|o| {
            o.ignore_alpha = self.ignore_alpha;
            o.max_memory_bytes = self.max_memory_bytes;
        })
    }
}

impl BakedFiles {
    /// Creates an empty set that can hold further kinds of files.
    pub fn with(more: Option<Box<dyn MoreFiles>>) -> Self {
        Self { more, ..Self::default() }
    }

    /// Reads the files, which may be of the kinds of `more` too.
    ///
    /// # Errors
    ///
    /// Returns an error if a file cannot be read or does not fit into the limit, if two files are of one
    /// kind, or if they have different suns.
    pub fn read(paths: &[PathBuf], limit: MemoryLimit, more: Option<Box<dyn MoreFiles>>) -> Result<Self> {
        Self::read_at(paths, None, limit, more)
    }

    /// Reads the files. One of them may be a sun path; then `time` is required.
    ///
    /// # Errors
    ///
    /// Returns the errors of [`BakedFiles::read`], and an error if there is a time without a path or a path
    /// without a time, or if it is night at that time.
    pub fn read_at(
        paths: &[PathBuf],
        time: Option<TimeArg>,
        limit: MemoryLimit,
        more: Option<Box<dyn MoreFiles>>,
    ) -> Result<Self> {
        let mut files = Self::with(more);
        for path in paths {
            note_input("the shadow file itself", path);
            let facts = match sun_path(path)? {
                Some(sun_path) => files.read_moment(path, &sun_path, time, limit)?,
                None => files.read_one(path, limit)?,
            };
            let before = files.given.get_or_insert(facts);
            if before.sun != facts.sun {
                return Err(Failure::Usage(
                    "--shadow-file: the files were baked for different suns".to_owned(),
                )
                .into());
            }
            before.scene.ignore_alpha |= facts.scene.ignore_alpha;
            let axes = [before.scene.up, facts.scene.up];
            if axes[0].is_some() && axes[1].is_some() && axes[0] != axes[1] {
                return Err(Failure::Usage(
                    "--shadow-file: the files are of scenes with other axes up".to_owned(),
                )
                .into());
            }
            before.scene.up = axes[0].or(axes[1]);
        }
        if time.is_some() && files.between.is_none() {
            return Err(Failure::Usage("--sun-time: give a sun path with --shadow-file".to_owned()).into());
        }
        Ok(files)
    }

    fn read_moment(
        &mut self,
        path: &Path,
        sun_path: &SunPath,
        time: Option<TimeArg>,
        limit: MemoryLimit,
    ) -> Result<FileFacts> {
        let file = path.display();
        let Some(time) = time else {
            return Err(Failure::Usage(format!(
                "--shadow-file: {file} is a sun path; give a moment to render with --sun-time, or move the sun with compare --sun-sweep"
            ))
            .into());
        };
        let seconds = moment(sun_path, "--sun-time", time)?;
        let Some(moment) = path_moment(sun_path, seconds, limit)? else {
            let time = shown(sun_path, seconds);
            return Err(Failure::Usage(format!("--sun-time: at {time} the sun is below the horizon")).into());
        };
        let facts = FileFacts { sun: moment.sun, scene: LoadedAs::from(&moment.keys[0].settings) };
        self.between = Some(moment);
        Ok(facts)
    }

    fn read_one(&mut self, path: &Path, limit: MemoryLimit) -> Result<FileFacts> {
        if let Some(more) = &mut self.more
            && let Some(facts) = more.read(path)?
        {
            return Ok(facts);
        }
        let file = limit.read_shadow_file(path)?.in_world();
        let facts = FileFacts { sun: file.sun(), scene: LoadedAs::from(&file.settings) };
        match self.light.replace(file) {
            None => Ok(facts),
            Some(_) => {
                Err(Failure::Usage("--shadow-file: give at most one file of a kind".to_owned()).into())
            }
        }
    }

    /// Whether a file was given.
    pub fn is_given(&self) -> bool {
        self.given.is_some()
    }

    /// Returns the sun that the given files were baked for, or `None` without files.
    pub fn sun(&self) -> Option<Sun> {
        self.given.map(|facts| facts.sun)
    }

    /// Returns how the scene of the given files was loaded, or `None` without files.
    pub fn scene(&self) -> Option<LoadedAs> {
        self.given.map(|facts| facts.scene)
    }

    /// Whether the file that a technique reads is present, or the technique needs no file.
    pub fn serves(&self, spec: &TechniqueSpec) -> bool {
        match spec.reads() {
            Reads::Nothing => true,
            Reads::LightFile => self.light.is_some() || self.between.is_some(),
            Reads::Other(_) => self.more.as_ref().is_some_and(|more| more.serves(spec)),
        }
    }

    /// Bakes the missing files that `specs` need. Prints a note to stderr before each bake.
    ///
    /// # Errors
    ///
    /// Returns an error if a bake fails.
    pub fn complete(&mut self, specs: &[TechniqueSpec], how: &BakeOnDemand<'_>) -> Result<()> {
        for spec in specs {
            if self.serves(spec) {
                continue;
            }
            if spec.reads() == Reads::LightFile {
                adumbra_program::note!(
                    "note: no light-aligned --shadow-file; baking one with {} texels along its longest side",
                    how.resolution
                );
                self.light = Some(Bake::with_options(how.scene, &how.options()).in_memory()?);
            } else if let Some(more) = &mut self.more {
                adumbra_program::note!("note: {}", more.announcement(spec, how));
                more.bake(spec, how)?;
            }
        }
        Ok(())
    }

    /// Returns the files in the form that techniques take.
    pub fn baked(&self) -> TechniqueFiles<'_> {
        TechniqueFiles {
            light: match (&self.light, &self.between) {
                (Some(file), _) => Some(LightFile::Whole(file)),
                (None, Some(PathMoment { sun, keys })) => {
                    Some(LightFile::Between { keys: keys.each_ref(), towards_sun: sun.towards() })
                }
                (None, None) => None,
            },
            other: self.more.as_ref().map(|more| more.files()),
        }
    }

    /// Returns the look-up of the file, for pictures on the CPU. `None` without a file.
    ///
    /// # Errors
    ///
    /// Returns an error for a look-up that does not exist.
    pub fn lookup(&self, args: &LookupArgs) -> Result<Option<Box<dyn PointVisibility + '_>>> {
        if let Some(PathMoment { sun, keys }) = &self.between {
            let sampler = PathSampler::new(keys.each_ref(), sun.towards(), Filter::try_from(args.filter)?);
            let too_far = || RenderError::SunTooFar { towards_sun: sun.towards() };
            let bias = args.bias.over(keys[0].settings.bias)?;
            return Ok(Some(Box::new(sampler.ok_or_else(too_far)?.with_bias(bias)?)));
        }
        match (&self.light, &self.more) {
            (Some(file), _) => Ok(Some(Box::new(args.sampler(file)?))),
            (None, Some(more)) => more.lookup(args),
            (None, None) => Ok(None),
        }
    }

    /// Returns the text of the technique that looks up the file.
    pub fn technique(&self, args: &LookupArgs) -> String {
        let of_more =
            || self.more.as_ref().filter(|_| self.light.is_none() && self.between.is_none())?.technique(args);
        of_more().unwrap_or_else(|| format!("voxel:filter={}{}", args.filter, args.bias.parameters()))
    }

    /// Returns the figures of the files for the report.
    pub fn figures(&self) -> Vec<BakedFigures> {
        let light = self.light.as_ref().map(|f| BakedFigures {
            frame: "light".to_owned(),
            resolution: f.settings.resolution.into(),
            voxel_size: f.grid.voxel_size,
            file_bytes: f.encoded_len(),
        });
        light.into_iter().chain(self.more.iter().flat_map(|more| more.figures())).collect()
    }
}
