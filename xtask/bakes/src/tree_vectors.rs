//! The test vectors of the tree file. Valid ones are made from functions voxel -> lit, and their answers come
//! from these functions, not from the tree. Broken ones have one fault each.

use std::collections::HashMap;
use std::error::Error;
use std::fs;
use std::path::Path;

use adumbra::{Bias, Bounds, Sun};
use adumbra_papers::tree::symmetric::SymmetricTree;
use adumbra_papers::tree::{
    AttributeKind, CaptureBias, LossyChange, Region, Regions, TreeBody, TreeFile, TreeSettings, TreeSpace,
    VoxelTree,
};
use serde_json::{Map, Value, json};

use crate::broken::{self, Broken};
use crate::voxels::{Scatter, noise, point_in};

/// Whether a cube, given by its lowest voxel and its level, is all lit or all shadowed; `None` if it is
/// mixed. A single voxel is never mixed.
type Cubes = dyn Fn([u32; 3], u32) -> Option<bool>;

/// Writes all vectors below `folder`.
pub(crate) fn run(folder: &Path) -> Result<(), Box<dyn Error>> {
    let valid = folder.join("valid");
    fs::create_dir_all(&valid)?;
    let vectors = valid_vectors()?;
    for vector in &vectors {
        vector.file.check()?;
        fs::write(valid.join(format!("{}.adumbra", vector.name)), vector.file.encode())?;
        fs::write(valid.join(format!("{}.json", vector.name)), vector.answers())?;
    }
    write_symmetric(&vectors, &folder.join("symmetric"))?;
    broken::write(&broken_vectors(&vectors)?, &folder.join("invalid"))?;
    Ok(())
}

/// Writes the vectors without an attribute again, with a symmetric body of both kinds. Their answers are the
/// same.
fn write_symmetric(vectors: &[Vector], folder: &Path) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(folder)?;
    for vector in vectors.iter().filter(|v| v.file.attribute_kind.is_none()) {
        let TreeBody::Words(tree) = &vector.file.body else { continue };
        for (mirrors, kind) in [(false, "narrow"), (true, "mirrors")] {
            let body = TreeBody::Symmetric(SymmetricTree::of(tree, mirrors)?);
            let file = TreeFile { body, ..vector.file.clone() };
            file.check()?;
            fs::write(folder.join(format!("{}-{kind}.adumbra", vector.name)), file.encode())?;
        }
    }
    Ok(())
}

struct Vector {
    name: &'static str,
    what: &'static str,
    file: TreeFile,
    cubes: Box<Cubes>,
    /// Lowest voxel and level of each voxel of the leaves of eight, in the order of the attribute.
    leaf_voxels: Vec<([u32; 3], u32)>,
    /// Voxels that must be among the answers.
    shown: Vec<[u32; 3]>,
}

impl Vector {
    fn new(
        name: &'static str,
        what: &'static str,
        space: TreeSpace,
        cubes: impl Fn([u32; 3], u32) -> Option<bool> + 'static,
    ) -> Result<Self, Box<dyn Error>> {
        let (tree, leaf_voxels) = build(space.depth, &cubes)?;
        let settings = TreeSettings {
            closed_regions: true,
            ignore_alpha: false,
            bounds: None,
            capture_bias: CaptureBias { constant_texels: 1.0, slope_texels: 2.0 },
            bias: Bias::default(),
            lossy: None,
            triangles: 12,
            instances: 1,
        };
        let file = TreeFile {
            space,
            sun: Sun::from_direction([0.5, 0.8, 0.35])?,
            settings,
            regions: Regions::uniform(space.depth),
            body: TreeBody::Words(tree),
            attribute: Vec::new(),
            attribute_kind: None,
        };
        Ok(Self { name, what, file, cubes: Box::new(cubes), leaf_voxels, shown: Vec::new() })
    }

    /// Returns the attribute's byte for a voxel, or null if it is not in a leaf of eight. `None` if there is
    /// no attribute.
    fn attribute(&self, voxel: [u32; 3]) -> Option<Value> {
        self.file.attribute_kind?;
        let holds = |(at, level): &([u32; 3], u32)| (0..3).all(|a| voxel[a] >> level == at[a] >> level);
        Some(self.leaf_voxels.iter().find(|leaf| holds(leaf)).map_or(Value::Null, |(at, _)| json!(byte(*at))))
    }

    /// Returns points in and around the cube, with their visibility according to the function.
    fn answers(&self) -> String {
        let side = self.file.space.side_voxels();
        let mut scatter = Scatter::new();
        let mut rows = Vec::new();
        let mut add = |what: &str, at: [f64; 3], visibility: bool, attribute: Option<Value>| {
            let world = self.file.space.to_world(at);
            // List the keys alphabetically, whether or not serde_json preserves the order.
            let mut row = Map::new();
            row.extend(attribute.map(|value| ("attribute".to_owned(), value)));
            row.insert("visibility".to_owned(), u8::from(visibility).into());
            row.insert("where".to_owned(), what.into());
            row.insert("world".to_owned(), json!(world));
            rows.push(format!("    {}", Value::Object(row)));
        };
        let scattered = (0..24).map(|_| [side; 3].map(|n| scatter.below(n)));
        let voxels: Vec<[u32; 3]> = self.shown.iter().copied().chain(scattered).collect();
        for v in voxels {
            let lit = (self.cubes)(v, 0).expect("a voxel is lit or not");
            add("inside", point_in(v), lit, self.attribute(v));
        }
        let (middle, end) = (f64::from(side) * 0.5, f64::from(side));
        for a in 0..3 {
            for (what, c) in [("outside, below", -0.5), ("outside, at the end", end + 0.5)] {
                let mut at = [middle; 3];
                at[a] = c;
                add(what, at, true, None);
            }
        }
        let (what, leaf_voxels) = (json!(self.what), self.leaf_voxels.len());
        let points = rows.join(",\n");
        format!(
            "{{\n  \"what\": {what},\n  \"leaf_voxels\": {leaf_voxels},\n  \"points\": [\n{points}\n  ]\n}}\n"
        )
    }
}

/// Returns the attribute of the leaf voxel with this lowest voxel.
fn byte([x, y, z]: [u32; 3]) -> u8 {
    ((x * 7 + y * 13 + z * 29) % 256) as u8
}

/// Makes [`Cubes`] from a function of single voxels.
fn voxels(lit: impl Fn(u32, u32, u32) -> bool) -> impl Fn([u32; 3], u32) -> Option<bool> {
    move |[x, y, z], level| (level == 0).then(|| lit(x, y, z))
}

/// Returns a function that is lit outside a ball in the middle of `side` voxels and its shadow straight
/// below.
fn ball(side: u32) -> impl Fn(u32, u32, u32) -> bool {
    move |x, y, z| {
        let [dx, dy, dz] = [x, y, z].map(|c| f64::from(c) - 0.5 * f64::from(side - 1));
        let radius = 0.3 * f64::from(side);
        let square = dx * dx + dz * dz;
        square > radius * radius || dy > (radius * radius - square).sqrt()
    }
}

fn valid_vectors() -> Result<Vec<Vector>, Box<dyn Error>> {
    let space = |depth| TreeSpace { p_min: [-12.5, 40.0, 3.25], voxel_size: 0.5, depth };
    let unit = |depth| TreeSpace { p_min: [0.0; 3], voxel_size: 1.0, depth };
    let deep = TreeSpace { p_min: [1000.0, -20.0, 5e5], voxel_size: 0.03125, depth: 15 };
    let target = [5_u32, 32_767, 12_345];
    let rings = Regions::rings([-2.5, 10.5], &[3.0, 7.0], 6);
    let cell_of = {
        // The boxes end at cell boundaries, so that every cell has one depth.
        let boxes = [(16..32_u32, 12..24_u32, 6_u32), (8..40, 4..36, 5)];
        move |[x, y, z]: [u32; 3]| {
            let holds = boxes.iter().find(|(bx, bz, _)| bx.contains(&x) && bz.contains(&z));
            let level = 6 - holds.map_or(4, |b| b.2);
            [x, y, z].map(|c| c >> level << level)
        }
    };
    let region = |x: [u32; 2], z: [u32; 2], depth| {
        let world = |c: u32, low: f64| low + f64::from(c) * 0.5;
        Region { x: x.map(|c| world(c, -12.5)), z: z.map(|c| world(c, 3.25)), depth }
    };
    let regions =
        Regions { base_depth: 4, list: vec![region([16, 32], [12, 24], 6), region([8, 40], [4, 36], 5)] };
    let mut all = vec![
        Vector::new(
            "example_8",
            "the worked example of the specification",
            unit(3),
            voxels(|x, y, z| y >= 4 || y == 3 && x < 4 || x >= 4 && z < 4),
        )?,
        Vector::new("all_lit", "one word, depth 1", unit(1), |_, _| Some(true))?,
        Vector::new("all_shadowed", "one word, depth 15", unit(15), |_, _| Some(false))?,
        Vector::new("root_mask", "the root is a leaf of eight", unit(1), voxels(|x, _, _| x == 1))?,
        Vector::new(
            "root_mask_large",
            "a leaf of eight that are cubes, not voxels",
            unit(4),
            voxels(|_, y, z| y >= 8 || z < 8),
        )?,
        Vector::new(
            "half_space",
            "a slanted plane, lit on one side",
            space(5),
            voxels(|x, y, z| x + 2 * y + 3 * z < 95),
        )?,
        Vector::new("ball", "the shadow of a ball; bounds, flags and a lossy merge", space(6), {
            voxels(ball(64))
        })?,
        Vector::new("noise", "nothing repeats: the tree at its largest", space(4), voxels(noise))?,
        Vector::new("deep", "one lit voxel, 15 levels down", deep, move |at, level| {
            let holds = (0..3).all(|a| at[a] >> level == target[a] >> level);
            if holds && level > 0 { None } else { Some(holds) }
        })?,
        Vector::new(
            "shared_levels",
            "one block, used at two levels",
            unit(5),
            voxels(|x, y, z| {
                // The same shape at full and at half size.
                let scale = if x < 16 { 2 } else { 4 };
                let [x, y, z] = [x, y, z].map(|c| c / scale % 4);
                x == 0 || y > z
            }),
        )?,
        Vector::new(
            "regions",
            "three depths: cells of 1, 2 and 4 voxels",
            space(6),
            voxels(move |x, y, z| {
                let [x, y, z] = cell_of([x, y, z]);
                x + 3 * y + z < 120
            }),
        )?,
        Vector::new("rings", "nested squares, a tree that is one leaf", space(6), |_, _| Some(true))?,
        Vector::new("penumbra", "one byte per leaf voxel", space(4), voxels(ball(16)))?,
    ];
    let find = |all: &[Vector], name| all.iter().position(|v| v.name == name).ok_or("no such vector");
    let at = find(&all, "deep")?;
    all[at].shown = vec![target, [5, 32_767, 12_344], [4, 32_767, 12_345], [5, 32_766, 12_345]];
    let at = find(&all, "regions")?;
    all[at].file.regions = regions;
    let at = find(&all, "rings")?;
    all[at].file.regions = rings;
    let at = find(&all, "ball")?;
    let settings = &mut all[at].file.settings;
    settings.bounds = Some(Bounds { min: [-8.0, 0.0, -8.0], max: [8.0, 12.5, 8.0] });
    (settings.closed_regions, settings.ignore_alpha) = (false, true);
    settings.lossy = Some(LossyChange { max_share: 0.01, leaf_voxels: 30_000, changed_voxels: 299 });
    let at = find(&all, "penumbra")?;
    let vector = &mut all[at];
    vector.file.attribute = vector.leaf_voxels.iter().map(|(corner, _)| byte(*corner)).collect();
    vector.file.attribute_kind = Some(AttributeKind::Penumbra);
    vector.shown = vector.leaf_voxels.iter().step_by(53).map(|(corner, _)| *corner).collect();
    Ok(all)
}

/// A node before its block has an index.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Child {
    Uniform(bool),
    Mask(u8),
    Block(usize),
}

/// Merges equal blocks while it builds.
struct BlockMerger<'a> {
    cubes: &'a Cubes,
    blocks: Vec<[Child; 8]>,
    ids: HashMap<[Child; 8], usize>,
    leaf_voxels: Vec<([u32; 3], u32)>,
}

/// The tree, and its leaf voxels in traversal order.
type MergedTree = (VoxelTree, Vec<([u32; 3], u32)>);

fn build(depth: u32, cubes: &Cubes) -> Result<MergedTree, Box<dyn Error>> {
    let mut builder = BlockMerger { cubes, blocks: Vec::new(), ids: HashMap::new(), leaf_voxels: Vec::new() };
    let root = builder.node([0; 3], depth);
    let mut words = vec![0];
    words[0] = builder.place(root, &mut HashMap::new(), &mut words);
    Ok((VoxelTree::from_words(depth, words)?, builder.leaf_voxels))
}

impl BlockMerger<'_> {
    fn node(&mut self, at: [u32; 3], level: u32) -> Child {
        if let Some(lit) = (self.cubes)(at, level) {
            return Child::Uniform(lit);
        }
        let half = level - 1;
        let corner = |c: u32| {
            let bits = [c >> 2, c >> 1 & 1, c & 1];
            [0, 1, 2].map(|a| at[a] + (bits[a] << half))
        };
        let mut children = [Child::Uniform(false); 8];
        for (c, child) in (0..).zip(&mut children) {
            *child = self.node(corner(c), half);
        }
        let bit = |(c, child): (usize, &Child)| match child {
            Child::Uniform(lit) => Some(u8::from(*lit) << c),
            Child::Mask(_) | Child::Block(_) => None,
        };
        match children.iter().enumerate().map(bit).try_fold(0, |mask, bit| Some(mask | bit?)) {
            Some(0) => Child::Uniform(false),
            Some(255) => Child::Uniform(true),
            Some(mask) => {
                self.leaf_voxels.extend((0..8).map(|c| (corner(c), half)));
                Child::Mask(mask)
            }
            None => {
                let next = self.blocks.len();
                let id = *self.ids.entry(children).or_insert(next);
                if id == next {
                    self.blocks.push(children);
                }
                Child::Block(id)
            }
        }
    }

    /// Returns the word of a child. Blocks are numbered in order of first visit.
    fn place(&self, child: Child, placed: &mut HashMap<usize, u32>, words: &mut Vec<u32>) -> u32 {
        let id = match child {
            Child::Uniform(lit) => return 0x8000_0000 | u32::from(lit),
            Child::Mask(mask) => return 0xC000_0000 | u32::from(mask),
            Child::Block(id) => id,
        };
        if let Some(&at) = placed.get(&id) {
            return at;
        }
        let at = words.len();
        placed.insert(id, at as u32);
        words.resize(at + 8, 0);
        for (c, below) in self.blocks[id].into_iter().enumerate() {
            words[at + c] = self.place(below, placed, words);
        }
        at as u32
    }
}

const REGIONS: usize = 0;
const BODY: usize = 1;
const ATTRIBUTE: usize = 2;
/// Byte offsets of the rows of the section table.
const ROWS: [usize; 3] = [224, 248, 272];

/// A tree file that is being broken.
type Bytes = broken::Bytes<224, 320>;

impl Bytes {
    fn put_node(self, word: usize, value: u32) -> Self {
        let at = self.section(BODY) + 4 * word;
        self.put_word(at, value)
    }

    /// Returns the offset of byte `byte` of the region at `index`.
    fn region(&self, index: usize, byte: usize) -> usize {
        self.section(REGIONS) + 40 * index + byte
    }
}

fn broken_vectors(vectors: &[Vector]) -> Result<Vec<Broken>, Box<dyn Error>> {
    let encode = |name: &str| -> Result<Bytes, Box<dyn Error>> {
        let vector = vectors.iter().find(|v| v.name == name).ok_or("no such vector")?;
        Ok(broken::Bytes(vector.file.encode()))
    };
    // A root, its block, and a block that two children share: 17 words.
    let small = encode("example_8")?;
    let (regions, ball, penumbra) = (encode("regions")?, encode("ball")?, encode("penumbra")?);
    let (s, r, p) = (|| small.clone(), || regions.clone(), || penumbra.clone());
    let nan = 0x7FF8_0000_0000_0000_u64.to_le_bytes();
    let mut all = Vec::new();
    let mut add = |name, error, names, bytes| all.push(Broken { name, error, fault: None, names, bytes });

    add("empty", "Truncated", "header", Vec::new());
    add("magic", "Magic", "ADUMTREE", s().put(0, b"GIF89a\0\0").0);
    add("light_file", "OtherKind", "light-aligned", s().put(0, b"ADUMBRA\n").0);
    add("future_version", "FutureVersion", "version 2", s().put_word(8, 2).sealed());
    add("version_0", "HeaderField", "version", s().put_word(8, 0).sealed());
    add("header_length", "HeaderField", "header_bytes", s().put_word(12, 384).sealed());
    add("cut_in_header", "Truncated", "header", s().cut(200).0);
    add("cut_in_regions", "Truncated", "regions", r().cut(regions.section(REGIONS) + 50).0);
    add("cut_in_body", "Truncated", "body", r().cut(regions.section(BODY) + 20).0);
    add("cut_last_byte", "Truncated", "attribute", p().cut(penumbra.0.len() - 1).0);
    add("goes_on", "TrailingBytes", "end", [s().0, vec![0]].concat());
    add("header_damaged", "HeaderChecksum", "header", s().put_word(20, 4).0);
    add("regions_damaged", "SectionChecksum", "regions", r().put(regions.section(REGIONS), &[1]).0);
    add("body_damaged", "SectionChecksum", "body", r().put(regions.section(BODY) + 9, &[77]).0);
    add("attribute_damaged", "SectionChecksum", "attribute", p().put(penumbra.section(ATTRIBUTE), &[77]).0);
    add("padding", "Padding", "between", s().put(391, &[1]).0);
    add("unknown_flag", "HeaderField", "flags", s().put_word(16, 1 << 4).sealed());
    add("depth_0", "HeaderField", "depth", s().put_word(20, 0).sealed());
    add("depth_16", "HeaderField", "depth", s().put_word(20, 16).sealed());
    add("depth_of_no_region", "HeaderField", "depth", s().put_word(20, 4).sealed());
    add("base_depth_0", "HeaderField", "base_depth", s().put_word(24, 0).sealed());
    add("base_depth_below_all", "HeaderField", "base_depth", s().put_word(24, 4).sealed());
    add("region_count_257", "HeaderField", "region_count", s().put_word(28, 257).sealed());
    add("body_kind_0", "HeaderField", "body_kind", s().put_word(32, 0).sealed());
    add("body_kind_3", "HeaderField", "body_kind", s().put_word(32, 3).sealed());
    add("attribute_kind_2", "HeaderField", "attribute_kind", p().put_word(36, 2).sealed());
    add("attribute_of_symmetric", "HeaderField", "attribute_kind", p().put_word(32, 2).sealed());
    add("p_min_nan", "HeaderField", "p_min", s().put(48, &nan).sealed());
    add("voxel_size_0", "HeaderField", "voxel_size", s().put_f64(64, 0.0).sealed());
    add("voxel_size_infinite", "HeaderField", "voxel_size", s().put_f64(64, f64::INFINITY).sealed());
    add("sun_not_unit", "HeaderField", "sun", s().put_f64(72, 0.9).sealed());
    add("sun_below", "HeaderField", "sun", s().put(72, &[0; 24]).put_f64(80, -1.0).sealed());
    add("bounds_without_flag", "HeaderField", "bounds", s().put_f64(96, 1.0).sealed());
    add("bounds_inverted", "HeaderField", "bounds", s().put_word(16, 5).put_f64(96, 1.0).sealed());
    add("capture_bias_nan", "HeaderField", "capture_bias", s().put(152, &nan).sealed());
    add("bias_infinite", "HeaderField", "bias", s().put_f64(168, f64::NEG_INFINITY).sealed());
    add("lossy_without_flag", "HeaderField", "lossy", s().put_word(192, 1).sealed());
    add("lossy_share_2", "HeaderField", "lossy", ball.clone().put_f64(184, 2.0).sealed());
    add("lossy_changed_all", "HeaderField", "lossy", ball.put_word(204, 1).sealed());
    add("reserved_tail", "HeaderField", "reserved", s().put_word(312, 1).sealed());
    add("reserved_in_table", "HeaderField", "reserved", s().put_word(ROWS[BODY] + 20, 1).sealed());
    add("section_in_header", "SectionBounds", "offset", s().put_word(ROWS[REGIONS], 0).sealed());
    add("section_overlap", "SectionBounds", "offset", r().put_word(ROWS[BODY], 320).sealed());
    add(
        "section_far_away",
        "SectionBounds",
        "offset",
        s().put_word(ROWS[ATTRIBUTE] + 4, 0x7FFF_FFFF).sealed(),
    );
    add("region_count_1", "SectionBounds", "regions", s().put_word(28, 1).sealed());
    add("body_length_0", "SectionBounds", "body", s().put_word(ROWS[BODY] + 8, 0).sealed());
    add("body_length_odd", "SectionBounds", "body", s().put_word(ROWS[BODY] + 8, 67).sealed());
    add("body_length_huge", "SectionBounds", "body", s().put_word(ROWS[BODY] + 12, 0x1000_0000).sealed());
    add(
        "body_length_past_end",
        "Truncated",
        "body",
        s().put_word(ROWS[BODY] + 8, 0x4000_0000).put_word(ROWS[ATTRIBUTE], 0x4000_0140).sealed(),
    );
    add("attribute_missing", "SectionBounds", "attribute", s().put_word(36, 1).sealed());
    add("attribute_unasked", "SectionBounds", "attribute", p().put_word(36, 0).sealed());
    let length = penumbra.word(ROWS[ATTRIBUTE] + 8);
    add(
        "attribute_short",
        "SectionBounds",
        "attribute",
        p().put_word(ROWS[ATTRIBUTE] + 8, length - 1).cut(penumbra.0.len() - 1).sealed(),
    );

    let at = |byte| regions.region(1, byte);
    add("region_inverted", "Region", "region 1", r().put_f64(at(8), -100.0).sealed());
    add("region_nan", "Region", "region 1", r().put(at(16), &nan).sealed());
    add("region_depth_0", "Region", "region 1", r().put_word(at(32), 0).sealed());
    add("region_depth_16", "Region", "region 1", r().put_word(at(32), 16).sealed());
    add("region_reserved", "Region", "region 1", r().put_word(at(36), 1).sealed());

    let mut tree = |name, fault, names, bytes| {
        all.push(Broken { name, error: "Tree", fault: Some(fault), names, bytes });
    };
    let sixteen = s().put_word(ROWS[BODY] + 8, 64).put_word(ROWS[ATTRIBUTE], 384).cut(384);
    tree("words_16", "Length", "16 words", sixteen.sealed());
    tree("uniform_bits", "Word", "word 3", s().put_node(3, 0x8000_0003).sealed());
    tree("leaf_bits", "Word", "word 11", s().put_node(11, 0xC000_01CC).sealed());
    tree("mask_none", "Word", "word 11", s().put_node(11, 0xC000_0000).sealed());
    tree("mask_all", "Word", "word 11", s().put_node(11, 0xC000_00FF).sealed());
    tree("index_in_a_block", "Index", "word 1 ", s().put_node(1, 10).sealed());
    tree("index_past_end", "Index", "word 1 ", s().put_node(1, 17).sealed());
    tree("root_not_first", "Order", "word 9", s().put_node(0, 9).sealed());
    tree("block_unreached", "Order", "word 1", s().put_node(0, 0x8000_0001).sealed());
    tree("cycle", "TooDeep", "word 1", s().put_node(9, 1).sealed());
    tree("depth_2", "TooDeep", "word 9", s().put_word(20, 2).put_word(24, 2).sealed());
    let uniform = [11, 12, 15, 16].into_iter().fold(s(), |bytes, word| bytes.put_node(word, 0x8000_0001));
    tree("block_of_uniform", "NotMerged", "word 9", uniform.sealed());
    Ok(all)
}
