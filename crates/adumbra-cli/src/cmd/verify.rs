//! `adumbra verify`: compares a file's answers with rays.

use adumbra_program::exit::{Code, Failure, Outcome};
use adumbra_program::output::print_json;
use adumbra_program::say;
use adumbra_program::scene::load_scene_within;
use adumbra_program::threads::with_threads;
use adumbra_tree::{AnyFile, TreeBody};
use adumbra_truth::trace::{TraceOptions, Tracer};
use adumbra_truth::verify::{
    Answers, Class, ClassResult, LightAnswers, MIN_CHECKED_POINTS, Sampler, Solids, SurfaceSampler,
    TreeAnswers, Verification, Verifier, VerifyOptions, VolumeSampler, building_bytes,
};

use super::lookup::LookupOptions;
use crate::args::Verify;

pub(crate) fn run(args: &Verify) -> Outcome {
    let bytes = std::fs::metadata(&args.file).map_or(0, |file| file.len());
    // The file's bytes, and the decoded file.
    args.run.check_memory("the shadow file", 0, 2 * bytes)?;
    let file = AnyFile::read(&args.file)?;
    let mut load = args.load.load_options()?;
    load.ignore_alpha |= file.ignores_alpha();
    if let AnyFile::Light(light) = &file
        && args.volume
        && light.settings.assume_ground
    {
        return Err(Failure::Usage(format!(
            "{} was baked with ground assumed, so it promises nothing about points in free space; bake with --no-assume-ground",
            args.file.display()
        )));
    }
    let result = with_threads(args.run.threads, || {
        let limit = args.run.memory_limit();
        let scene = load_scene_within(limit, &args.scene, &load)?;
        args.run.check_memory(
            "the scene and its acceleration structure",
            scene.memory_bytes(),
            scene.memory_bytes() + building_bytes(&scene),
        )?;
        let tracer = Tracer::build(&scene, TraceOptions { ignore_alpha: load.ignore_alpha });
        limit.check_peak("the scene and its acceleration structure")?;
        let solids = Solids::of(&scene);
        let sampler = match &file {
            AnyFile::Light(light) if args.volume => Sampler::Volume(VolumeSampler::new(&light.grid)),
            AnyFile::Tree(tree) if args.volume => Sampler::Volume(VolumeSampler::in_cube(&tree.space)),
            _ => {
                let towards = file.sun().towards();
                Sampler::Surface(SurfaceSampler::new(&scene, &solids, towards, load.ignore_alpha))
            }
        };
        let check = Check {
            tracer: &tracer,
            solids: &solids,
            sampler: &sampler,
            options: VerifyOptions { samples: args.samples, seed: args.seed },
            min_interior: args.min_interior,
        };
        let asking = LookupOptions::from(&args.lookup);
        let result = match &file {
            AnyFile::Light(f) => check.run(&LightAnswers::new(&f.grid, &f.settings, asking.light(f)?)),
            AnyFile::Tree(f) => match &f.body {
                TreeBody::Words(t) => check.run(&TreeAnswers::new(&f.settings, f.sun, asking.tree(f, t)?)),
                TreeBody::Symmetric(t) => {
                    check.run(&TreeAnswers::new(&f.settings, f.sun, asking.tree(f, t)?))
                }
            },
        };
        limit.check_peak("the comparison")?;
        Ok::<_, Failure>(result)
    })??;
    if args.run.json {
        print_json(&result)?;
    } else {
        say!("{} against {}", args.file.display(), args.scene.display());
        print_file(&file);
        print_result(&result, args.lookup.filter);
    }
    if !result.is_checked() {
        eprintln!(
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
        eprintln!(
            "check failed: {} points {}; is this the scene that the file was baked from, read with the same options?",
            class.class.name(),
            missed(class)
        );
    }
    Ok(Code::CheckFailed)
}

/// Says which promise a class misses.
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
            "are off by more than a texel in {:.4} %, more than the allowed {:.4} %",
            100.0 * class.misplaced_share(),
            100.0 * most.unwrap_or_default()
        ),
    }
}

/// Prints the properties of the file that affect the comparison. They show if the file is for another sun or too
/// coarse.
fn print_file(file: &AnyFile) {
    let voxel_size = match file {
        AnyFile::Light(light) => light.grid.voxel_size,
        AnyFile::Tree(tree) => tree.space.voxel_size,
    };
    let [x, y, z] = file.sun().towards();
    let elevation = y.asin().to_degrees();
    let masks = if file.ignores_alpha() { ", masks ignored" } else { "" };
    say!(
        "  file                sun ({x:.3}, {y:.3}, {z:.3}), {elevation:.1}° high; voxels of {voxel_size:.4}{masks}"
    );
}

fn print_result(result: &Verification, filter: u32) {
    say!(
        "  samples             {} (not compared: {} facing away, {} inside solids, {} outside the bounds)",
        result.samples,
        result.facing_away,
        result.inside_solids,
        result.outside_bounds
    );
    say!("  shadowed by rays    {:.2} %", 100.0 * result.shadowed_share);
    say!("  agreement           {:.4} %", 100.0 * result.agreement);
    say!("  interior agreement  {:.4} %", 100.0 * result.interior_agreement);
    say!();
    say!("  class       points   share  agreement       acne       leak  misplaced  promise");
    for class in &result.classes {
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

/// Says what a class promises and whether it holds.
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

/// The reference and the parameters of a comparison, for answers of any kind.
struct Check<'a> {
    tracer: &'a Tracer<'a>,
    solids: &'a Solids,
    sampler: &'a Sampler<'a>,
    options: VerifyOptions,
    min_interior: Option<f64>,
}

impl Check<'_> {
    fn run(&self, answers: &impl Answers) -> Verification {
        let verifier = Verifier::new(answers, self.tracer, self.solids);
        let verifier = match self.min_interior {
            Some(least) => verifier.with_interior_promise(least),
            None => verifier,
        };
        verifier.run(self.sampler, &self.options)
    }
}
