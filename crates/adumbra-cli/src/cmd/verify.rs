//! `adumbra verify`: a file's answers against rays.

use adumbra::format::{AnyFile, TreeBody};
use adumbra::trace::{TraceOptions, Tracer};
use adumbra::verify::{
    Answers, LightAnswers, Sampler, Solids, SurfaceSampler, TreeAnswers, Verification, Verifier,
    VerifyOptions, VolumeSampler,
};

use super::lookup::{Asking, ignored_alpha, sun_of};
use super::{load_scene, print_json, with_threads};
use crate::args::Verify;
use crate::exit::{Code, Failure, Outcome};

pub(crate) fn run(args: &Verify) -> Outcome {
    let file = AnyFile::read(&args.file)?;
    let mut load = args.load.load_options(args.work.max_memory)?;
    load.ignore_alpha |= ignored_alpha(&file);
    if let AnyFile::Light(light) = &file
        && args.volume
        && light.settings.assume_ground
    {
        return Err(Failure::Usage(format!(
            "{} was baked with ground assumed: points in free space are not promised; bake with --no-assume-ground",
            args.file.display()
        )));
    }
    let result = with_threads(args.work.threads, || {
        let scene = load_scene(&args.scene, &load)?;
        let tracer = Tracer::build(&scene, TraceOptions { ignore_alpha: load.ignore_alpha });
        args.work
            .check_memory("the scene and its rays' trees", scene.memory_bytes() + tracer.memory_bytes())?;
        let solids = Solids::of(&scene);
        let sampler = match &file {
            AnyFile::Light(light) if args.volume => Sampler::Volume(VolumeSampler::new(&light.grid)),
            AnyFile::Tree(tree) if args.volume => Sampler::Volume(VolumeSampler::in_cube(&tree.space)),
            _ => {
                let towards = sun_of(&file).towards();
                Sampler::Surface(SurfaceSampler::new(&scene, &solids, towards, load.ignore_alpha))
            }
        };
        let check = Check {
            tracer: &tracer,
            solids: &solids,
            sampler: &sampler,
            options: VerifyOptions { samples: args.samples, seed: args.seed },
        };
        let asking = Asking { bias: &args.bias, filter: args.filter, weights: args.weights.into() };
        Ok(match &file {
            AnyFile::Light(f) => check.run(&LightAnswers::new(&f.grid, &f.settings, asking.light(f)?)),
            AnyFile::Tree(f) => match &f.body {
                TreeBody::Words(t) => check.run(&TreeAnswers::new(&f.settings, f.sun, asking.tree(f, t)?)),
                TreeBody::Symmetric(t) => {
                    check.run(&TreeAnswers::new(&f.settings, f.sun, asking.tree(f, t)?))
                }
            },
        })
    })?;
    if args.json {
        let value = serde_json::to_value(result).map_err(|e| Failure::BadInput(e.to_string()))?;
        print_json(&value);
    } else {
        say!("{} against {}", args.file.display(), args.scene.display());
        say!(
            "  samples             {} (left out: {} facing away, {} inside solids, {} outside the bounds)",
            result.samples,
            result.facing_away,
            result.inside_solids,
            result.outside_bounds
        );
        say!("  shadowed by rays    {:.2} %", 100.0 * result.shadowed_share);
        say!("  agreement           {:.4} %", 100.0 * result.agreement);
        say!(
            "  interior agreement  {:.4} % of {} ({:.1} % of the samples are interior)",
            100.0 * result.interior_agreement,
            result.interior,
            100.0 * result.interior_share
        );
        say!("  acne                {:.4} %, interior {}", 100.0 * result.acne, result.interior_acne);
        say!("  leak                {:.4} %, interior {}", 100.0 * result.leak, result.interior_leak);
        say!("  thin                {}, {} of them wrong", result.thin, result.thin_wrong);
    }
    if result.interior == 0 {
        eprintln!("check failed: no interior point was compared; do the file and the scene overlap?");
        return Ok(Code::CheckFailed);
    }
    // Written so that NaN fails.
    if !(result.interior_agreement >= args.min_interior) {
        eprintln!(
            "check failed: interior agreement {:.6} is below {}; is this the scene that the file was baked from?",
            result.interior_agreement, args.min_interior
        );
        return Ok(Code::CheckFailed);
    }
    Ok(Code::Fine)
}

/// What every kind of answer is compared with.
struct Check<'a> {
    tracer: &'a Tracer<'a>,
    solids: &'a Solids,
    sampler: &'a Sampler<'a>,
    options: VerifyOptions,
}

impl Check<'_> {
    fn run(&self, answers: &impl Answers) -> Verification {
        Verifier::new(answers, self.tracer, self.solids).run(self.sampler, &self.options)
    }
}
