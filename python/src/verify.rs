//! Comparison of a file with rays.

use adumbra_truth::trace::{TraceOptions, Tracer};
use adumbra_truth::verify::{
    LightAnswers, Sampler, Solids, SurfaceSampler, Verifier, VerifyOptions, VolumeSampler,
};
use pyo3::prelude::*;

use crate::errors::Failure;
use crate::file::{File, LookUp};
use crate::pool::pool;
use crate::scene::Scene;
use crate::watch::watched;

/// The options of a comparison, as Python gives them.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Options {
    samples: u64,
    seed: u64,
    volume: bool,
    min_interior: Option<f64>,
    threads: Option<usize>,
}

/// Compares a file with rays through a scene. Returns the result as JSON, as the program prints it, whether
/// there are enough points to check the file, and whether it keeps its promises.
#[pyfunction]
pub(crate) fn verify(
    py: Python<'_>,
    file: &File,
    scene: &Scene,
    look_up: LookUp,
    options: Options,
) -> PyResult<(String, bool, bool)> {
    let answers = LightAnswers::of(&file.file, file.sampler(look_up)?);
    let file = &file.file;
    let ignore_alpha = scene.ignore_alpha || file.ignores_alpha();
    watched(py, None, |watch| {
        let pool = pool(options.threads)?;
        let known = if ignore_alpha == scene.ignore_alpha { Some(scene.tracer(&pool)?) } else { None };
        let scene = &*scene.scene;
        let compare = || {
            let built;
            let tracer = match known {
                Some(tracer) => tracer,
                None => {
                    built = Tracer::build(scene, TraceOptions { ignore_alpha });
                    &built
                }
            };
            let solids = Solids::of(scene);
            let sampler = if options.volume {
                Sampler::Volume(VolumeSampler::new(&file.grid))
            } else {
                let towards = file.sun().towards();
                Sampler::Surface(SurfaceSampler::new(scene, &solids, towards, ignore_alpha))
            };
            let verifier = Verifier::new(&answers, tracer, &solids).with_ground().with_cancel(watch.cancel);
            let verifier = match options.min_interior {
                Some(least) => verifier.with_interior_promise(least),
                None => verifier,
            };
            verifier.run(&sampler, &VerifyOptions { samples: options.samples, seed: options.seed })
        };
        let result = pool.install(compare);
        let json = serde_json::to_string(&result).map_err(|error| Failure::Internal(error.to_string()))?;
        Ok((json, result.is_checked(), result.holds()))
    })
}
