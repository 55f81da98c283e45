//! Hybrid maps in the paper's layout on the GPU: texels and links against their CPU twin, answers against
//! those of the compact layout.

use adumbra_render::hybrid::HybridMap;
use adumbra_render::hybrid::twin::{DepthImage, HybridPaper};
use adumbra_render::{
    Answer, FrameTimes, Gpu, GpuOptions, Prepared, Renderer, SceneOptions, Shot, TechniqueFiles, build,
};
use adumbra_scene::{GeneratedKind, generate};

use crate::kit;
use crate::kit::hybrid::{SIZE, hybrid, prepare, renderer, shot};

fn draw(renderer: &mut Renderer, technique: &mut Prepared, number: u32, answer: Answer) -> FrameTimes {
    let shot = Shot { number, ..shot(kit::camera(SIZE[0], SIZE[1])) };
    renderer.draw(&shot, technique, answer).unwrap()
}

/// Builds the twin from the depth and normals that the GPU drew.
fn twin(gpu: &Gpu, map: &HybridMap) -> HybridPaper {
    let settings = map.settings();
    let depth = map.read_start(gpu).unwrap().unwrap();
    let normals = map.read_start_normals(gpu).unwrap().unwrap();
    let image = DepthImage::new(settings.start as usize, depth).unwrap();
    HybridPaper::build(&image, &normals, map.read(gpu).unwrap().settings).unwrap()
}

#[test]
fn paper_texels_and_links_match_twin() {
    for kind in [GeneratedKind::City, GeneratedKind::Landscape] {
        let mut renderer = renderer(&generate(kind, 7));
        for name in [
            "hrsm:1024-256",
            "hrsm:512-256:build=sweep",
            "hrsm:1024-128:test=paper",
            "hrsm:512-64:test=paper:depth=16:build=sweep",
            "hrsm:1024-256:depth=16",
        ] {
            let mut technique = prepare(&renderer, &format!("{name}:layout=paper"));
            draw(&mut renderer, &mut technique, 0, Answer::Visibility);
            let map = hybrid(&technique);
            let found = map.read_paper(renderer.gpu()).unwrap().unwrap();
            let expected = twin(renderer.gpu(), map);
            assert_eq!(found.split, expected.split, "{name}");
            assert_eq!(found.links, expected.links, "{name}");
            assert_eq!(found.texels.len(), expected.texels.len(), "{name}");
            for (at, (f, e)) in found.texels.iter().zip(&expected.texels).enumerate() {
                assert_eq!(f, e, "{kind:?} {name}: texel {at}");
            }
            let counts = map.counts(renderer.gpu()).unwrap();
            assert_eq!(counts.texels as usize, found.texels.len());
            assert_eq!(counts.words as usize, 4 * found.texels.len() + 2 * found.links.len());
            // Merged texels have normals too.
            let coarsest = (map.settings().target as usize).pow(2);
            let merged = found.texels[..coarsest].iter().filter(|t| t[2] == 0 && t[3] & 0xffff != 0).count();
            assert!(merged > 100 && found.split[0] > 100, "{kind:?} {name}: {merged} {:?}", found.split);
        }
    }
}

#[test]
fn paper_layout_matches_compact_in_a_small_map() {
    answers_are_the_compact_layouts(&["hrsm:512-256:depth=16:filter=7"]);
}

#[test]
#[ignore = "slow: large hybrid maps"]
fn paper_layout_matches_compact() {
    answers_are_the_compact_layouts(&["hrsm:1024-256", "hrsm:1024-128:test=paper:filter=1"]);
}

fn answers_are_the_compact_layouts(names: &[&str]) {
    let mut renderer = renderer(&kit::city());
    for name in names {
        for answer in [Answer::Visibility, Answer::Level] {
            let [compact, paper] = ["compact", "paper"].map(|layout| {
                let mut technique = prepare(&renderer, &format!("{name}:layout={layout}"));
                draw(&mut renderer, &mut technique, 0, answer);
                let tree = hybrid(&technique).read(renderer.gpu()).unwrap();
                (renderer.read_factor(&technique).unwrap(), tree)
            });
            assert_eq!(compact.1, paper.1, "{name}: the tree");
            let values = compact.0.iter().filter(|&&f| f > 0.0).count();
            assert!(values > 100 && values < compact.0.len(), "{name}: {values}");
            let apart = compact.0.iter().zip(&paper.0).position(|(c, p)| c.to_bits() != p.to_bits());
            assert_eq!(apart, None, "{name} {answer:?}");
        }
    }
}

#[test]
fn kept_map_is_unchanged_and_takes_only_the_bytes_in_use() {
    let mut renderer = renderer(&kit::city());
    let mut technique = prepare(&renderer, "hrsm:1024-256:layout=paper:static=cached");
    draw(&mut renderer, &mut technique, 0, Answer::Visibility);
    let first = renderer.read_factor(&technique).unwrap();
    let built = hybrid(&technique).read_paper(renderer.gpu()).unwrap();
    let bytes = technique.technique().bytes();
    draw(&mut renderer, &mut technique, 1, Answer::Visibility);
    assert_eq!(renderer.read_factor(&technique).unwrap(), first);
    assert_eq!(hybrid(&technique).read_paper(renderer.gpu()).unwrap(), built);
    assert!(hybrid(&technique).read_start_normals(renderer.gpu()).unwrap().is_none());
    let words = hybrid(&technique).counts(renderer.gpu()).unwrap().words;
    let kept = technique.technique().bytes();
    assert!(kept < bytes / 4 && kept >= 4 * u64::from(words), "{kept} of {bytes}, {words} words");
}

#[test]
fn rejects_only_maps_that_exceed_the_binding() {
    // Less than the largest possible map of either layout. For the city, the compact map fits.
    let options = GpuOptions { max_binding_bytes: Some(2 << 20), ..GpuOptions::default() };
    let draw = |options: &GpuOptions, name: &str| {
        let gpu = Gpu::request(options).unwrap();
        let mut renderer = Renderer::new(gpu, &kit::city(), SceneOptions::default()).unwrap();
        let technique = build(renderer.gpu(), &name.parse().unwrap(), TechniqueFiles::default())?;
        let mut prepared = renderer.prepare(technique)?;
        let shot = shot(kit::camera(SIZE[0], SIZE[1]));
        let drawn = renderer.draw(&shot, &mut prepared, Answer::Visibility);
        // A failed map is not kept.
        let again = renderer.draw(&shot, &mut prepared, Answer::Visibility);
        assert_eq!(drawn.is_err(), again.is_err(), "{name}");
        drawn?;
        renderer.read_factor(&prepared)
    };
    let compact = draw(&options, "hrsm:1024-256").unwrap();
    assert_eq!(compact, draw(&GpuOptions::default(), "hrsm:1024-256").unwrap());
    for kept in ["redrawn", "cached"] {
        let name = format!("hrsm:1024-256:layout=paper:static={kept}");
        let error = draw(&options, &name).unwrap_err().to_string();
        assert!(error.contains("1024 texels per side") && error.contains("layout=compact"), "{error}");
    }
    let small = GpuOptions { max_binding_bytes: Some(1 << 19), ..options };
    let error = draw(&small, "hrsm:1024-512").unwrap_err().to_string();
    assert!(error.contains("1048576 bytes") && error.contains("smaller START"), "{error}");
}
