//! The pools of streamed files in the render world: a copy of their texels, from which textures are
//! recreated.

use bevy::ecs::prelude::*;
use bevy::platform::collections::HashMap;
use bevy::render::MainWorld;

use adumbra::gpu::HEADER_WORDS;
use adumbra::stream::PoolWrite;

use crate::stream::PoolUploads;
use crate::texels::PoolTexels;

/// The pools of streamed files, and the writes to them in this frame.
#[derive(Resource, Default)]
pub(crate) struct Pools {
    pools: HashMap<u64, Pool>,
    fresh: Vec<(PoolTexels, Vec<PoolWrite>)>,
}

/// Texels of a pool.
struct Pool {
    bytes: Vec<u8>,
    /// Number of bytes up to the last one that has been written to.
    used: usize,
}

/// Takes the writes of streams in this frame.
pub(crate) fn extract_pools(mut main: ResMut<MainWorld>, mut pools: ResMut<Pools>) {
    let Some(mut uploads) = main.get_resource_mut::<PoolUploads>() else { return };
    let uploads = uploads.bypass_change_detection();
    let Pools { pools, fresh } = &mut *pools;
    pools.retain(|id, _| uploads.pools.iter().any(|pool| pool.id == *id));
    for pool in &uploads.pools {
        pools.entry(pool.id).or_insert_with(|| Pool {
            bytes: vec![0; 4 * pool.width as usize * pool.height as usize],
            used: 0,
        });
    }
    fresh.append(&mut uploads.writes);
}

impl Pools {
    /// Returns the bytes of a pool up to the last that has been written to.
    pub(crate) fn bytes(&self, pool: PoolTexels) -> &[u8] {
        self.pools.get(&pool.id).map_or(&[], |pool| &pool.bytes[..pool.used])
    }

    /// Applies the new writes to the pools. Calls `written` with the pool, first texel and bytes of each
    /// write.
    pub(crate) fn take_writes(&mut self, mut written: impl FnMut(PoolTexels, u32, &[u8])) {
        for (texels, writes) in self.fresh.drain(..) {
            let Some(pool) = self.pools.get_mut(&texels.id) else { continue };
            for PoolWrite { at, words } in writes {
                let first = HEADER_WORDS as u32 + at;
                let (start, end) = (4 * first as usize, 4 * (first as usize + words.len()));
                let bytes = &mut pool.bytes[start..end];
                for (word, bytes) in words.iter().zip(bytes.as_chunks_mut().0) {
                    *bytes = word.to_le_bytes();
                }
                written(texels, first, bytes);
                pool.used = pool.used.max(end);
            }
        }
    }
}
