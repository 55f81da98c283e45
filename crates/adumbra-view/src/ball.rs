//! Searches for the ball's path on another thread, with a hundred thousand rays.

use std::sync::Arc;

use adumbra_truth::movers::MoveSpec;
use adumbra_truth::trace::{TraceOptions, Tracer};

use crate::background::{background_pool, in_background};
use crate::event::{Event, EventSender};
use crate::loaded_scene::LoadedScene;

/// Searches for a path through the static part of the scene.
pub(crate) fn find(scene: Arc<LoadedScene>, spec: MoveSpec, sun: [f64; 3], sender: EventSender) {
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
    in_background(work, move |found| sender.send(Event::Ball { scene: number, found }));
}
