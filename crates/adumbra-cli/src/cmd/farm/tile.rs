//! `adumbra tile`: bakes parts of a plan.

use adumbra_bake::{PartBaker, Watch};
use adumbra_program::exit::{Code, Outcome};
use adumbra_program::memory::Guard;
use adumbra_program::output::print_json;
use adumbra_program::progress::{Reporter, Units};
use adumbra_program::scene::load_scene_within;
use adumbra_program::threads::with_threads;
use adumbra_program::{memory, say};
use schemars::JsonSchema;
use serde::Serialize;

use super::plan_file::{PlanFile, cache_of};
use crate::args::{Shard, Tile};
use crate::cmd::store::{open_or_create, url_of};

/// What is printed with `--json`.
#[derive(Serialize, JsonSchema)]
pub(crate) struct Tiled {
    /// Where the entries are.
    cache: String,
    /// Number of parts that were baked.
    baked: usize,
    /// Number of parts that were there.
    reused: usize,
    /// Wall time of baking, without loading the scene.
    seconds: f64,
    /// The largest resident size of the process. If the system does not report it, the bytes that were
    /// counted.
    peak_bytes: u64,
}

pub(crate) fn run(args: &Tile) -> Outcome {
    let place = cache_of(args.cache.as_ref(), &args.plan);
    let PlanFile { scene: path, load, plan } = PlanFile::read(&args.plan)?;
    let path = args.scene.as_ref().unwrap_or(&path);
    let ids: Vec<usize> = match (args.shard, &args.ids) {
        (Some(Shard { index, count }), _) => plan.shard(index, count),
        (None, Some(ids)) => ids.within(plan.parts().len()).collect(),
        (None, None) => (0..plan.parts().len()).collect(),
    };
    with_threads(args.run.threads, || {
        let limit = args.run.memory_limit();
        let scene = load_scene_within(limit, path, &load.load_options()?)?;
        let share = limit.share(scene.memory_bytes());
        let cache = open_or_create(&place)?;
        let limits = plan.options().with(|o| {
            o.max_memory_bytes = share.bytes();
            o.spill_folder = url_of(&place).is_none().then(|| place.clone());
        });
        let guard = Guard::new(limit);
        let reporter = Reporter::new(args.progress, Units::TEXELS);
        let progress = |p| {
            guard.look();
            reporter.update(p);
        };
        let baker = PartBaker::new(&scene, &plan, &limits)?;
        let done = baker.bake(&ids, &cache, Watch::new(&progress, guard.cancel()));
        let done = guard.end("the bake of parts", &share, done)?;
        let peak_bytes = memory::peak_bytes().unwrap_or(done.accounted_bytes);
        if args.run.json {
            print_json(&Tiled {
                cache: place.display().to_string(),
                baked: done.baked,
                reused: done.reused,
                seconds: done.seconds,
                peak_bytes,
            })?;
        } else {
            let (plan, cache) = (args.plan.display(), place.display());
            say!(
                "{plan} -> {cache}: {} parts in {:.1} s, {} were there",
                done.baked,
                done.seconds,
                done.reused
            );
        }
        Ok(Code::Fine)
    })?
}
