//! `cargo xtask vectors`: writes `test_vectors/` again, with the same bytes every time. This module makes those of the
//! light-aligned file.
//!
//! Valid files are made from functions voxel -> lit, and their answers come from these functions, not from the graph. A
//! reader that agrees with them has therefore decoded the graph correctly. Each file exists in the plain layout and, if
//! its columns are monotone, also in the packed one and as `depths`. Each broken file is a valid one with one fault.
//! `valid_v1` and `valid_v2` contain files written by earlier versions and never change.

use std::collections::HashMap;
use std::error::Error;
use std::fs;
use std::path::Path;
use std::rc::Rc;

use adumbra::file::HEADER_BYTES;
use adumbra::layout::plain::{Dag, LIT, SHADOWED, STATE_LIT, STATE_MIXED, STATE_SHADOWED};
use adumbra::layout::{LEAF_NODE_LEVEL, top_dims};
use adumbra::{Bounds, Frame, Layout, LightBody, LightGrid, Receivers, ShadowFile, Sun};
use adumbra_bake::convert::{body_in, graph_of};
use serde_json::json;

use crate::broken::{self, Broken};
use crate::by_hand::{overhead_grid, settings_for};
use crate::tree_vectors;
use crate::voxels::{Scatter, noise, point_in};

/// Whether the voxel (x, y, z) is lit.
type Voxels = dyn Fn(u32, u32, u32) -> bool;

/// Writes all vectors below `root/test_vectors`.
pub(crate) fn run(root: &Path) -> Result<(), Box<dyn Error>> {
    let folder = root.join("test_vectors");
    let valid = folder.join("valid");
    fs::create_dir_all(&valid)?;
    for vector in all_valid_vectors()? {
        let mut bytes = Vec::new();
        vector.file.write_to(&mut bytes)?;
        fs::write(valid.join(format!("{}.adumbra", vector.name)), bytes)?;
        fs::write(valid.join(format!("{}.json", vector.name)), vector.answers())?;
    }
    broken::write(&broken_vectors()?, &folder.join("invalid"))?;
    tree_vectors::run(&folder.join("tree"))
}

struct Vector {
    name: String,
    what: &'static str,
    file: ShadowFile,
    lit: Rc<Voxels>,
}

impl Vector {
    /// Returns points in and around the grid, with their visibility according to the function.
    fn answers(&self) -> String {
        let grid = &self.file.grid;
        let size = grid.size;
        let mut scatter = Scatter::new();
        let mut rows = Vec::new();
        let mut add = |what: &str, at: [f64; 3], visibility: bool| {
            let world = grid.to_world(at);
            rows.push(format!(
                "    {}",
                json!({"world": world, "visibility": u8::from(visibility), "where": what})
            ));
        };
        for _ in 0..24 {
            let v = size.map(|n| scatter.below(n));
            add("inside", point_in(v), (self.lit)(v[0], v[1], v[2]));
        }
        let [x, y] = [size[0], size[1]].map(|n| scatter.below(n));
        let (cx, cy) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
        let [ex, ey, ez] = size.map(f64::from);
        add("outside, x below 0", [-0.5, cy, ez - 0.5], true);
        add("outside, x at the end", [ex + 0.5, cy, ez - 0.5], true);
        add("outside, y below 0", [cx, -0.5, ez - 0.5], true);
        add("outside, y at the end", [cx, ey + 0.5, ez - 0.5], true);
        add("outside and beyond the far end", [-3.5, cy, ez + 5.5], true);
        add("sunward", [cx, cy, -0.5], true);
        add("far sunward", [cx, cy, -1000.5], true);
        let last = (self.lit)(x, y, size[2] - 1);
        add("beyond the far end", [cx, cy, ez + 0.5], last);
        add("far beyond the far end", [cx, cy, ez + 1000.5], last);
        format!("{{\n  \"what\": {},\n  \"points\": [\n{}\n  ]\n}}\n", json!(self.what), rows.join(",\n"))
    }
}

/// Returns the vectors in all layouts that can represent them.
fn all_valid_vectors() -> Result<Vec<Vector>, Box<dyn Error>> {
    let mut all = valid_vectors()?;
    let monotone = |v: &Vector| Some([v.packed()?, v.in_layout("depths", Layout::Depths)?]);
    let others: Vec<Vector> = all.iter().filter_map(monotone).flatten().collect();
    all.extend(others);
    Ok(all)
}

fn valid_vectors() -> Result<Vec<Vector>, Box<dyn Error>> {
    let overhead = example_grid([8, 8, 8]);
    let slanted = |size, voxel_size| -> Result<LightGrid, Box<dyn Error>> {
        let sun = Sun::from_direction([0.5, 0.8, 0.35])?;
        Ok(LightGrid::new(sun, Frame::Light, voxel_size, [-33.0, 81.0, -55.5], size))
    };
    let low = {
        let sun = Sun::from_angles(250.0, 3.0)?;
        LightGrid::new(sun, Frame::Light, 0.1, [1.25e6, -20.0, 5e6], [24, 16, 200])
    };
    let upright = |towards, yaw_radians, corner, size| -> Result<LightGrid, Box<dyn Error>> {
        let sun = Sun::from_direction(towards)?;
        Ok(LightGrid::new(sun, Frame::Oblique { yaw_radians }, 0.5, corner, size))
    };
    let mut vectors = vec![
        Vector::new("example_8", "the worked example of the specification", overhead, 3, |x, y, z| {
            z < 2 || z == 2 && (x < 4 || y == 7)
        }),
        Vector::new("all_lit", "no occluder: a top grid of one lit root", overhead, 3, |_, _, _| true),
        Vector::new(
            "all_shadowed",
            "every root shadowed, eight of them",
            example_grid([16, 16, 16]),
            3,
            |_, _, _| false,
        ),
        Vector::new(
            "half_space",
            "a slanted plane, lit on one side",
            slanted([64, 64, 64], 0.5)?,
            6,
            |x, y, z| x + 2 * y + 3 * z < 190,
        ),
        Vector::new(
            "upright",
            "the oblique frame along the world's axes",
            upright([0.5, 0.8, 0.35], 0.0, [-64.0, 1024.0, 8.0], [64, 40, 48])?,
            5,
            |x, y, z| z < 10 + x / 5 + (y / 8) % 3,
        ),
        Vector::new(
            "upright_turned_low",
            "the oblique frame, turned by 0.7 radians, sun at 6°",
            upright([-0.77, 0.105, -0.63], 0.7, [5120.0, -72.0, -16.0], [40, 40, 24])?,
            3,
            |x, y, z| z < (3 * x + 5 * y) % 23,
        ),
        Vector::new("sphere", "the shadow of a sphere", slanted([64, 64, 64], 0.25)?, 4, sphere),
        Vector::new("low_sun_tall", "longer along the light than across, sun at 3°", low, 5, |x, y, z| {
            z < 20 + 6 * x + (y * y) % 17
        }),
        Vector::new(
            "odd_sizes",
            "sizes that are not multiples of 8, in roots of 16",
            slanted([13, 21, 37], 1.5)?,
            4,
            |x, y, z| (x * 7 + y * 3) % 40 > z,
        ),
        Vector::new("one_voxel", "the smallest grid", example_grid([1, 1, 1]), 3, |x, y, z| x + y + z > 0),
        Vector::new(
            "deep_root",
            "a root cube far larger than the grid: level 20",
            example_grid([9, 9, 9]),
            20,
            |x, y, z| x < 5 || y >= 3 || z == 0,
        ),
        Vector::new(
            "shared_levels",
            "one node without leaf masks, used at levels 4 and 5",
            slanted([64, 32, 32], 1.0)?,
            5,
            |x, y, z| if x < 32 { !(8..16).contains(&x) || y >= 16 || z >= 16 } else { x < 48 },
        ),
        Vector::new(
            "terraces",
            "steps of 8 and 16 voxels: a node without leaf masks at levels 4 and 5 whose columns are monotone",
            slanted([64, 32, 64], 1.0)?,
            5,
            |x, _, z| z < if x < 32 { 16 * (x / 16) } else { 8 * (x / 8 % 2) },
        ),
        Vector::new(
            "slopes",
            "up to eight masks in a node of level 3: bit planes",
            slanted([40, 40, 40], 1.0)?,
            5,
            |x, y, z| z < x / 3 + (y * y + x * 7) % 19,
        ),
        Vector::new(
            "cliff",
            "depths that differ by more than 16 bits can hold",
            slanted([16, 1, 66_000], 1.0)?,
            5,
            |x, _, z| z < if x < 8 { 5 + 65_900 * (x / 4) } else { 34_000 + 300 * (x % 3) },
        ),
        Vector::new(
            "noise",
            "nothing repeats: the graph at its largest",
            slanted([24, 24, 24], 2.0)?,
            5,
            noise,
        ),
    ];
    let settings = &mut vectors[6].file.settings;
    settings.bounds = Some(Bounds { min: [-8.0, 0.0, -8.0], max: [8.0, 12.5, 8.0] });
    settings.receivers = Receivers::Static;
    settings.thickness_world = 0.3;
    let settings = &mut vectors[7].file.settings;
    (settings.assume_ground, settings.closed_regions, settings.ignore_alpha) = (false, false, true);
    Ok(vectors)
}

/// Returns a grid with the sun overhead and voxels of one unit: x is +X, y is +Z, z points down from y = 8.
fn example_grid(size: [u32; 3]) -> LightGrid {
    overhead_grid([0.0, 8.0, 0.0], size)
}

/// Lit unless inside or behind the sphere.
fn sphere(x: u32, y: u32, z: u32) -> bool {
    let [dx, dy, dz] = [x, y, z].map(|c| f64::from(c) - 31.5);
    let square = dx * dx + dy * dy;
    square > 400.0 || dz < -(400.0 - square).sqrt()
}

impl Vector {
    fn new(
        name: &'static str,
        what: &'static str,
        grid: LightGrid,
        root_level: u32,
        lit: impl Fn(u32, u32, u32) -> bool + 'static,
    ) -> Self {
        let settings = settings_for(&grid);
        let file = ShadowFile { grid, settings, body: LightBody::Plain(build(grid.size, root_level, &lit)) };
        Self { name: name.to_owned(), what, file, lit: Rc::new(lit) }
    }

    /// Returns the vector in the packed layout, if it is monotone.
    fn packed(&self) -> Option<Self> {
        self.in_layout("packed", Layout::Packed)
    }

    fn in_layout(&self, suffix: &str, layout: Layout) -> Option<Self> {
        let body = body_in(layout, graph_of(&self.file.body).ok()?.into_owned()).ok()?;
        let file = ShadowFile { grid: self.file.grid, settings: self.file.settings, body };
        Some(Self { name: format!("{}_{suffix}", self.name), file, lit: Rc::clone(&self.lit), ..*self })
    }
}

/// A child before it has an index in the file: shadowed, lit, or an index into the merged nodes or leaf masks.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Child {
    Shadowed,
    Lit,
    Mixed(usize),
}

/// Merges equal nodes and leaf masks while it builds.
struct Builder<'a> {
    lit: &'a Voxels,
    /// Size of the grid. Voxels outside are never looked up: those to the sides count as lit, those behind the far end
    /// as shadowed.
    size: [u32; 3],
    nodes: Vec<[Child; 8]>,
    leaf_masks: Vec<u64>,
    /// Keyed by whether the children are leaf masks, and by the children: a node without leaf masks below may be used
    /// at several levels.
    node_ids: HashMap<(bool, [Child; 8]), usize>,
    leaf_mask_ids: HashMap<u64, usize>,
}

fn build(size: [u32; 3], root_level: u32, lit: &Voxels) -> Dag {
    let (node_ids, leaf_mask_ids) = (HashMap::new(), HashMap::new());
    let mut builder =
        Builder { lit, size, nodes: Vec::new(), leaf_masks: Vec::new(), node_ids, leaf_mask_ids };
    let top_dims = top_dims(size, root_level);
    let mut dag = Dag { size, root_level, top_dims, ..Dag::default() };
    let mut roots = Vec::new();
    for gz in 0..top_dims[2] {
        for gy in 0..top_dims[1] {
            for gx in 0..top_dims[0] {
                roots.push(builder.node([gx, gy, gz].map(|g| g << root_level), root_level));
            }
        }
    }
    let mut placed = Placed { nodes: HashMap::new(), leaf_masks: HashMap::new() };
    for root in roots {
        let entry = match root {
            Child::Shadowed => SHADOWED,
            Child::Lit => LIT,
            Child::Mixed(id) => placed.node(&builder, &mut dag, id, root_level),
        };
        dag.top.push(entry);
    }
    dag
}

impl Builder<'_> {
    fn node(&mut self, at: [u32; 3], level: u32) -> Child {
        if (0..2).any(|a| at[a] >= self.size[a]) {
            return Child::Lit;
        }
        if at[2] >= self.size[2] {
            return Child::Shadowed;
        }
        let mut children = [Child::Lit; 8];
        for (c, child) in (0_u32..).zip(&mut children) {
            *child = if level == LEAF_NODE_LEVEL {
                self.leaf_mask([at[0], at[1], at[2] + c])
            } else {
                let half = level - 1;
                let bits = [c >> 2, c >> 1 & 1, c & 1];
                self.node([0, 1, 2].map(|a| at[a] + (bits[a] << half)), half)
            };
        }
        if !matches!(children[0], Child::Mixed(_)) && children.iter().all(|c| *c == children[0]) {
            return children[0];
        }
        let next = self.nodes.len();
        let id = *self.node_ids.entry((level == LEAF_NODE_LEVEL, children)).or_insert(next);
        if id == next {
            self.nodes.push(children);
        }
        Child::Mixed(id)
    }

    fn leaf_mask(&mut self, at: [u32; 3]) -> Child {
        let mask = (0..64_u32).fold(0_u64, |mask, bit| {
            let v = [at[0] + bit % 8, at[1] + bit / 8, at[2]];
            let beside = (0..2).any(|a| v[a] >= self.size[a]);
            mask | u64::from(beside || v[2] < self.size[2] && (self.lit)(v[0], v[1], v[2])) << bit
        });
        match mask {
            0 => Child::Shadowed,
            u64::MAX => Child::Lit,
            _ => {
                let next = self.leaf_masks.len();
                let id = *self.leaf_mask_ids.entry(mask).or_insert(next);
                if id == next {
                    self.leaf_masks.push(mask);
                }
                Child::Mixed(id)
            }
        }
    }
}

/// Indices in the file, in order of first visit.
struct Placed {
    nodes: HashMap<usize, u32>,
    leaf_masks: HashMap<usize, u32>,
}

impl Placed {
    fn node(&mut self, from: &Builder<'_>, dag: &mut Dag, id: usize, level: u32) -> u32 {
        if let Some(&at) = self.nodes.get(&id) {
            return at;
        }
        let at = dag.nodes.len();
        self.nodes.insert(id, at as u32);
        let children = from.nodes[id];
        let states = children.map(|c| match c {
            Child::Shadowed => STATE_SHADOWED,
            Child::Lit => STATE_LIT,
            Child::Mixed(_) => STATE_MIXED,
        });
        dag.nodes.push(states.iter().rev().fold(0, |header, s| header << 2 | s));
        let mixed: Vec<usize> =
            children.iter().filter_map(|c| if let Child::Mixed(id) = c { Some(*id) } else { None }).collect();
        dag.nodes.resize(at + 1 + mixed.len(), 0);
        for (i, child) in mixed.into_iter().enumerate() {
            dag.nodes[at + 1 + i] = if level == LEAF_NODE_LEVEL {
                *self.leaf_masks.entry(child).or_insert_with(|| {
                    dag.leaf_masks.push(from.leaf_masks[child]);
                    dag.leaf_masks.len() as u32 - 1
                })
            } else {
                self.node(from, dag, child, level - 1)
            };
        }
        at as u32
    }
}

const TOP: usize = 0;
const NODES: usize = 1;
const LEAF_MASKS: usize = 2;

/// A light-aligned file that is being broken.
type Bytes = broken::Bytes<280, 384>;

impl Bytes {
    fn put_node(self, word: usize, value: u32) -> Self {
        let at = self.section(NODES) + 4 * word;
        self.put_word(at, value)
    }
}

fn broken_vectors() -> Result<Vec<Broken>, Box<dyn Error>> {
    let encode = |name: &str, vectors: &[Vector]| -> Result<Bytes, Box<dyn Error>> {
        let vector = vectors.iter().find(|v| v.name == name).ok_or("no such vector")?;
        let mut bytes = Vec::new();
        vector.file.write_to(&mut bytes)?;
        Ok(broken::Bytes(bytes))
    };
    let vectors = all_valid_vectors()?;
    // One level-3 node (header and pointer) and one leaf mask.
    let small = encode("example_8", &vectors)?;
    // Roots of level 4, several levels of nodes.
    let deep = encode("odd_sizes", &vectors)?;
    let (s, d) = (|| small.clone(), || deep.clone());
    let mut all = Vec::new();
    let mut add = |name, error, names, bytes| all.push(Broken { name, error, fault: None, names, bytes });

    add("empty", "Truncated", "header", Vec::new());
    add("magic", "Magic", "ADUMBRA", s().put(0, b"GIF89a\0\0").0);
    add("copied_as_text", "Magic", "ADUMBRA", s().put(7, b"\r").0);
    add("future_version", "FutureVersion", "version 4", s().put_word(8, 4).sealed());
    add("version_0", "HeaderField", "version", s().put_word(8, 0).sealed());
    add("header_length", "HeaderField", "header_bytes", s().put_word(12, 256).sealed());
    add("cut_in_header", "Truncated", "header", s().0[..200].to_vec());
    add("cut_in_half", "Truncated", "nodes", d().0[..deep.section(NODES) + 20].to_vec());
    add("cut_last_byte", "Truncated", "leaf_masks", d().0[..deep.0.len() - 1].to_vec());
    add("goes_on", "TrailingBytes", "end", [s().0, vec![0]].concat());
    add("header_damaged", "HeaderChecksum", "header", s().put_word(20, 16).0);
    add("top_damaged", "SectionChecksum", "top", d().put(deep.section(TOP), &[1]).0);
    add("nodes_damaged", "SectionChecksum", "nodes", d().put(deep.section(NODES) + 9, &[77]).0);
    add("leaf_masks_damaged", "SectionChecksum", "leaf_masks", d().put(deep.section(LEAF_MASKS), &[0x5A]).0);
    add("padding", "Padding", "between", s().put(391, &[1]).0);
    add("unknown_flag", "HeaderField", "flags", s().put_word(16, 1 << 5).sealed());
    add("resolution_0", "HeaderField", "resolution", s().put_word(20, 0).sealed());
    add("size_0", "HeaderField", "size", s().put_word(28, 0).sealed());
    add("root_level_2", "HeaderField", "root_level", s().put_word(36, 2).sealed());
    add("root_level_21", "HeaderField", "root_level", s().put_word(36, 21).sealed());
    add("top_dims", "HeaderField", "top_dims", s().put_word(40, 2).sealed());
    add("layout_unknown", "HeaderField", "layout", s().put_word(52, 7).sealed());
    add("layout_of_another", "SectionBounds", "top", s().put_word(52, 1).sealed());
    add("layout_in_version_1", "HeaderField", "reserved", s().put_word(8, 1).put_word(52, 1).sealed());
    add("reserved_tail", "HeaderField", "reserved", s().put_word(376, 1).sealed());
    add("voxel_size_0", "HeaderField", "voxel_size", s().put_f64(56, 0.0).sealed());
    add("voxel_size_infinite", "HeaderField", "voxel_size", s().put_f64(56, f64::INFINITY).sealed());
    add("sun_not_unit", "HeaderField", "sun", s().put_f64(72, 1.001).sealed());
    add("sun_below", "HeaderField", "sun", s().put_f64(72, -1.0).sealed());
    add(
        "corner_nan",
        "HeaderField",
        "corner",
        s().put(88, &0x7FF8_0000_0000_0000_u64.to_le_bytes()).sealed(),
    );
    add("frame_unknown", "HeaderField", "frame", s().put_word(356, 2).sealed());
    add("frame_in_version_2", "HeaderField", "reserved", s().put_word(8, 2).put_word(356, 1).sealed());
    add("yaw_of_light", "HeaderField", "yaw", s().put_f64(360, 0.5).sealed());
    add("yaw_nan", "HeaderField", "yaw", s().put_word(356, 1).put_f64(360, f64::NAN).sealed());
    add("yaw_of_other_axes", "HeaderField", "axes", s().put_word(356, 1).put_f64(360, 0.5).sealed());
    add("axes_skew", "HeaderField", "axes", s().put_f64(120, 1e-6).sealed());
    add("axes_left_handed", "HeaderField", "axes", s().put_f64(112, -1.0).sealed());
    add("thickness_negative", "HeaderField", "thickness", s().put_f64(184, -0.1).sealed());
    add("bias_infinite", "HeaderField", "bias", s().put_f64(200, f64::NEG_INFINITY).sealed());
    add("bounds_without_flag", "HeaderField", "bounds", s().put_f64(216, 1.0).sealed());
    add("bounds_inverted", "HeaderField", "bounds", s().put_word(16, 0x13).put_f64(216, 1.0).sealed());
    add("section_in_header", "SectionBounds", "offset", s().put_word(280, 0).sealed());
    add("section_overlap", "SectionBounds", "offset", s().put_word(304, 384).sealed());
    add("section_far_away", "SectionBounds", "offset", s().put_word(332, 0x7FFF_FFFF).sealed());
    add("top_length", "SectionBounds", "length", s().put_word(288, 8).sealed());
    add("nodes_length_odd", "SectionBounds", "length", s().put_word(312, 7).sealed());
    add("leaf_masks_length_huge", "SectionBounds", "length", s().put_word(340, 0x1000_0000).sealed());
    add("leaf_masks_length_past_end", "Truncated", "leaf_masks", s().put_word(336, 0x4000_0000).sealed());
    add(
        "top_huge",
        "SectionBounds",
        "top",
        s().put(24, &[255; 12]).put(40, &[0, 0, 0, 32].repeat(3)).sealed(),
    );

    let mut graph = |name, fault, names, bytes| {
        all.push(Broken { name, error: "Graph", fault: Some(fault), names, bytes });
    };
    let root = small.section(TOP);
    let header = small.word(small.section(NODES));
    graph("root_past_end", "PointerRange", "top grid entry 0", s().put_word(root, 2).sealed());
    graph("root_not_first", "Order", "top grid entry 0", s().put_word(root, 1).sealed());
    graph("header_upper_bits", "HeaderBits", "node word 0", s().put_node(0, header | 1 << 16).sealed());
    graph("child_state_3", "ChildState", "child 2", s().put_node(0, header | 1 << 4).sealed());
    graph("node_all_lit", "Uniform", "node word 0", s().put_node(0, 0x5555).sealed());
    graph("node_all_shadowed", "Uniform", "node word 0", s().put_node(0, 0).sealed());
    graph("node_past_end", "NodeEnd", "2 pointers", s().put_node(0, header | 2 << 6).sealed());
    graph("pointer_unreached", "Unreachable", "node word 1", s().put_node(0, 0x0005).sealed());
    graph("leaf_mask_past_end", "PointerRange", "leaf mask 1", s().put_node(1, 1).sealed());
    graph(
        "leaf_mask_all_lit",
        "Uniform",
        "leaf mask 0",
        s().put(small.section(LEAF_MASKS), &[255; 8]).sealed(),
    );
    graph(
        "leaf_mask_all_shadowed",
        "Uniform",
        "leaf mask 0",
        s().put(small.section(LEAF_MASKS), &[0; 8]).sealed(),
    );
    graph("roots_all_lit", "Unreachable", "node word 0", s().put_word(root, LIT).sealed());
    graph("cycle", "TwoLevels", "node word 1", d().put_node(1, 0).sealed());
    graph("into_a_node", "NotAHeader", "node word 1", d().put_node(1, 1).sealed());
    graph(
        "node_out_of_order",
        "Order",
        "node word 1",
        d().put_node(1, deep.word(deep.section(NODES) + 4) + 1).sealed(),
    );
    graph("node_past_all", "PointerRange", "node word 1", d().put_node(1, 0x7FFF_FFFF).sealed());
    let valid = [encode("example_8_packed", &vectors)?, encode("sphere_packed", &vectors)?];
    all.extend(flipped(
        "Packed",
        &valid,
        &[
            ("packed_top_length", "TopLength", "top of"),
            ("packed_pools", "Pools", "pool begins"),
            ("packed_filler", "Filler", "is padding"),
            ("packed_column", "Column", "column of"),
            ("packed_node_bits", "NodeBits", "invalid bits"),
            ("packed_node_end", "NodeEnd", "past the end of its pool"),
            ("packed_leaf_mask_range", "LeafMaskRange", "refers to leaf mask"),
            ("packed_leaf_masks", "LeafMasks", "proper subset"),
            ("packed_pointer", "Pointer", "no node begins"),
            ("packed_order", "Order", "after its slots"),
            ("packed_unreached", "Unreached", "not reachable"),
        ],
    )?);
    let bytes = encode("example_8_depths", &vectors)?.put_word(36, 6).sealed();
    let (name, fault) = ("depths_root_level", Some("RootLevel"));
    all.push(Broken { name, error: "Depths", fault, names: "root level 6", bytes });
    let valid = [encode("sphere_depths", &vectors)?, encode("cliff_depths", &vectors)?];
    all.extend(flipped(
        "Depths",
        &valid,
        &[
            ("depths_order", "Order", "which is not before it"),
            ("depths_end", "End", "past the end of the code"),
            ("depths_wide", "Wide", "refers to wide entry"),
            ("depths_bits", "Bits", "invalid bits"),
            ("depths_ranks", "Ranks", "above its last"),
        ],
    )?);
    Ok(all)
}

/// Returns a broken file per entry of `faults`, which has its name, its fault and what the message names. Each is the
/// first file of `valid` in which a flipped bit causes the fault.
fn flipped(
    error: &'static str,
    valid: &[Bytes],
    faults: &[(&'static str, &'static str, &'static str)],
) -> Result<Vec<Broken>, String> {
    let broken = |&(name, fault, names)| {
        let bytes = valid.iter().find_map(|valid| with_bit_flipped(valid, fault));
        let bytes = bytes.ok_or_else(|| format!("no bit flipped is {fault}"))?;
        Ok(Broken { name, error, fault: Some(fault), names, bytes })
    };
    faults.iter().map(broken).collect()
}

/// Returns the file with one bit of its sections flipped, the first that causes this fault. `None` if there is no such
/// bit.
fn with_bit_flipped(valid: &Bytes, fault: &str) -> Option<Vec<u8>> {
    let bits = (HEADER_BYTES..valid.0.len()).flat_map(|at| (0..8).map(move |bit| (at, bit)));
    bits.map(|(at, bit)| valid.clone().put(at, &[valid.0[at] ^ 1 << bit]).sealed())
        .find(|bytes| ShadowFile::from_bytes(bytes).is_err_and(|e| e.fault() == Some(fault)))
}
