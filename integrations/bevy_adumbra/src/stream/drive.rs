//! Updates streams once per frame.

use std::time::{Duration, Instant};

use adumbra::stream::{PoolWrite, StreamCounts, View};
use bevy::asset::AssetServer;
use bevy::camera::primitives::Frustum;
use bevy::camera::{Camera, Camera3d};
use bevy::diagnostic::Diagnostics;
use bevy::ecs::prelude::*;
use bevy::transform::components::GlobalTransform;

use super::bytes::Bytes;
use super::counters::StreamDiagnostics;
use super::file::{Stream, bytes_of};
use super::streams::Slot;
use super::views::view;
use super::{ShadowStreams, StreamBudget};
use crate::components::{BakedShadow, FileRoot};
use crate::placing::{Rooted, Roots};
use crate::texels::PoolTexels;
use crate::{DeviceLimits, StreamSource};

/// How long a frame receives answers; later answers wait for the next frame.
const RECEIVING: Duration = Duration::from_micros(700);

/// Data that the render world takes from streams in every frame.
#[derive(Resource, Default)]
pub(crate) struct PoolUploads {
    /// All pools of open streams.
    pub(crate) pools: Vec<PoolTexels>,
    /// Writes to these pools in this frame.
    pub(crate) writes: Vec<(PoolTexels, Vec<PoolWrite>)>,
}

/// Opens the streams that lights name, closes others, passes on the views of cameras, and receives the data
/// that has been read.
pub(crate) fn drive_streams(
    lights: Query<&BakedShadow>,
    (roots, rooted): (Query<(Entity, &FileRoot, &GlobalTransform)>, Res<Rooted>),
    cameras: Query<(&Camera, &GlobalTransform, &Frustum), With<Camera3d>>,
    server: Res<AssetServer>,
    (budget, limits): (Res<StreamBudget>, Res<DeviceLimits>),
    (mut streams, mut uploads): (ResMut<ShadowStreams>, ResMut<PoolUploads>),
    mut diagnostics: Diagnostics,
) {
    let start = Instant::now();
    uploads.pools.clear();
    let sources = || lights.iter().flat_map(|shadow| &shadow.streams);
    if streams.slots.is_empty() && sources().next().is_none() {
        return;
    }
    let ShadowStreams { slots, begun } = &mut *streams;
    slots.retain(|slot| sources().any(|source| *source == slot.source));
    let options = budget.options();
    let new = |source: &StreamSource| Stream::new(Bytes::new(source, &server), options);
    for source in sources() {
        if slots.iter().all(|slot| slot.source != *source) {
            slots.push(Slot {
                source: source.clone(),
                options,
                stream: new(source),
                next: None,
                is_stale: false,
            });
        }
    }
    let views: Vec<View> =
        cameras.iter().filter_map(|(camera, at, frustum)| view(camera, at, frustum)).collect();
    let roots = Roots::new(&rooted, roots.iter().map(|(entity, root, at)| (entity, root, *at)));
    // Write nothing until earlier writes are taken: without a render world, nothing takes them.
    let mut left = if uploads.writes.is_empty() { budget.upload_bytes_per_frame } else { 0 };
    let mut uploaded = 0;
    let count = slots.len();
    for (i, slot) in slots.iter_mut().enumerate() {
        if slot.options != options || slot.is_stale {
            slot.next = Some(new(&slot.source));
            (slot.options, slot.is_stale) = (options, false);
        }
        let stream = slot.active();
        stream.receive(start + RECEIVING);
        stream.open(|words| PoolTexels::new(words, limits.max_texture_side));
        let places = roots.of_stream(&slot.source).into_iter().flatten();
        let views: Vec<View> =
            places.flat_map(|place| views.iter().map(move |view| view.of_placed(&place))).collect();
        let stream = slot.active();
        stream.ask(&views, start.duration_since(*begun));
        // Share the budget evenly. Bytes that a stream does not use go to the streams after it.
        let writes = stream.take_writes(left / (count - i));
        let bytes = bytes_of(&writes);
        left -= bytes as usize;
        uploaded += bytes;
        if let Some(pool) = stream.pool().filter(|_| bytes > 0) {
            uploads.writes.push((pool, writes));
        }
        let has_none = slot.stream.pool().is_none();
        if let Some(next) = slot.next.take_if(|next| has_none || next.is_ready()) {
            slot.stream = next;
        }
        uploads
            .pools
            .extend([Some(&slot.stream), slot.next.as_ref()].into_iter().flatten().filter_map(Stream::pool));
    }
    let counts: Vec<StreamCounts> = slots.iter().map(|slot| slot.stream.resident().counts()).collect();
    StreamDiagnostics::add(&mut diagnostics, &counts, uploaded, start);
}
