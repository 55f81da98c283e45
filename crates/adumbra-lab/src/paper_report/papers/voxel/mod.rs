//! Counterpart to the voxel shadows of 2021: `bench tree`, a path over a landscape, and a ball that rolls into shadow.

mod claims;

use super::super::seen::Seen;
use super::{Realised, Show, Verdict};
use crate::bench::tree::{Document, FrameRow, ReductionRow};
use crate::page::{Body, Table};
use crate::paper_report::data::Data;
use crate::report::Report;
use adumbra_tree::morton;

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
        ("figure 4-1", Show::Below(nothing_done)),
        ("figure 4-2", Show::Below(acne)),
        ("figure 4-3", Show::Below(bias)),
        ("figure 4-4", Show::Below(jags)),
        ("figure 4-5", Show::Below(filters)),
        ("figure 4-6", Show::Below(both)),
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

fn quadtree_path(_: &mut Seen<'_>, body: &mut Body) {
    // In the plane, a child's bits of x and y are those of an octree's child without z.
    let plane: Vec<String> =
        morton::path([5, 3, 0], 3).iter().map(|child| (child >> 1).to_string()).collect();
    body.paragraph(&format!("Ours, from `adumbra_tree::morton`: {}.", plane.join(", ")));
}

fn octree_path(_: &mut Seen<'_>, body: &mut Body) {
    body.paragraph(&format!(
        "Ours, from `adumbra_tree::morton`: {}; decoded: {:?}.",
        path([5, 3, 5]),
        morton::voxel(&[5, 2, 7])
    ));
}

/// Size in pixels of one picture of the benchmark's sheets, which have two rows of three.
const CELL: [u32; 2] = [480, 320];
/// Indices of the pictures on a sheet.
const NONE: u32 = 0;
const BIAS: u32 = 1;
const PCF_3: u32 = 2;
const PCF_5: u32 = 3;
const BOTH: u32 = 4;
const RAYS: u32 = 5;

fn place(i: u32) -> [u32; 4] {
    [i % 3 * CELL[0], i / 3 * CELL[1], CELL[0], CELL[1]]
}

fn name(i: u32) -> &'static str {
    ["no bias, no filter", "bias", "3 × 3 × 3", "5 × 5 × 5", "bias, 5 × 5 × 5", "rays"]
        .get(i as usize)
        .unwrap_or(&"")
}

/// Adds a pair of pictures of a sheet.
fn pair(seen: &mut Seen<'_>, sheet: &str, left: u32, right: u32, caption: &str, body: &mut Body) {
    let path = format!("tree/tree-sheet-{sheet}.png");
    let (a, b) = ((place(left), name(left)), (place(right), name(right)));
    seen.pair_of_parts(SECTION, &path, a, b, caption, body);
}

fn one(seen: &mut Seen<'_>, sheet: &str, i: u32, part: Option<[u32; 4]>, caption: &str, body: &mut Body) {
    let path = format!("tree/tree-sheet-{sheet}.png");
    match seen.data.picture(&path, Some(part.unwrap_or_else(|| place(i)))) {
        Some(picture) => body.picture(&picture, caption, caption),
        None => seen.missing(SECTION, body),
    }
}

fn simple_scene(seen: &mut Seen<'_>, body: &mut Body) {
    one(
        seen,
        "primitives",
        RAYS,
        None,
        "Ours: simple solids, `adumbra generate primitives`, with ray-traced shadows",
        body,
    );
    seen.made_by(SECTION, "others", body);
}

fn landscape(seen: &mut Seen<'_>, body: &mut Body) {
    one(
        seen,
        "landscape",
        RAYS,
        None,
        "Ours: low-poly terrain with trees, rocks and houses, `adumbra generate landscape`, with ray-traced shadows",
        body,
    );
    seen.made_by(SECTION, "others", body);
}

/// Returns the benchmark's results, empty if there are none.
fn document(data: &Data) -> Document {
    data.results(FILE).unwrap_or_default()
}

impl Document {
    fn reduction_rows(&self) -> &[ReductionRow] {
        self.reductions.as_ref().map_or(&[], |part| &part.rows)
    }

    fn frame_rows(&self) -> &[FrameRow] {
        self.frames.as_ref().map_or(&[], |part| &part.rows.frames)
    }
}

/// Returns a table of bytes before and after, row by row.
fn shares(document: &Document, caption: &str, of: fn(&ReductionRow) -> [f64; 2]) -> Table {
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

fn merging(seen: &mut Seen<'_>, body: &mut Body) {
    let alt = "Size after upward merging in percent of the complete tree, and after sharing in percent of the merged tree, by depth, one line per scene";
    seen.plot(
        SECTION,
        "tree/tree-merging.svg",
        alt,
        "Ours: percent left after upward merging and, for figure 3-5, after sharing by hash",
        body,
    );
    let document = document(seen.data);
    body.table(&shares(
        &document,
        "Ours: the complete tree, and the tree with equal children collapsed, in 32-bit words",
        |r| [r.complete_bytes, r.merged_bytes as f64],
    ));
    seen.made_by(SECTION, "reductions", body);
}

fn hashing(seen: &mut Seen<'_>, body: &mut Body) {
    let document = document(seen.data);
    body.table(&shares(
        &document,
        "Ours: the merged tree, and the tree with equal subtrees stored once, in 32-bit words",
        |r| [r.merged_bytes as f64, r.graph_bytes as f64],
    ));
    let alt = "Time and memory of merging by hash divided by those of sorting, by depth";
    seen.plot(SECTION, "tree/tree-reductions.svg", alt, "Ours: hashing compared with sorting", body);
    seen.made_by(SECTION, "reductions", body);
}

fn closed_regions(seen: &mut Seen<'_>, body: &mut Body) {
    let file = |what: &str| format!("tree/tree-nodes-primitives-{what}.png");
    let caption = "Ours: a layer of the tree at depth 8 from above, one square per leaf, coloured by size, dark in shadow";
    let (open, closed) = (file("open"), file("closed"));
    seen.pair(SECTION, (&open, "all defined"), (&closed, "interiors free"), caption, body);
    let document = document(seen.data);
    let mut table =
        Table::new("Ours: bytes at depth 10", &["scene", "all defined, MB", "interiors free, MB", "% left"]);
    for (scene, open, closed) in closed_bytes(&document) {
        table.row([
            scene,
            format!("{:.3}", open / 1e6),
            format!("{:.3}", closed / 1e6),
            format!("{:.0}", 100.0 * closed / open),
        ]);
    }
    body.table(&table);
    body.paragraph("Closed regions are found by the winding of the triangles, not with colliders, which the paper itself calls the wrong approach.");
    seen.made_by(SECTION, "others", body);
}

/// Returns the bytes by scene with everything defined, and with insides free.
fn closed_bytes(document: &Document) -> Vec<(String, f64, f64)> {
    let all = document.frames.as_ref().map_or(&[][..], |part| &part.rows.closed_regions);
    let closed = |scene: &str| {
        let row = all.iter().find(|r| r.scene == scene && r.closed_regions)?;
        Some(row.graph_bytes as f64)
    };
    let open = all.iter().filter(|r| !r.closed_regions);
    open.filter_map(|r| Some((r.scene.clone(), r.graph_bytes as f64, closed(&r.scene)?))).collect()
}

fn builders(seen: &mut Seen<'_>, body: &mut Body) {
    let alt = "Build times of the three builders in seconds, one group of bars per scene, and time of the pooled builder divided by that of recursion, by depth";
    seen.plot(
        SECTION,
        "tree/tree-builders.svg",
        alt,
        "Ours: seconds at the smallest depth, and the pooled builder's time divided by that of recursion",
        body,
    );
    let document = document(seen.data);
    let mut table = Table::new(
        "Ours: seconds to build and reduce, one thread",
        &["scene", "depth", "recursive", "iterative", "iterative, pooled", "pooled / recursive"],
    );
    for row in document.builders.iter().flat_map(|part| &part.rows) {
        let seconds = row.seconds;
        let cells = seconds.list().map(|s| format!("{s:.3}"));
        let head = [row.scene.clone(), row.depth.to_string()];
        let ratio = format!("{:.2}", seconds.pooled / seconds.recursive);
        table.row(head.into_iter().chain(cells).chain([ratio]));
    }
    body.table(&table);
    body.paragraph(
        "The paper's builders run in C#, where each frame on the heap is an object for the garbage collector. Here a frame \
         costs one allocation at most, so the three builders are close.",
    );
    seen.made_by(SECTION, "builders", body);
}

fn nothing_done(seen: &mut Seen<'_>, body: &mut Body) {
    pair(
        seen,
        "primitives",
        NONE,
        RAYS,
        "Ours: simple solids at depth 8, coarse enough to show the voxels",
        body,
    );
    seen.made_by(SECTION, "others", body);
}

fn acne(seen: &mut Seen<'_>, body: &mut Body) {
    pair(seen, "landscape", NONE, RAYS, "Ours: the landscape at depth 10", body);
    counts(seen, body);
}

fn counts(seen: &mut Seen<'_>, body: &mut Body) {
    let document = document(seen.data);
    let mut table = Table::new(
        "Ours: wrong results at points on surfaces, depth 10, %",
        &["scene", "look-up", "lit called shadowed", "shadowed called lit"],
    );
    for row in document.filters.iter().flat_map(|part| &part.rows) {
        let [acne, leak] = [row.acne, row.leak].map(|share| format!("{:.3}", 100.0 * share));
        table.row([row.scene.clone(), row.look_up.clone(), acne, leak]);
    }
    if table.rows.is_empty() {
        seen.missing(SECTION, body);
    } else {
        body.table(&table);
        seen.made_by(SECTION, "others", body);
    }
}

fn bias(seen: &mut Seen<'_>, body: &mut Body) {
    pair(seen, "primitives", NONE, BIAS, "Ours: simple solids at depth 8", body);
    pair(seen, "landscape", NONE, BIAS, "Ours: the landscape at depth 10", body);
    seen.made_by(SECTION, "others", body);
}

fn jags(seen: &mut Seen<'_>, body: &mut Body) {
    let [x, y, width, height] = place(BIAS);
    let middle = [x + width / 4, y + height / 4, width / 2, height / 2];
    one(
        seen,
        "primitives",
        BIAS,
        Some(middle),
        "Ours: a detail of figure 4-3; each step of the shadow's outline is one voxel",
        body,
    );
    seen.made_by(SECTION, "others", body);
}

fn filters(seen: &mut Seen<'_>, body: &mut Body) {
    pair(seen, "primitives", NONE, PCF_3, "Ours: without bias", body);
    pair(seen, "primitives", NONE, PCF_5, "Ours: without bias", body);
    seen.made_by(SECTION, "others", body);
}

fn both(seen: &mut Seen<'_>, body: &mut Body) {
    pair(seen, "primitives", NONE, BOTH, "Ours: simple solids at depth 8", body);
    seen.made_by(SECTION, "others", body);
}

fn result(seen: &mut Seen<'_>, body: &mut Body) {
    pair(
        seen,
        "primitives",
        BOTH,
        RAYS,
        "Ours (a): simple solids, at depth 8 instead of 11, so that differences are visible",
        body,
    );
    pair(seen, "landscape", BOTH, RAYS, "Ours (b): the landscape at depth 10", body);
    pair(
        seen,
        "landscape-grazing",
        BOTH,
        RAYS,
        "Ours: the landscape under a sun at 8°, a case in which the paper reports flaws",
        body,
    );
    let document = document(seen.data);
    let mut table = Table::new(
        "Ours: agreement with rays, %",
        &["scene", "depth", "all points", "two voxels from outlines", "MB"],
    );
    for row in document.frame_rows().iter().filter(|r| r.frame == "world") {
        table.row([
            row.scene.clone(),
            row.depth.to_string(),
            format!("{:.3}", 100.0 * row.agreement),
            format!("{:.3}", 100.0 * row.interior_agreement),
            format!("{:.2}", row.bytes as f64 / 1e6),
        ]);
    }
    body.table(&table);
    seen.made_by(SECTION, "others", body);
}

const PATH: &str = "shadows/path/report.json";

fn frame_times(seen: &mut Seen<'_>, body: &mut Body) {
    let alt = "Milliseconds of the shadow passes by frame along a path, for voxels with two filters and for cascades";
    seen.plot(
        "shadows",
        "shadows/path/path.svg",
        alt,
        "Ours: shadow passes along a path over the landscape",
        body,
    );
    let path = seen.data.results::<Report>(PATH).and_then(|report| report.path);
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
    seen.made_by("shadows", "path", body);
}

fn ball(seen: &mut Seen<'_>, body: &mut Body) {
    let frame = |i: u32| format!("shadows/ball.{i:04}.png");
    for (from, to) in [(0, 1), (2, 3)] {
        let names = [from, to].map(|i| format!("frame {} of 4", i + 1));
        let (left, right) = (frame(from), frame(to));
        seen.pair(
            "shadows",
            (&left, &names[0]),
            (&right, &names[1]),
            "Ours: a ball rolls from sunlight into a shadow, which it receives from the baked file",
            body,
        );
    }
    seen.made_by("shadows", "ball", body);
}
