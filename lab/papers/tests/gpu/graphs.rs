//! Graphs in both layouts, under a grid along the light and an oblique one: counts, answers, levels and
//! names.

use adumbra::query::{FixedReceiver, receiver};
use adumbra::{Filter, LightGrid, Sun};
use adumbra_bake::{BakeOptions, FrameChoice, Size, Watch};
use adumbra_papers::dag::build::{DagOptions, bake};
use adumbra_papers::dag::{DagFile, DagLayout, DagQuery};
use adumbra_papers::techniques::{Graph, GraphSettings, PaperFiles, TECHNIQUES, words};
use adumbra_render::technique::Technique as _;
use adumbra_render::voxel::MAX_WORD_BINDINGS;
use adumbra_render::{Gpu, RenderError, Renderer, SceneOptions, Techniques, build};
use adumbra_scene::{GeneratedKind, Scene, generate};
use adumbra_shaders::source;

use crate::kit::{self, gpu, limited};
use crate::levels::{hold, levels};
use crate::points::{float_points, hold_floats, points};

const COUNT: usize = 100_000;
const LAYOUTS: [DagLayout; 2] = [DagLayout::Plain, DagLayout::Packed];

/// A scene with its graph.
struct BakedGraph {
    scene: Scene,
    file: DagFile,
}

impl BakedGraph {
    fn new(scene: Scene, resolution: u64, frame: FrameChoice, layout: DagLayout) -> Self {
        let sun = Sun::from_direction(kit::SUN).unwrap();
        let options = BakeOptions::new(sun, Size::Resolution(resolution)).with(|o| o.frame = frame);
        let file = bake(&scene, &DagOptions { bake: options, layout }, Watch::none()).unwrap().file;
        Self { scene, file }
    }

    /// Bakes generated scenes in both layouts.
    fn generated() -> impl Iterator<Item = Self> {
        let scenes = [
            (GeneratedKind::Primitives, FrameChoice::Light),
            (GeneratedKind::City, FrameChoice::ObliqueAt(0.4)),
            (GeneratedKind::Landscape, FrameChoice::Light),
        ];
        let all = scenes.into_iter().flat_map(|scene| LAYOUTS.map(|layout| (scene, layout)));
        all.map(|((kind, frame), layout)| Self::new(generate(kind, 3), 1024, frame, layout))
    }

    fn query(&self, filter: Filter) -> DagQuery<'_> {
        DagQuery::new(&self.file.grid, self.file.body.leaf_masks(), self.file.settings.bias, filter)
    }

    fn graph(&self, gpu: &Gpu, filter: Filter) -> adumbra_render::Result<Graph> {
        let settings = GraphSettings { filter, bias: self.file.settings.bias };
        Graph::new(gpu, format!("voxel-dag:filter={}", filter.width()), &self.file, settings)
    }

    fn receiver(&self, grid: &LightGrid, p: [f64; 3], n: Option<[f64; 3]>) -> FixedReceiver {
        FixedReceiver::new(&receiver(grid, &self.file.settings.bias, p, n), grid.size)
    }

    fn word_count(&self) -> u64 {
        words(&self.file.body).iter().map(|part| part.len() as u64).sum()
    }
}

fn exact(gpu: &Gpu, baked: &BakedGraph, filter: Filter, count: usize) {
    let (graph, query) = (baked.graph(gpu, filter).unwrap(), baked.query(filter));
    let asked = points(&baked.scene, count).into_iter();
    let receivers: Vec<_> = asked.map(|(p, n)| baked.receiver(&baked.file.grid, p, n)).collect();
    let counts = graph.lit_taps(gpu, &receivers).unwrap();
    let mut partly = 0;
    for (r, found) in receivers.iter().zip(&counts) {
        let expected = query.lit_taps(r);
        assert_eq!(*found, expected, "{filter:?}: {r:?}");
        partly += usize::from(expected > 0 && expected < filter.width().pow(2));
    }
    assert!(
        counts.len() == count && (filter == Filter::Nearest || partly * 200 > count),
        "{partly} partly lit"
    );
}

#[test]
#[ignore = "slow: draws on the GPU and counts on the CPU"]
fn graphs_match_cpu_tap_counts() {
    let gpu = gpu();
    for baked in BakedGraph::generated() {
        for filter in Filter::ALL {
            exact(&gpu, &baked, filter, COUNT);
        }
    }
}

fn from_f32(gpu: &Gpu, baked: &BakedGraph, filter: Filter, count: usize) {
    let (anchor, asked) = float_points(&baked.scene, count);
    let mut graph = baked.graph(gpu, filter).unwrap();
    graph.set_anchor(gpu, anchor).unwrap();
    let (query, grid) = (baked.query(filter), &baked.file.grid);
    let twin = |p, n| query.receiver_visibility(&receiver(grid, &query.bias(), p, n));
    hold_floats(gpu, &graph, (anchor, &asked), twin, |_, _| grid.voxel_size);
}

#[test]
fn small_graph_answers_from_f32_positions_differ_only_on_faces() {
    let scene = generate(GeneratedKind::Primitives, 3);
    from_f32(&gpu(), &BakedGraph::new(scene, 256, FrameChoice::Light, LAYOUTS[1]), Filter::Box9, 10_000);
}

#[test]
#[ignore = "slow: many look-ups on the GPU"]
fn graph_answers_from_f32_positions_differ_only_on_faces() {
    let gpu = gpu();
    for baked in BakedGraph::generated() {
        for filter in [Filter::Nearest, Filter::Box9, Filter::Box17] {
            from_f32(&gpu, &baked, filter, COUNT);
        }
    }
}

#[test]
fn graphs_in_six_bindings_match_cpu() {
    for layout in LAYOUTS {
        let scene = generate(GeneratedKind::Primitives, 3);
        let baked = BakedGraph::new(scene, 256, FrameChoice::Light, layout);
        let words = baked.word_count();
        // The limit is a power of two at which the words need more than two bindings.
        let gpu = limited(4 * (words / 4).next_power_of_two());
        let graph = baked.graph(&gpu, Filter::Box9).unwrap();
        assert_eq!(graph.bytes(), 4 * words);
        assert_eq!(graph.look_up().last().unwrap().name, source::WORDS_6.name);
        exact(&gpu, &baked, Filter::Box9, 5000);
        let Err(error) = baked.graph(&limited(4 * words / 16), Filter::Box9) else { panic!("it fits") };
        assert!(matches!(error, RenderError::TooLarge { .. }) && MAX_WORD_BINDINGS == 6, "{error}");
    }
}

#[test]
fn graph_reads_stay_within_words_and_match_cpu() {
    let gpu = gpu();
    for layout in LAYOUTS {
        let scene = generate(GeneratedKind::City, 3);
        let baked = BakedGraph::new(scene, 512, FrameChoice::Light, layout);
        let (graph, query) = (baked.graph(&gpu, Filter::Box5).unwrap(), baked.query(Filter::Box5));
        let asked = points(&baked.scene, 500).into_iter();
        let receivers: Vec<_> = asked.map(|(p, n)| baked.receiver(&baked.file.grid, p, n)).collect();
        let reads = graph.reads(&gpu, &receivers).unwrap();
        for (r, reads) in receivers.iter().zip(&reads) {
            assert_eq!(reads.lit_taps, query.lit_taps(r), "{r:?}");
            assert!(reads.words.iter().all(|word| u64::from(*word) < baked.word_count()), "{reads:?}");
        }
        assert!(reads.iter().filter(|reads| reads.words.len() > 3).count() > 250, "{layout:?}");
    }
}

#[test]
fn graph_end_levels_match_cpu_in_both_layouts() {
    let mut frames = Vec::new();
    let mut bytes = Vec::new();
    for layout in LAYOUTS {
        let BakedGraph { scene, file } = BakedGraph::new(kit::city(), 1024, FrameChoice::Light, layout);
        let (grid, bias) = (file.grid, file.settings.bias);
        let files = PaperFiles { graph: Some(file), ..PaperFiles::default() };
        let mut renderer = Renderer::new(gpu(), &scene, SceneOptions::default()).unwrap();
        let (found, voxel_world) = levels(&mut renderer, &files, "voxel-dag:filter=9");
        assert_eq!(voxel_world, grid.voxel_size);
        let leaf_masks = files.graph.as_ref().unwrap().body.leaf_masks();
        let query = DagQuery::new(&grid, leaf_masks, bias, Filter::Box9);
        hold(&renderer, &found, |p, n| {
            let r = FixedReceiver::new(&receiver(&grid, &bias, p, Some(n)), grid.size);
            (query.end_level(&r).map_or(-1.0, |level| level as f32), voxel_world)
        });
        assert_eq!(levels(&mut renderer, &files, "voxel-dag:filter=1").0, found);
        frames.push(found);
        for name in ["voxel-dag", "voxel-dag:filter=17:slope=0.5"] {
            let spec = Techniques::product().with(TECHNIQUES).parse(name).unwrap();
            let technique = build(renderer.gpu(), &spec, files.baked()).unwrap();
            assert_eq!((technique.name().as_str(), technique.texel_world(10.0)), (name, Some(voxel_world)));
            bytes.push(technique.bytes());
        }
    }
    assert!(frames[0] == frames[1], "layouts end at different levels");
    assert!(bytes[0] == bytes[1] && bytes[2] < bytes[0], "{bytes:?}");
}

#[test]
fn shader_constants_match_graph_constants() {
    use adumbra_papers::dag::{packed, plain};
    let text = adumbra_papers::techniques::shaders::graph_declarations();
    for (name, value) in [
        ("PACKED_POOL_WORDS", packed::POOL_WORDS as u32),
        ("PACKED_NEAR_UNITS", packed::NEAR_UNITS),
        ("TOP_LIT", plain::LIT),
        ("TOP_SHADOWED", plain::SHADOWED),
    ] {
        let line = text.text.lines().find(|line| line.contains(name)).unwrap();
        let written = line.split('=').nth(1).unwrap().trim().trim_end_matches(';').trim_end_matches('u');
        let written = match written.strip_prefix("0x") {
            Some(hex) => u32::from_str_radix(hex, 16),
            None => written.parse(),
        };
        assert_eq!(written, Ok(value), "{line}");
    }
}
