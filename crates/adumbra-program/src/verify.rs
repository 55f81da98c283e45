//! The verb `verify`: compares a file's answers with rays.

use std::path::PathBuf;

use adumbra::Sun;
use adumbra_bake::Ground;
use adumbra_scene::{Casters, LoadOptions, LoadedAs, Scene, UpAxis};
use adumbra_truth::trace::{TraceOptions, Tracer};
use adumbra_truth::verify::{
    Answers, Class, ClassResult, MIN_CHECKED_POINTS, Sampler, Solids, SurfaceSampler, Verification, Verifier,
    VerifyOptions, VolumeSampler, building_bytes,
};
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::{RunArgs, SceneArgs};
use crate::exit::{Code, Failure, Outcome};
use crate::glance::{AtAGlance, look, warn_of_large_voxels};
use crate::lookup::LookupArgs;
use crate::output::print_json;
use crate::say;
use crate::scene::load_scene_within;
use crate::threads::with_threads;

/// The arguments of `verify`.
#[derive(clap::Args)]
#[command(mut_arg("filter", |filter| filter.help("Filter width, as for query")))]
pub struct Verify {
    /// Shadow file
    pub file: PathBuf,
    /// The scene that the file was baked from, loaded with the same filters
    #[arg(long)]
    pub scene: PathBuf,
    /// Number of points to compare
    #[arg(long, default_value_t = 1_000_000, value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    pub samples: u64,
    /// Seed of the points
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Sample points in free space instead of points on surfaces; for files baked with --assume-ground no
    #[arg(long)]
    pub volume: bool,
    /// Look-up.
    #[command(flatten)]
    pub lookup: LookupArgs,
    /// Interior agreement below which the check fails, from 0 to 1 [default: 0.999, or 0.995 with a filter]
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, value_parser = parse_share)]
    pub min_interior: Option<f64>,
    /// Loading of the scene.
    #[command(flatten)]
    pub load: SceneArgs,
    /// Run.
    #[command(flatten)]
    pub run: RunArgs,
}

/// The properties of a file that the comparison needs, in addition to its answers.
pub struct Verified {
    /// The sun that it was baked for.
    pub sun: Sun,
    /// Edge of a voxel, world units.
    pub voxel_size: f64,
    /// Whether the voxels are those of the file's finest level.
    pub is_finest: bool,
    /// How the bake's scene was loaded.
    pub scene: LoadedAs,
    /// Whether shadows below the last surface of a column were left out.
    pub assumes_ground: bool,
    /// The casters of the bake, if the file names them.
    pub casters: Option<Casters>,
    /// Its volume, for points in free space.
    pub volume: VolumeSampler,
}

/// What `verify` prints as JSON.
#[derive(Serialize, JsonSchema)]
pub struct VerifiedScene {
    /// The comparison.
    #[serde(flatten)]
    result: Verification,
    /// What a person would see of the scene.
    glance: AtAGlance,
    /// Number of triangles that cast shadows in the scene that the file was baked from, every instance
    /// counted. Null for a manifest of regions.
    baked_triangles: Option<u64>,
    /// Number of triangles that cast shadows in the scene that it was compared with.
    scene_triangles: u64,
}

impl Verify {
    /// Compares `answers`, which are those of `file`, with rays, and reports the result.
    ///
    /// # Errors
    ///
    /// Returns [`Failure`] if the scene cannot be loaded or memory is not enough.
    pub fn compare(&self, file: Verified, answers: &impl Answers) -> Outcome {
        let mut load = self.load.load_options()?;
        load.follow(file.scene, &self.scene);
        let (sun, voxel_size) = (file.sun, file.voxel_size);
        let volume = self.volume.then_some(file.volume);
        let (result, glance, [baked, casters]) = with_threads(
            self.run.threads,
            || -> Result<_, Failure> {
                let scene = self.load_scene(&load)?;
                let casters = [file.casters.unwrap_or(scene.casters()), scene.casters()];
                warn_of_other_casters(casters[0], casters[1]);
                let glance = look(&scene, &self.scene, sun, load.ignore_alpha);
                if file.is_finest {
                    warn_of_large_voxels(&self.scene, &glance, voxel_size);
                }
                if file.assumes_ground && !Ground::of(&scene).is_there() {
                    crate::note!(
                        "warning: {}: the file has no shadows below the last surface, and the scene has no ground of its own; bake with --assume-ground no if the app draws one",
                        self.file.display()
                    );
                }
                let result = self.trace(&scene, load.ignore_alpha, sun, volume, answers)?;
                Ok((result, AtAGlance::of(&glance), casters))
            },
        )??;
        if self.run.json {
            print_json(&VerifiedScene {
                result: result.clone(),
                glance,
                baked_triangles: file.casters.map(|casters| casters.triangles),
                scene_triangles: casters.triangles,
            })?;
        } else {
            say!("{} against {}", self.file.display(), self.scene.display());
            print_file(sun, voxel_size, file.scene);
            print_result(&result, &glance, self.lookup.filter);
        }
        if !result.is_checked() {
            crate::note!(
                "check failed: {} interior points were compared, but the check needs at least {MIN_CHECKED_POINTS}; give more --samples, \
                 and make sure that file and scene overlap",
                result.class(Class::Interior).points
            );
            return Ok(Code::CheckFailed);
        }
        if result.holds() {
            return Ok(Code::Fine);
        }
        for class in result.classes.iter().filter(|c| !c.holds) {
            crate::note!(
                "check failed: {} points {}; {}",
                class.class.name(),
                missed(class),
                remedy(&result, casters == baked)
            );
        }
        Ok(Code::CheckFailed)
    }

    /// Loads the scene.
    ///
    /// # Errors
    ///
    /// Returns [`Failure`] if it cannot be loaded.
    pub fn load_scene(&self, load: &LoadOptions) -> Result<Scene, Failure> {
        load_scene_within(self.run.memory_limit(), &self.scene, load)
    }

    /// Compares `answers` for a sun with rays, and reports nothing.
    ///
    /// # Errors
    ///
    /// Returns [`Failure`] if memory is not enough.
    pub fn trace(
        &self,
        scene: &Scene,
        ignore_alpha: bool,
        sun: Sun,
        volume: Option<VolumeSampler>,
        answers: &impl Answers,
    ) -> Result<Verification, Failure> {
        let limit = self.run.memory_limit();
        self.run.check_memory(
            "the scene and its acceleration structure",
            scene.memory_bytes(),
            scene.memory_bytes() + building_bytes(scene),
        )?;
        let tracer = Tracer::build(scene, TraceOptions { ignore_alpha });
        limit.check_peak("the scene and its acceleration structure")?;
        let solids = Solids::of(scene);
        let sampler = match volume {
            Some(volume) => Sampler::Volume(volume),
            None => Sampler::Surface(SurfaceSampler::new(scene, &solids, sun.towards(), ignore_alpha)),
        };
        let verifier = Verifier::new(answers, &tracer, &solids).with_ground();
        let verifier = match self.min_interior {
            Some(least) => verifier.with_interior_promise(least),
            None => verifier,
        };
        let result = verifier.run(&sampler, &VerifyOptions { samples: self.samples, seed: self.seed });
        limit.check_peak("the comparison")?;
        Ok(result)
    }
}

/// Warns on stderr of a scene with other casters than that of the bake.
pub fn warn_of_other_casters(baked: Casters, scene: Casters) {
    if scene != baked {
        crate::note!(
            "warning: the file was baked from {} triangles in {} instances that cast shadows, and the scene has {} in {}",
            baked.triangles,
            baked.instances,
            scene.triangles,
            scene.instances
        );
    }
}

/// Below this interior agreement, a too coarse grid is not the main cause of errors.
const LEAST_OF_ANY_GRID: f64 = 0.98;

/// Returns advice on missed promises. With a grid that is too coarse, few points are wrong. With another
/// scene, the casters differ, or many points far from all edges are wrong.
pub fn remedy(result: &Verification, is_of_same_casters: bool) -> &'static str {
    if is_of_same_casters && result.interior_agreement >= LEAST_OF_ANY_GRID {
        "a bake with a finer --resolution has fewer such points"
    } else {
        "is this the scene that the file was baked from, read with the same options?"
    }
}

/// Describes the promise that a class misses.
fn missed(class: &ClassResult) -> String {
    match (class.promised_agreement, class.promised_misplaced) {
        (Some(least), _) if !(class.agreement >= least) => {
            format!(
                "agree with rays in {:.4} %, less than the required {:.4} %",
                100.0 * class.agreement,
                100.0 * least
            )
        }
        (_, most) => format!(
            "are wrong where rays at their texel's centre are not in {:.4} %, more than the allowed {:.4} %",
            100.0 * class.misplaced_share(),
            100.0 * most.unwrap_or_default()
        ),
    }
}

/// Prints the properties of the file that affect the comparison. They show whether the file is for another
/// sun or too coarse.
fn print_file(sun: Sun, voxel_size: f64, scene: LoadedAs) {
    let [x, y, z] = sun.towards();
    let elevation = y.asin().to_degrees();
    let masks = if scene.ignore_alpha { ", masks ignored" } else { "" };
    let turned = if scene.up == Some(UpAxis::Z) { ", of a scene with Z up" } else { "" };
    say!(
        "  file                sun ({x:.3}, {y:.3}, {z:.3}), {elevation:.1}° high; voxels of {voxel_size:.4}{masks}{turned}"
    );
}

fn print_result(result: &Verification, glance: &AtAGlance, filter: u32) {
    say!(
        "  samples             {} (not compared: {} facing away, {} inside solids, {} outside the bounds)",
        result.samples,
        result.facing_away,
        result.inside_solids,
        result.outside_bounds
    );
    say!("  shadowed by rays    {:.2} %", 100.0 * result.shadowed_share);
    say!("  {glance}");
    say!("  agreement           {:.4} %", 100.0 * result.agreement);
    say!("  interior agreement  {:.4} %", 100.0 * result.interior_agreement);
    say!();
    say!("  class       points   share  agreement       acne       leak  misplaced  promise");
    // Most files make no promise about ground that the scene does not have.
    let is_shown = |class: &&ClassResult| class.class != Class::Ground || class.promised_agreement.is_some();
    for class in result.classes.iter().filter(is_shown) {
        let share = 100.0 * class.points as f64 / result.samples.max(1) as f64;
        let misplaced = if filter == 1 { class.misplaced.to_string() } else { "–".to_owned() };
        let agreement =
            if class.points == 0 { "–".to_owned() } else { format!("{:.4} %", 100.0 * class.agreement) };
        say!(
            "  {:<9}{:>9}{share:>6.1} %{agreement:>11}{:>11}{:>11}{misplaced:>11}  {}",
            class.class.name(),
            class.points,
            class.acne,
            class.leak,
            promise(class)
        );
    }
}

/// Describes a class's promise and whether it holds.
fn promise(class: &ClassResult) -> String {
    let promised = match (class.promised_agreement, class.promised_misplaced) {
        (Some(least), _) => format!("agreement >= {} %", 100.0 * least),
        (None, Some(most)) => format!("misplaced <= {} %", 100.0 * most),
        (None, None) => return "none".to_owned(),
    };
    match (class.checked, class.holds) {
        (false, _) => format!("{promised}: not checked, fewer than {MIN_CHECKED_POINTS} points"),
        (true, true) => promised,
        (true, false) => format!("{promised}: MISSED"),
    }
}

fn parse_share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(share) if (0.0..=1.0).contains(&share) => Ok(share),
        _ => Err("give a number from 0 to 1, such as 0.999".to_owned()),
    }
}
