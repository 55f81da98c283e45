//! Graphs and quadtrees of random scenes compared with the columns that both are made of.

use adumbra::layout::depths::DepthTree;
use adumbra::{Receivers, Sun};
use adumbra_bake::structure::{BlockColumns, BlockSink, BuiltStructure, Structure, build};
use adumbra_bake::{Bake, BakeOptions, ColumnBuilder, FrameChoice, Size, Watch};
use adumbra_papers::dag::build::convert::{body_in, graph_of, graph_of_depths};
use adumbra_papers::dag::build::{DagOptions, GraphSink, bake};
use adumbra_papers::dag::plain::Dag;
use adumbra_papers::dag::{DagBody, DagFile, DagLayout, LeafMasks};
use adumbra_scene::random::Random;
use adumbra_scene::{GeneratedKind, Mesh, Scene, generate};
use adumbra_testing::{add_box, add_quad, scene_of};

/// The `[e, x]` of every column.
struct Columns {
    size: [u32; 3],
    intervals: Vec<[u32; 2]>,
}

/// Records the columns of each block, row by row.
struct Recorder {
    size: [u32; 3],
    level: u32,
}

impl BlockSink for Recorder {
    type Block = Vec<[u32; 2]>;

    fn uniform(&self, level: u32, interval: [u32; 2]) -> Self::Block {
        vec![interval; 1 << (2 * level)]
    }

    fn leaf(&self, columns: &BlockColumns) -> Self::Block {
        (0..64).map(|at| [columns.e[at], columns.x[at]]).collect()
    }

    fn known(&self, _number: usize) -> Option<Self::Block> {
        None
    }

    fn join(&self, level: u32, quarters: [Self::Block; 4]) -> Self::Block {
        let (side, half) = (1 << level, 1 << (level - 1));
        let column = |at: usize| {
            let (x, y) = (at % side, at / side);
            quarters[2 * (x / half) + y / half][y % half * half + x % half]
        };
        (0..side * side).map(column).collect()
    }

    fn taken(&self, _number: usize, block: Self::Block) -> Self::Block {
        block
    }
}

impl Structure for Recorder {
    type Output = Columns;
    const SO_FAR: &'static str = "the columns so far";
    const FINISHING: &'static str = "sorting the columns";

    fn memory_bytes(&self) -> u64 {
        0
    }

    fn result_bytes(&self) -> u64 {
        0
    }

    fn finish_bytes(&self) -> u64 {
        0
    }

    fn check_room(&self) -> Result<(), adumbra_bake::Error> {
        Ok(())
    }

    fn finish(self, blocks: Vec<Self::Block>) -> Columns {
        let Self { size, level } = self;
        let across = size[0].div_ceil(1 << level);
        let column = |i: u32, j: u32| {
            let inside = ((j % (1 << level)) << level) + i % (1 << level);
            blocks[(j >> level) as usize * across as usize + (i >> level) as usize][inside as usize]
        };
        let intervals = (0..size[1]).flat_map(|j| (0..size[0]).map(move |i| (i, j)));
        Columns { size, intervals: intervals.map(|(i, j)| column(i, j)).collect() }
    }
}

/// All structures made from one scene.
struct Structures {
    columns: Columns,
    dag: Dag,
    packed: DagFile,
    depths: DepthTree,
}

impl Structures {
    fn of(scene: &Scene, options: &BakeOptions) -> Self {
        let BuiltStructure { grid, settings, made: columns, .. } =
            build(scene, options, Watch::none(), |size, level| Recorder { size, level }).unwrap();
        let dag = build(scene, options, Watch::none(), GraphSink::new).unwrap().made;
        let in_layout = |layout| {
            let options = DagOptions { bake: options.clone(), layout };
            bake(scene, &options, Watch::none()).unwrap().file
        };
        let (plain, packed) = (in_layout(DagLayout::Plain), in_layout(DagLayout::Packed));
        assert!(plain == DagFile { grid, settings, body: DagBody::Plain(dag.clone()) });
        assert!(packed == DagFile { body: body_in(DagLayout::Packed, dag.clone()).unwrap(), ..plain });
        assert!(*graph_of(&packed.body).unwrap() == dag);
        let depths = Bake::with_options(scene, options).in_memory().unwrap();
        assert_eq!((depths.grid, depths.settings), (grid, settings));
        Self { columns, dag, packed, depths: (*depths.tree).clone() }
    }

    /// Checks the voxels at the ends of each column's interval and at its switch depth, and one random voxel.
    /// Returns the number of columns with an end.
    fn check(&self, random: &mut Random) -> u32 {
        let [nx, ny, nz] = self.columns.size;
        assert_eq!((self.dag.size, self.depths.size()), ([nx, ny, nz], [nx, ny, nz]));
        let again = graph_of_depths(&self.depths).unwrap();
        let structures: [(&str, &dyn LeafMasks); 4] = [
            ("graph", &self.dag),
            ("packed graph", self.packed.body.leaf_masks()),
            ("quadtree", &self.depths),
            ("quadtree's graph", &again),
        ];
        let mut ends = 0;
        for (at, &[e, x]) in self.columns.intervals.iter().enumerate() {
            let (i, j) = (at as u32 % nx, at as u32 / nx);
            let anywhere = (random.unit() * f64::from(nz)) as u32;
            let switch = self.depths.value(i, j);
            let near = [e.wrapping_sub(1), e, x.wrapping_sub(1), x, switch.wrapping_sub(1), switch, anywhere];
            for k in near.into_iter().filter(|&k| k < nz) {
                for (name, leaf_masks) in structures {
                    let lit = leaf_masks.voxel(i, j, k);
                    assert!(k >= e || lit, "{name}: ({i}, {j}, {k}) is shadowed before {e}");
                    assert!(k < x || !lit, "{name}: ({i}, {j}, {k}) is lit from {x} on");
                }
                assert_eq!(again.voxel(i, j, k), k < switch, "({i}, {j}, {k}): {switch}");
            }
            ends += u32::from(x < nz);
        }
        ends
    }
}

/// Boxes and open quads above a floor.
fn any_scene(random: &mut Random) -> Scene {
    let mut any = |low: f32, high: f32| low + (high - low) * random.unit() as f32;
    let mut mesh = Mesh::default();
    add_box(&mut mesh, [-10.0, -1.0, -10.0], [10.0, 0.0, 10.0]);
    for _ in 0..6 {
        let low = [any(-9.0, 7.0), any(-0.5, 4.0), any(-9.0, 7.0)];
        add_box(&mut mesh, low, low.map(|c| c + any(0.05, 4.0)));
        let [x, y, z] = [any(-9.0, 7.0), any(0.1, 6.0), any(-9.0, 7.0)];
        let [width, rise, length] = [any(0.5, 4.0), any(-1.0, 1.0), any(0.5, 4.0)];
        add_quad(
            &mut mesh,
            [[x, y, z], [x, y, z + length], [x + width, y + rise, z + length], [x + width, y + rise, z]],
        );
    }
    scene_of(vec![mesh])
}

#[test]
fn graphs_and_quadtrees_respect_column_intervals() {
    let mut random = Random::for_batch(3, 0);
    let mut ends = 0;
    for case in 0..24_u32 {
        let scene = any_scene(&mut random);
        let mut any = |low: f64, high: f64| low + (high - low) * random.unit();
        let sun = Sun::from_direction([any(-1.0, 1.0), any(0.2, 1.0), any(-1.0, 1.0)]).unwrap();
        let options = BakeOptions::new(sun, Size::Resolution(128)).with(|o| {
            o.frame = [FrameChoice::Light, FrameChoice::Oblique, FrameChoice::Auto][case as usize % 3];
            o.builder = if case % 4 == 3 { ColumnBuilder::Plain } else { ColumnBuilder::Fast };
            o.thickness_world = if case % 2 == 0 { 0.0 } else { any(0.0, 0.5) };
            o.assume_ground = (case % 5 != 0).into();
            o.closed_regions = case % 7 != 0;
            o.receivers = if case % 3 == 0 { Receivers::Static } else { Receivers::All };
            o.switch_within_voxels = if case % 6 == 0 { 4 } else { 0 };
        });
        ends += Structures::of(&scene, &options).check(&mut random);
    }
    assert!(ends > 5_000, "{ends} columns have an end");
}

#[test]
fn graphs_and_quadtrees_of_masked_trees_respect_intervals() {
    let mut scene = generate(GeneratedKind::Forest, 1);
    scene.instances.retain(|instance| instance.name.starts_with("tree"));
    scene.instances.truncate(6);
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    let options = BakeOptions::new(sun, Size::Resolution(128)).with(|o| o.frame = FrameChoice::Light);
    Structures::of(&scene, &options).check(&mut Random::for_batch(4, 0));
}

#[test]
#[ignore = "slow: a forest"]
fn graphs_and_quadtrees_of_masked_forest_respect_intervals() {
    let scene = generate(GeneratedKind::Forest, 1);
    let sun = Sun::from_direction([0.5, 0.8, 0.35]).unwrap();
    let options = BakeOptions::new(sun, Size::Resolution(256)).with(|o| o.frame = FrameChoice::Light);
    Structures::of(&scene, &options).check(&mut Random::for_batch(4, 0));
}
