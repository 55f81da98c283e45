//! The ball's way, looked for on another thread: a hundred thousand rays.

use std::sync::Arc;

use adumbra::trace::{TraceOptions, Tracer};
use adumbra_render::movers::MoveSpec;

use crate::background::{background_pool, in_background};
use crate::loading::LoadedScene;
use crate::news::{News, Teller};

/// Looks for a way among what stands still.
pub(crate) fn find(scene: Arc<LoadedScene>, spec: MoveSpec, sun: [f64; 3], teller: Teller) {
    let number = scene.number;
    let work = move || {
        let find = || {
            let options = TraceOptions { ignore_alpha: scene.ignore_alpha };
            let tracer = Tracer::build(&scene.still, options);
            let path = spec.path(&tracer, sun).map_err(|e| e.to_string())?;
            let viewpoint = path.viewpoint(&tracer, sun);
            Ok((path, viewpoint))
        };
        background_pool().and_then(|pool| pool.install(find))
    };
    in_background(teller, work, move |found| News::Ball { scene: number, found });
}
