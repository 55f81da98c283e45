//! A bake that is kept while its scene is edited.

use std::collections::HashMap;
use std::io::Cursor;
use std::sync::{Arc, Mutex};

use adumbra::{Bounds, Encoding, IoError, Sun};
use adumbra_bake::{
    Bake, BakeCache, BakeOptions, BakePlan, Baker, CacheKey, Error, Fetched, MemoryCache, Size, Watch,
};
use adumbra_scene::random::Random;
use adumbra_scene::{Added, Edits, GeneratedKind, Moved, Which, generate};

fn options(resolution: u64) -> BakeOptions {
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    let bounds = Some(Bounds { min: [-150.0, -1.0, -150.0], max: [150.0, 60.0, 150.0] });
    BakeOptions::new(sun, Size::Resolution(resolution)).with(|o| o.bounds = bounds)
}

fn fresh(baker: &Baker) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    Bake::with_options(baker.scene(), baker.options()).write_to(&mut out).unwrap();
    out.into_inner()
}

fn written(baker: &Baker) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    baker.write_to(&mut out, Watch::none()).unwrap();
    out.into_inner()
}

fn edits(baker: &Baker, random: &mut Random) -> Edits {
    let instances = &baker.scene().instances;
    let mut below = |count: usize| (random.unit() * count as f64) as usize;
    let [first, second, third] = [0, 1, 2].map(|part| 3 * below(instances.len() / 3) + part);
    let mut place = instances[first].world_from_mesh;
    place[0][3] += 0.01 * below(1000) as f64;
    place[1][1] *= 0.8;
    Edits {
        moved: vec![Moved { instance: Which::Number(first), world_from_mesh: place }],
        added: vec![Added { like: Which::Number(second), name: "new".to_owned(), world_from_mesh: place }],
        removed: vec![Which::Number(third)],
    }
}

/// Edits a city and bakes it again this many times. Returns the numbers of texels that each bake drew.
fn edited_files(resolution: u64, bakes: usize) -> Vec<u64> {
    let mut baker = Baker::new(generate(GeneratedKind::City, 3), &options(resolution)).unwrap();
    let error = baker.in_memory().map(|_| ()).unwrap_err();
    assert!(matches!(error, Error::MissingParts { .. }), "{error}");
    let mut random = Random::for_batch(3, 3);
    let all = baker.plan().parts().len();
    let mut drawn_texels = Vec::new();
    for number in 0..bakes {
        let due = baker.plan().parts().iter().filter(|part| !baker.is_baked(part)).count();
        assert!(if number == 0 { due == all } else { due > 0 && due < all }, "{number}: {due} of {all}");
        let done = baker.bake(None, Watch::none()).unwrap();
        // Entries of an earlier scene may be reused for due pages.
        assert!(
            done.baked + done.reused == due && baker.plan().parts().iter().all(|part| baker.is_baked(part))
        );
        drawn_texels.push(done.drawn_texels);
        let bytes = written(&baker);
        assert!(bytes == fresh(&baker), "{number}");
        assert!(baker.in_memory().unwrap().to_bytes(Encoding::Coded).unwrap() == bytes, "{number}");
        let edits = edits(&baker, &mut random);
        baker.edit(&edits).unwrap();
    }
    let before = baker.scene().instances.len();
    let wrong = Edits { removed: vec![Which::Named("nobody".to_owned())], ..Edits::default() };
    assert!(matches!(baker.edit(&wrong).unwrap_err(), Error::Scene(_)));
    assert_eq!(baker.scene().instances.len(), before);
    drawn_texels
}

#[test]
fn edited_small_files_equal_fresh_bakes() {
    edited_files(1024, 2);
}

#[test]
#[ignore = "slow: takes over eight seconds"]
fn edited_files_equal_fresh_bakes() {
    let drawn_texels = edited_files(1024, 12);
    // In pages with many root blocks, only the blocks that an edit touches are built.
    let edited = drawn_texels[1..].iter().sum::<u64>() / 11;
    assert!(12 * edited < drawn_texels[0], "{drawn_texels:?}");
}

#[test]
fn parts_cover_each_level_once() {
    for resolution in [256, 4096, 32_768] {
        let baker = Baker::new(generate(GeneratedKind::City, 3), &options(resolution)).unwrap();
        for (level, grid) in (0..).zip(baker.grids()) {
            let parts = baker.plan().parts().iter().filter(|part| part.level() == level);
            let places: Vec<_> = parts.map(|part| baker.plan().texels_of(part)).collect();
            let texels = |[_, size]: &[[u32; 2]; 2]| u64::from(size[0]) * u64::from(size[1]);
            let inside = |[corner, size]: &[[u32; 2]; 2]| (0..2).all(|a| corner[a] + size[a] <= grid.size[a]);
            assert!(places.iter().all(inside));
            let all = u64::from(grid.size[0]) * u64::from(grid.size[1]);
            assert_eq!(places.iter().map(texels).sum::<u64>(), all, "{resolution} {level}");
        }
    }
}

/// A cache that remembers the order of its entries.
#[derive(Debug, Default)]
struct InOrder(MemoryCache, Mutex<Vec<CacheKey>>);

impl BakeCache for InOrder {
    fn get(&self, key: &CacheKey, most_bytes: u64) -> Result<Fetched, IoError> {
        self.0.get(key, most_bytes)
    }

    fn put(&self, key: &CacheKey, bytes: &[u8]) -> Result<(), IoError> {
        self.1.lock().unwrap().push(*key);
        self.0.put(key, bytes)
    }
}

#[test]
fn coarse_levels_and_pages_near_the_focus_come_first() {
    let scene = generate(GeneratedKind::City, 3);
    let cache = Arc::new(InOrder::default());
    let mut baker = Baker::with_cache(scene.clone(), &options(4096), cache.clone()).unwrap();
    let focus = [60.0, 0.0, -40.0];
    // One root block at a time, so that there is an order.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| baker.bake_coarser(Some(focus), Watch::none())).unwrap();
    let mut out = Cursor::new(Vec::new());
    let written = baker.write_coarser_to(&mut out, Watch::none()).unwrap();
    assert_eq!((written.levels, written.settings.resolution), (2, 1024));
    let plan = BakePlan::new(&scene, baker.options()).unwrap();
    let level_of = |key: &CacheKey| plan.parts().iter().find(|part| part.key() == key).unwrap().level();
    let came = std::mem::take(&mut *cache.1.lock().unwrap());
    let levels: Vec<u32> = came.iter().map(level_of).collect();
    assert!(levels.contains(&1) && levels.contains(&2) && levels.is_sorted_by(|a, b| a >= b), "{levels:?}");
    pool.install(|| baker.bake(Some(focus), Watch::none())).unwrap();
    let finest = plan.parts().iter().filter(|part| part.level() == 0);
    let places: HashMap<CacheKey, _> = finest.map(|part| (*part.key(), plan.texels_of(part))).collect();
    let p_grid = baker.grids()[0].to_grid(focus);
    let distance = |key: &CacheKey| {
        let [corner, size] = places[key];
        let beside = |a: usize| {
            let first = f64::from(corner[a]);
            (first - p_grid[a]).max(p_grid[a] - first - f64::from(size[a])).max(0.0)
        };
        beside(0).hypot(beside(1)).floor()
    };
    let distances: Vec<f64> = cache.1.lock().unwrap().iter().map(distance).collect();
    assert!(
        distances.len() > 20 && distances.is_sorted() && distances.last() > distances.first(),
        "{distances:?}"
    );
}
