//! Counterpart to the voxel shadows of 2021: `bench tree`, a path over a landscape, and a ball that rolls
//! into shadow.

mod claims;

use super::super::inputs::PageInputs;
use super::{Realised, Show, Verdict};
use crate::bench::tree::{FrameRow, ReductionRow, TreeResults};
use crate::paper_report::data::Data;
use adumbra_compare::report::Report;
use adumbra_html::page::{Body, Table};
use adumbra_papers::tree::morton;
use adumbra_program::format::{figure, megabytes, percent};

const SECTION: &str = "tree";
const FILE: &str = "tree/tree.json";

pub(super) const PAPER: Realised = Realised {
    key: "voxel-2021",
    short: "Precomputed voxel shadows (2021)",
    items: &[
        ("table 3-1", Show::Below(quadtree_path)),
        ("table 3-2", Show::Below(octree_path)),
        ("figure 1-1", Show::Below(simple_scene)),
        ("figure 1-2", Show::Below(landscape)),
        ("figure 2-1", Show::Nothing("a drawing of light, occluder and shadow, with nothing to measure")),
        ("figure 3-1", Show::Nothing("a drawing; table 3-1 has its numbers")),
        ("figure 3-2", Show::Below(merging)),
        ("figure 3-3", Show::Below(closed_regions)),
        ("figure 3-4", Show::Below(builders)),
        ("figure 3-5", Show::Below(hashing)),
        ("figure 4-1", Show::Below(|inputs, body| pairs(inputs, &NOTHING_DONE, body))),
        ("figure 4-2", Show::Below(acne)),
        ("figure 4-3", Show::Below(|inputs, body| pairs(inputs, &BIAS, body))),
        ("figure 4-4", Show::Below(jags)),
        ("figure 4-5", Show::Below(|inputs, body| pairs(inputs, &FILTERS, body))),
        ("figure 4-6", Show::Below(|inputs, body| pairs(inputs, &BIAS_AND_FILTER, body))),
        ("figure 5-1", Show::Below(result)),
        ("figure 5-2", Show::Below(frame_times)),
        ("figure 5-3", Show::Below(ball)),
    ],
    claims: &[
        ("Doubling the resolution", claims::doubling),
        ("Survey, lossy merging", claims::lossy),
        ("A leaf's eight children", |_| Verdict::Realised("`--lossy` does not merge leaves")),
        ("Point (5, 3)", claims::worked_examples),
        ("Upward merging", claims::merging_shrinks),
        ("In closed regions", claims::closed_is_smaller),
        ("Dividing space ten times", claims::deep_recursion),
        ("At depth 8 recursion", claims::recursion_first),
        ("Sorting compares", |_| Verdict::Realised("`--reduction sort`")),
        ("Hashing leaves a smaller share", claims::landscape_shares_more),
        ("Hashing while building", claims::hash_beside_sort),
        ("A node takes 32 bits", |_| {
            Verdict::Realised(
                "two bits distinguish inner nodes, leaves and masks; an index has 31 bits (`spec/adumbra-tree.md`)",
            )
        }),
        ("A bias suppresses", claims::bias_beside_acne),
        ("PCF of 3 × 3 × 3 reads", |_| {
            Verdict::Realised("`--filter 3`; taps behind the receiver's plane are skipped")
        }),
        ("3 × 3 × 3 and 5 × 5 × 5 soften", |_| {
            Verdict::Realised("`--filter 3` and `5`: figure 4-5 below")
        }),
        ("Shadows are good", claims::good_shadows),
        ("On the landscape CSM", claims::beside_cascades),
        ("A moving ball", |_| Verdict::Realised("`--move sphere`: figure 5-3 below")),
    ],
};

/// Returns the child numbers on the path to a point, outermost first.
fn path(xyz: [u32; 3]) -> String {
    let path: Vec<String> = morton::path(xyz, 3).iter().map(u32::to_string).collect();
    path.join(", ")
}

fn quadtree_path(_: &mut PageInputs<'_>, body: &mut Body) {
    // In the plane, a child's bits of x and y are those of an octree's child without z.
    let plane: Vec<String> =
        morton::path([5, 3, 0], 3).iter().map(|child| (child >> 1).to_string()).collect();
    body.paragraph(&format!("Ours, from `adumbra_papers::tree::morton`: {}.", plane.join(", ")));
}

fn octree_path(_: &mut PageInputs<'_>, body: &mut Body) {
    body.paragraph(&format!(
        "Ours, from `adumbra_papers::tree::morton`: {}; decoded: {:?}.",
        path([5, 3, 5]),
        morton::voxel(&[5, 2, 7])
    ));
}

/// Size in pixels of one picture of the benchmark's sheets, which have two rows of three.
const CELL: [u32; 2] = [480, 320];

/// The pictures of a sheet, row by row.
#[derive(Clone, Copy)]
enum Picture {
    Plain,
    Bias,
    Pcf3,
    Pcf5,
    BiasAndPcf5,
    Rays,
}

impl Picture {
    /// Returns its part of the sheet: `[x, y, width, height]` in pixels.
    fn part(self) -> [u32; 4] {
        let i = self as u32;
        [i % 3 * CELL[0], i / 3 * CELL[1], CELL[0], CELL[1]]
    }

    fn name(self) -> &'static str {
        match self {
            Self::Plain => "no bias, no filter",
            Self::Bias => "bias",
            Self::Pcf3 => "3 × 3 × 3",
            Self::Pcf5 => "5 × 5 × 5",
            Self::BiasAndPcf5 => "bias, 5 × 5 × 5",
            Self::Rays => "rays",
        }
    }
}

/// A sheet, the pictures left and right of the divider, and a caption.
type SheetPair = (&'static str, Picture, Picture, &'static str);

const NOTHING_DONE: [SheetPair; 1] = [(
    "primitives",
    Picture::Plain,
    Picture::Rays,
    "Ours: simple solids at depth 8, coarse enough to show the voxels",
)];
const BIAS: [SheetPair; 2] = [
    ("primitives", Picture::Plain, Picture::Bias, "Ours: simple solids at depth 8"),
    ("landscape", Picture::Plain, Picture::Bias, "Ours: the landscape at depth 10"),
];
const FILTERS: [SheetPair; 2] = [
    ("primitives", Picture::Plain, Picture::Pcf3, "Ours: without bias"),
    ("primitives", Picture::Plain, Picture::Pcf5, "Ours: without bias"),
];
const BIAS_AND_FILTER: [SheetPair; 1] =
    [("primitives", Picture::Plain, Picture::BiasAndPcf5, "Ours: simple solids at depth 8")];
const RESULT: [SheetPair; 3] = [
    (
        "primitives",
        Picture::BiasAndPcf5,
        Picture::Rays,
        "Ours (a): simple solids, at depth 8 instead of 11, so that differences are visible",
    ),
    ("landscape", Picture::BiasAndPcf5, Picture::Rays, "Ours (b): the landscape at depth 10"),
    (
        "landscape-grazing",
        Picture::BiasAndPcf5,
        Picture::Rays,
        "Ours: the landscape under a sun at 8°, a case in which the paper reports flaws",
    ),
];

fn sheet(name: &str) -> String {
    format!("tree/tree-sheet-{name}.png")
}

fn pair(inputs: &mut PageInputs<'_>, (of, left, right, caption): SheetPair, body: &mut Body) {
    let [left, right] = [left, right].map(|picture| (picture.part(), picture.name()));
    inputs.pair_of_parts(SECTION, &sheet(of), left, right, caption, body);
}

fn pairs(inputs: &mut PageInputs<'_>, shown: &[SheetPair], body: &mut Body) {
    for sheet_pair in shown {
        pair(inputs, *sheet_pair, body);
    }
    inputs.made_by(SECTION, "others", body);
}

/// Adds a part of a sheet.
fn one(inputs: &mut PageInputs<'_>, of: &str, part: [u32; 4], caption: &str, body: &mut Body) {
    match inputs.data.picture(&sheet(of), Some(part)) {
        Some(picture) => body.picture(&picture, caption, caption),
        None => inputs.missing(SECTION, body),
    }
    inputs.made_by(SECTION, "others", body);
}

fn simple_scene(inputs: &mut PageInputs<'_>, body: &mut Body) {
    let caption = "Ours: simple solids, `adumbra generate primitives`, with ray-traced shadows";
    one(inputs, "primitives", Picture::Rays.part(), caption, body);
}

fn landscape(inputs: &mut PageInputs<'_>, body: &mut Body) {
    let caption = "Ours: low-poly terrain with trees, rocks and houses, `adumbra generate landscape`, with ray-traced shadows";
    one(inputs, "landscape", Picture::Rays.part(), caption, body);
}

/// Returns the benchmark's results, empty if there are none.
fn document(data: &Data) -> TreeResults {
    data.results(FILE).unwrap_or_default()
}

impl TreeResults {
    fn reduction_rows(&self) -> &[ReductionRow] {
        self.reductions.as_ref().map_or(&[], |part| &part.rows)
    }

    fn frame_rows(&self) -> &[FrameRow] {
        self.frames.as_ref().map_or(&[], |part| &part.rows.frames)
    }
}

/// Returns a table of bytes before and after, row by row.
fn shares(document: &TreeResults, caption: &str, of: fn(&ReductionRow) -> [f64; 2]) -> Table {
    let mut table = Table::new(caption, &["scene", "depth", "before, MB", "after, MB", "% left"]);
    for row in document.reduction_rows() {
        let [before, after] = of(row);
        table.row([
            row.scene.clone(),
            row.depth.to_string(),
            format!("{:.3}", before / 1e6),
            format!("{:.3}", after / 1e6),
            format!("{:.2}", 100.0 * after / before),
        ]);
    }
    table
}

fn merging(inputs: &mut PageInputs<'_>, body: &mut Body) {
    let alt = "Size after upward merging in percent of the complete tree, and after sharing in percent of the merged tree, by depth, one line per scene";
    let caption = "Ours: percent left after upward merging and, for figure 3-5, after sharing by hash";
    inputs.plot(SECTION, "tree/tree-merging.svg", alt, caption, body);
    let document = document(inputs.data);
    body.table(&shares(
        &document,
        "Ours: the complete tree, and the tree with equal children collapsed, in 32-bit words",
        |r| [r.complete_bytes, r.merged_bytes as f64],
    ));
    inputs.made_by(SECTION, "reductions", body);
}

fn hashing(inputs: &mut PageInputs<'_>, body: &mut Body) {
    let document = document(inputs.data);
    body.table(&shares(
        &document,
        "Ours: the merged tree, and the tree with equal subtrees stored once, in 32-bit words",
        |r| [r.merged_bytes as f64, r.graph_bytes as f64],
    ));
    let alt = "Time and memory of merging by hash divided by those of sorting, by depth";
    inputs.plot(SECTION, "tree/tree-reductions.svg", alt, "Ours: hashing compared with sorting", body);
    inputs.made_by(SECTION, "reductions", body);
}

fn closed_regions(inputs: &mut PageInputs<'_>, body: &mut Body) {
    let file = |what: &str| format!("tree/tree-nodes-primitives-{what}.png");
    let caption = "Ours: a layer of the tree at depth 8 from above, one square per leaf, coloured by size, dark in shadow";
    let (open, closed) = (file("open"), file("closed"));
    inputs.pair(SECTION, (&open, "all defined"), (&closed, "interiors free"), caption, body);
    body.table(&Table::of(
        "Ours: bytes at depth 10",
        &closed_bytes(&document(inputs.data)),
        &[
            ("scene", |(scene, ..)| scene.clone()),
            ("all defined, MB", |(_, open, _)| figure(open / 1e6, 3)),
            ("interiors free, MB", |(_, _, closed)| figure(closed / 1e6, 3)),
            ("% left", |(_, open, closed)| percent(closed / open, 0)),
        ],
    ));
    body.paragraph("Closed regions are found by the winding of the triangles, not with colliders, which the paper itself calls the wrong approach.");
    inputs.made_by(SECTION, "others", body);
}

/// Returns the bytes by scene with everything defined, and with insides free.
fn closed_bytes(document: &TreeResults) -> Vec<(String, f64, f64)> {
    let all = document.frames.as_ref().map_or(&[][..], |part| &part.rows.closed_regions);
    let closed = |scene: &str| {
        let row = all.iter().find(|r| r.scene == scene && r.closed_regions)?;
        Some(row.graph_bytes as f64)
    };
    let open = all.iter().filter(|r| !r.closed_regions);
    open.filter_map(|r| Some((r.scene.clone(), r.graph_bytes as f64, closed(&r.scene)?))).collect()
}

fn builders(inputs: &mut PageInputs<'_>, body: &mut Body) {
    let alt = "Build times of the three builders in seconds, one group of bars per scene, and time of the pooled builder divided by that of recursion, by depth";
    let caption =
        "Ours: seconds at the smallest depth, and the pooled builder's time divided by that of recursion";
    inputs.plot(SECTION, "tree/tree-builders.svg", alt, caption, body);
    body.table(&Table::of(
        "Ours: seconds to build and reduce, one thread",
        document(inputs.data).builders.iter().flat_map(|part| &part.rows),
        &[
            ("scene", |r| r.scene.clone()),
            ("depth", |r| r.depth.to_string()),
            ("recursive", |r| figure(r.seconds.recursive, 3)),
            ("iterative", |r| figure(r.seconds.iterative, 3)),
            ("iterative, pooled", |r| figure(r.seconds.pooled, 3)),
            ("pooled / recursive", |r| figure(r.seconds.pooled / r.seconds.recursive, 2)),
        ],
    ));
    body.paragraph(
        "The paper's builders run in C#, where each frame on the heap is an object for the garbage collector. Here a frame \
         costs one allocation at most, so the three builders are close.",
    );
    inputs.made_by(SECTION, "builders", body);
}

fn acne(inputs: &mut PageInputs<'_>, body: &mut Body) {
    let shown = ("landscape", Picture::Plain, Picture::Rays, "Ours: the landscape at depth 10");
    pair(inputs, shown, body);
    let counts = Table::of(
        "Ours: wrong results at points on surfaces, depth 10, %",
        document(inputs.data).filters.iter().flat_map(|part| &part.rows),
        &[
            ("scene", |r| r.scene.clone()),
            ("look-up", |r| r.look_up.clone()),
            ("lit called shadowed", |r| percent(r.acne, 3)),
            ("shadowed called lit", |r| percent(r.leak, 3)),
        ],
    );
    inputs.table(SECTION, "others", &counts, None, body);
}

fn jags(inputs: &mut PageInputs<'_>, body: &mut Body) {
    let [x, y, width, height] = Picture::Bias.part();
    let middle = [x + width / 4, y + height / 4, width / 2, height / 2];
    let caption = "Ours: a detail of figure 4-3; each step of the shadow's outline is one voxel";
    one(inputs, "primitives", middle, caption, body);
}

fn result(inputs: &mut PageInputs<'_>, body: &mut Body) {
    for shown in RESULT {
        pair(inputs, shown, body);
    }
    body.table(&Table::of(
        "Ours: agreement with rays, %",
        document(inputs.data).frame_rows().iter().filter(|r| r.frame == "world"),
        &[
            ("scene", |r| r.scene.clone()),
            ("depth", |r| r.depth.to_string()),
            ("all points", |r| percent(r.agreement, 3)),
            ("two voxels from outlines", |r| percent(r.interior_agreement, 3)),
            ("MB", |r| megabytes(r.bytes, 2)),
        ],
    ));
    inputs.made_by(SECTION, "others", body);
}

const PATH: &str = "shadows/path/report.json";

fn frame_times(inputs: &mut PageInputs<'_>, body: &mut Body) {
    let alt = "Milliseconds of the shadow passes by frame along a path, for voxels with two filters and for cascades";
    inputs.plot(
        "shadows",
        "shadows/path/path.svg",
        alt,
        "Ours: shadow passes along a path over the landscape",
        body,
    );
    let path = inputs.data.results::<Report>(PATH).and_then(|report| report.path);
    let mut table = Table::new(
        "Ours: milliseconds over the path",
        &["technique", "median", "min", "max", "depth passes, median"],
    );
    for row in path.iter().flat_map(|path| &path.techniques) {
        let [mut times, mut depth] = [row.gpu_ms.clone(), row.depth_ms.clone()];
        times.sort_by(f64::total_cmp);
        depth.sort_by(f64::total_cmp);
        let at = |v: &[f64], i: usize| v.get(i).map_or_else(String::new, |ms| format!("{ms:.2}"));
        table.row([
            format!("`{}`", row.name),
            at(&times, times.len() / 2),
            at(&times, 0),
            at(&times, times.len().saturating_sub(1)),
            at(&depth, depth.len() / 2),
        ]);
    }
    body.table(&table);
    inputs.made_by("shadows", "path", body);
}

fn ball(inputs: &mut PageInputs<'_>, body: &mut Body) {
    let frame = |i: u32| format!("shadows/ball.{i:04}.png");
    for (from, to) in [(0, 1), (2, 3)] {
        let names = [from, to].map(|i| format!("frame {} of 4", i + 1));
        let (left, right) = (frame(from), frame(to));
        inputs.pair(
            "shadows",
            (&left, &names[0]),
            (&right, &names[1]),
            "Ours: a ball rolls from sunlight into a shadow, which it receives from the baked file",
            body,
        );
    }
    inputs.made_by("shadows", "ball", body);
}
