//! The sections of the benchmark, the most important first.

use adumbra::Sun;
use adumbra_bake::{BakeOptions, FrameChoice, Size};
use adumbra_papers::techniques::PaperFiles;
use adumbra_render::occlusion::{Estimator, Filter, OcclusionPasses, OcclusionSettings};
use adumbra_render::{Renderer, SceneOptions, TechniqueFiles, TechniqueSpec};

use crate::TECHNIQUES;
use crate::light_file::{Kind, LightFile};
use adumbra_scene::Scene;

use super::scenes::{NamedView, city, movers, tiled, triangles, views};
use super::{Bench, Row, Section};
use crate::bench::DEFAULT_SUN;
use adumbra_compare::Result;
use adumbra_compare::baked::{BakeOnDemand, BakedFiles};

/// Voxels per side of a world-aligned file.
const CUBES: u64 = 1024;
const FILTERS: [u32; 5] = [1, 3, 5, 9, 17];
/// Distance in metres beyond which nothing occludes.
const OCCLUSION_RADIUS: f64 = 2.0;

/// A scene on the device, with its views.
struct OnDevice<'s> {
    name: String,
    scene: &'s Scene,
    renderer: Renderer,
    views: &'s [NamedView],
    sun: Sun,
}

pub(super) fn measure(bench: &mut Bench<'_>) -> Result<()> {
    let sun = Sun::from_direction(DEFAULT_SUN)?;
    let city = city();
    let views = views(&city, sun, bench.args.size)?;
    let mut on_device = OnDevice {
        name: "a generated city of 400 m".to_owned(),
        scene: &city,
        renderer: Renderer::new(bench.gpu.clone(), &city, SceneOptions::default())?,
        views: &views,
        sun,
    };
    techniques(bench, &mut on_device)?;
    filters(bench, &mut on_device)?;
    large(bench, &on_device)?;
    resolutions(bench, &mut on_device)?;
    hybrid(bench, &mut on_device)?;
    ambient(bench, &mut on_device)
}

impl Bench<'_> {
    fn section(&mut self, title: &str, on: &OnDevice<'_>, rows: Vec<Option<Row>>) -> Result<()> {
        self.document.sections.push(Section {
            title: title.to_owned(),
            scene: on.name.clone(),
            triangles: triangles(on.scene),
            rows: rows.into_iter().flatten().collect(),
        });
        self.write()
    }
}

fn baked(on: &OnDevice<'_>, resolution: u64, frame: FrameChoice, kind: Kind) -> Result<LightFile> {
    let options = BakeOptions::new(on.sun, Size::Resolution(resolution)).with(|o| o.frame = frame);
    LightFile::bake(on.scene, &options, kind)
}

/// Every technique with its defaults.
fn techniques(bench: &mut Bench<'_>, on: &mut OnDevice<'_>) -> Result<()> {
    let names = TECHNIQUES.iter().filter(|entry| !entry.is_reference()).map(|entry| entry.name);
    let specs: Vec<TechniqueSpec> =
        names.map(|name| TECHNIQUES.parse(name)).collect::<std::result::Result<_, _>>()?;
    let cube_resolution = CUBES.min(bench.args.resolution);
    let mut files = BakedFiles::with(Some(Box::new(PaperFiles { cube_resolution, ..PaperFiles::default() })));
    files.complete(
        &specs,
        &BakeOnDemand {
            scene: on.scene,
            sun: on.sun,
            ignore_alpha: false,
            resolution: bench.args.resolution,
            max_memory_bytes: None,
        },
    )?;
    let given = files.baked();
    let mut rows = Vec::new();
    for spec in &specs {
        rows.push(bench.technique(&mut on.renderer, on.views, [&spec.to_string(), ""], given, None)?);
    }
    bench.section("Every technique", on, rows)
}

/// Filters by frame and layout.
fn filters(bench: &mut Bench<'_>, on: &mut OnDevice<'_>) -> Result<()> {
    let mut rows = Vec::new();
    for frame in [FrameChoice::Light, FrameChoice::Oblique] {
        for kind in Kind::ALL {
            let file = baked(on, bench.args.resolution, frame, kind)?;
            let named = format!("{} {}", file.grid().frame.name(), kind.name());
            let given = file.baked();
            for filter in FILTERS {
                let technique = file.technique(filter);
                rows.push(bench.technique(&mut on.renderer, on.views, [&technique, &named], given, None)?);
            }
        }
    }
    bench.section("Filters of a file, by frame and layout", on, rows)
}

/// A city of many triangles, with movers.
fn large(bench: &mut Bench<'_>, on: &OnDevice<'_>) -> Result<()> {
    if bench.is_over("the large city") {
        return Ok(());
    }
    let side = bench.args.tiles;
    let scene = tiled(on.scene, side);
    let moving = movers(&on.views[1].shot.camera);
    let mut renderer = Renderer::new(bench.gpu.clone(), &scene, SceneOptions::default())?;
    renderer.set_movers(&moving, SceneOptions::default())?;
    let name = format!("{side} × {side} copies of the city, and 25 spheres that move");
    let mut large = OnDevice { name, scene: &scene, renderer, views: on.views, sun: on.sun };
    let file = baked(&large, bench.args.resolution, FrameChoice::Auto, Kind::Quadtree)?;
    let given = file.baked();
    let mut rows = Vec::new();
    for technique in ["csm:filter=5", "csm:filter=5:static=cached", "voxel+csm:filter=5", "voxel:filter=5"] {
        let spec = [technique, ""];
        rows.push(bench.technique(&mut large.renderer, large.views, spec, given, Some(&moving))?);
    }
    bench.section("A large city with movers: a file against cascades", &large, rows)
}

/// Resolutions of the file.
fn resolutions(bench: &mut Bench<'_>, on: &mut OnDevice<'_>) -> Result<()> {
    let mut rows = Vec::new();
    for &resolution in &bench.args.resolutions {
        let named = format!("{resolution} texels");
        if bench.is_over(&named) {
            continue;
        }
        let file = baked(on, resolution, FrameChoice::Auto, Kind::Quadtree)?;
        for filter in [1, 5, 9] {
            let technique = [&format!("voxel:filter={filter}"), named.as_str()];
            let given = file.baked();
            rows.push(bench.technique(&mut on.renderer, on.views, technique, given, None)?);
        }
    }
    bench.section("Resolutions of a file", on, rows)
}

/// Hybrid-resolution maps against plain ones: tables 1 and 2 of their paper.
fn hybrid(bench: &mut Bench<'_>, on: &mut OnDevice<'_>) -> Result<()> {
    let mut rows = Vec::new();
    for start in [1024_u32, 2048, 4096] {
        let plain = [format!("sm:size={start}"), format!("pcf:filter=5:size={start}")];
        let hybrid = [1, 5].map(|filter| format!("hrsm:{start}-{}:filter={filter}", start / 4));
        for technique in plain.iter().chain(&hybrid) {
            let spec = [technique.as_str(), ""];
            rows.push(bench.technique(&mut on.renderer, on.views, spec, TechniqueFiles::default(), None)?);
        }
    }
    bench.section("Hybrid-resolution maps against plain ones", on, rows)
}

/// Estimators of ambient occlusion, with and without their filters.
fn ambient(bench: &mut Bench<'_>, on: &mut OnDevice<'_>) -> Result<()> {
    let mut rows = Vec::new();
    for estimator in Estimator::ALL {
        let settings = OcclusionSettings::new(estimator, OCCLUSION_RADIUS);
        let bare = OcclusionSettings { filter: Filter::None, ..settings };
        for (name, settings) in
            [(estimator.to_string(), settings), (format!("{estimator}:filter=none"), bare)]
        {
            let passes = OcclusionPasses::new(&bench.gpu, settings);
            rows.push(bench.occlusion(&mut on.renderer, on.views, &name, passes)?);
        }
    }
    bench.section("Estimators of ambient occlusion", on, rows)
}
