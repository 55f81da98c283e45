//! Beside the voxel shadows of 2021: `bench tree`, a path over a landscape, and a ball that rolls into shadow.

mod claims;

use adumbra::tree::morton;
use adumbra_lab::page::{Body, Table};
use serde_json::Value;

use super::super::page::{Seen, number, rows, text};
use super::{Realised, Show, Verdict};

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
        ("figure 2-1", Show::Nothing("a drawing of light, blocker and shade, with nothing to measure")),
        ("figure 3-1", Show::Nothing("a drawing; table 3-1 holds its numbers")),
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
        ("A leaf's eight children", |_| Verdict::Realised("`--lossy` leaves leaves alone")),
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
                "two bits tell inner nodes, leaves and masks apart; an index has 31 bits (`spec/adumbra-tree.md`)",
            )
        }),
        ("A bias suppresses", claims::bias_beside_acne),
        ("PCF of 3 × 3 × 3 asks", |_| {
            Verdict::Realised("`--filter 3`; taps behind the receiver's plane are left out")
        }),
        ("3 × 3 × 3 and 5 × 5 × 5 soften", |_| {
            Verdict::Realised("`--filter 3` and `5`: figure 4-5 below")
        }),
        ("Shadows are good", claims::good_shadows),
        ("On the landscape CSM", claims::beside_cascades),
        ("A moving ball", |_| Verdict::Realised("`--move sphere`: figure 5-3 below")),
    ],
};

/// Child numbers of a point, outermost first.
fn path(xyz: [u32; 3]) -> String {
    let path: Vec<String> = morton::path(xyz, 3).iter().map(u32::to_string).collect();
    path.join(", ")
}

fn quadtree_path(_: &mut Seen<'_>, body: &mut Body) {
    // In the plane the two bits of x and y are those of an octree's child without z.
    let plane: Vec<String> =
        morton::path([5, 3, 0], 3).iter().map(|child| (child >> 1).to_string()).collect();
    body.paragraph(&format!("Ours, by `adumbra::tree::morton`: {}.", plane.join(", ")));
}

fn octree_path(_: &mut Seen<'_>, body: &mut Body) {
    body.paragraph(&format!(
        "Ours, by `adumbra::tree::morton`: {}; and back: {:?}.",
        path([5, 3, 5]),
        morton::voxel(&[5, 2, 7])
    ));
}

/// Pixels of one picture of the benchmark's sheets: three in a row, two rows.
const CELL: [u32; 2] = [480, 320];
/// What stands where on a sheet.
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

/// Two pictures of a sheet.
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
        "Ours: simple solids, `adumbra generate primitives`, shadows by rays",
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
        "Ours: low-poly terrain with trees, rocks and houses, `adumbra generate landscape`, shadows by rays",
        body,
    );
    seen.made_by(SECTION, "others", body);
}

fn shares(document: &Value, caption: &str, what: &str, whole: &str) -> Table {
    let mut table = Table::new(caption, &["scene", "depth", "before, MB", "after, MB", "% left"]);
    for row in rows(document, "/reductions/rows") {
        let [before, after] = [whole, what].map(|key| number(row, key));
        table.row([
            text(row, "scene").to_owned(),
            row["depth"].to_string(),
            format!("{:.3}", before / 1e6),
            format!("{:.3}", after / 1e6),
            format!("{:.2}", 100.0 * after / before),
        ]);
    }
    table
}

const MERGED: &str = "/merged_bytes";
const COMPLETE: &str = "/complete_bytes";
const SHARED: &str = "/graph_bytes";

fn merging(seen: &mut Seen<'_>, body: &mut Body) {
    let alt = "Percent of the complete tree left by upward merging, and percent of that left by sharing, by depth, a line a scene";
    seen.plot(
        SECTION,
        "tree/tree-merging.svg",
        alt,
        "Ours: left after upward merging, and, for figure 3-5, after sharing by hash",
        body,
    );
    let document = seen.data.json(FILE).unwrap_or_default();
    body.table(&shares(
        &document,
        "Ours: words of the complete tree, and with equal children collapsed",
        MERGED,
        COMPLETE,
    ));
    seen.made_by(SECTION, "reductions", body);
}

fn hashing(seen: &mut Seen<'_>, body: &mut Body) {
    let document = seen.data.json(FILE).unwrap_or_default();
    body.table(&shares(
        &document,
        "Ours: words of the merged tree, and with equal subtrees stored once",
        SHARED,
        MERGED,
    ));
    let alt = "Seconds and bytes of merging by hash over those of sorting, by depth";
    seen.plot(SECTION, "tree/tree-reductions.svg", alt, "Ours: hashing beside sorting", body);
    seen.made_by(SECTION, "reductions", body);
}

fn closed_regions(seen: &mut Seen<'_>, body: &mut Body) {
    let file = |what: &str| format!("tree/tree-nodes-primitives-{what}.png");
    let caption = "Ours: a layer of the tree from above at depth 8, a square a leaf, coloured by size, dark where shadowed";
    let (open, closed) = (file("open"), file("closed"));
    seen.pair(SECTION, (&open, "all defined"), (&closed, "insides free"), caption, body);
    let document = seen.data.json(FILE).unwrap_or_default();
    let mut table =
        Table::new("Ours: bytes at depth 10", &["scene", "all defined, MB", "insides free, MB", "% left"]);
    for (scene, open, closed) in closed_bytes(&document) {
        table.row([
            scene,
            format!("{:.3}", open / 1e6),
            format!("{:.3}", closed / 1e6),
            format!("{:.0}", 100.0 * closed / open),
        ]);
    }
    body.table(&table);
    body.paragraph("What is closed comes from the winding of the triangles, not from colliders, which the paper itself calls the wrong way.");
    seen.made_by(SECTION, "others", body);
}

/// By scene: bytes with everything defined, and with insides free.
fn closed_bytes(document: &Value) -> Vec<(String, f64, f64)> {
    let all = rows(document, "/frames/rows/closed_regions");
    let bytes = |scene: &str, closed: bool| {
        all.iter()
            .find(|r| text(r, "scene") == scene && r["closed_regions"] == closed)
            .map(|r| number(r, SHARED))
    };
    let open = all.iter().filter(|r| r["closed_regions"] == false).map(|r| text(r, "scene"));
    open.filter_map(|s| Some((s.to_owned(), bytes(s, false)?, bytes(s, true)?))).collect()
}

fn builders(seen: &mut Seen<'_>, body: &mut Body) {
    let alt = "Seconds of three builders, a group of bars a scene, and seconds of the pooled one over those of recursion by depth";
    seen.plot(
        SECTION,
        "tree/tree-builders.svg",
        alt,
        "Ours: seconds at the smallest depth, and the pooled builder's by recursion's",
        body,
    );
    let document = seen.data.json(FILE).unwrap_or_default();
    let mut table = Table::new(
        "Ours: seconds to build and reduce, one thread",
        &["scene", "depth", "recursive", "iterative", "iterative, pooled", "pooled by recursive"],
    );
    for row in rows(&document, "/builders/rows") {
        let [recursive, iterative, pooled] = seconds(row);
        let cells = [recursive, iterative, pooled].map(|s| format!("{s:.3}"));
        let head = [text(row, "scene").to_owned(), row["depth"].to_string()];
        table.row(head.into_iter().chain(cells).chain([format!("{:.2}", pooled / recursive)]));
    }
    body.table(&table);
    body.paragraph(
        "The paper's builders run in C#, where each frame on the heap is an object to collect. Here a frame costs an \
         allocation at most, so the three lie close.",
    );
    seen.made_by(SECTION, "builders", body);
}

fn seconds(row: &Value) -> [f64; 3] {
    ["recursive", "iterative", "pooled"].map(|b| number(row, &format!("/seconds/{b}")))
}

fn nothing_done(seen: &mut Seen<'_>, body: &mut Body) {
    pair(seen, "primitives", NONE, RAYS, "Ours: simple solids at depth 8, coarse so that voxels show", body);
    seen.made_by(SECTION, "others", body);
}

fn acne(seen: &mut Seen<'_>, body: &mut Body) {
    pair(seen, "landscape", NONE, RAYS, "Ours: the landscape at depth 10", body);
    counts(seen, body);
}

fn counts(seen: &mut Seen<'_>, body: &mut Body) {
    let document = seen.data.json(FILE).unwrap_or_default();
    let mut table = Table::new(
        "Ours: wrong answers at points on surfaces, depth 10, %",
        &["scene", "look-up", "lit called shadowed", "shadowed called lit"],
    );
    for row in rows(&document, "/filters/rows") {
        let percent = |key| format!("{:.3}", 100.0 * number(row, key));
        table.row([
            text(row, "scene").to_owned(),
            text(row, "look_up").to_owned(),
            percent("/acne"),
            percent("/leak"),
        ]);
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
        "Ours: a part of figure 4-3, where a voxel is a step of the shadow's outline",
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
        "Ours (a): simple solids, at depth 8 in place of 11, so that differences show",
        body,
    );
    pair(seen, "landscape", BOTH, RAYS, "Ours (b): the landscape at depth 10", body);
    pair(
        seen,
        "landscape-grazing",
        BOTH,
        RAYS,
        "Ours: the landscape under a sun at 8°, where the paper sees flaws",
        body,
    );
    let document = seen.data.json(FILE).unwrap_or_default();
    let mut table = Table::new(
        "Ours: agreement with rays, %",
        &["scene", "depth", "all points", "two voxels from outlines", "MB"],
    );
    for row in rows(&document, "/frames/rows/frames").iter().filter(|r| text(r, "frame") == "world") {
        table.row([
            text(row, "scene").to_owned(),
            row["depth"].to_string(),
            format!("{:.3}", 100.0 * number(row, "/agreement")),
            format!("{:.3}", 100.0 * number(row, "/interior_agreement")),
            format!("{:.2}", number(row, "/bytes") / 1e6),
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
    let document = seen.data.json(PATH).unwrap_or_default();
    let mut table = Table::new(
        "Ours: milliseconds over the path",
        &["technique", "median", "least", "most", "of it depth passes"],
    );
    for row in rows(&document, "/path/techniques") {
        let mut times = numbers(row, "/gpu_ms");
        times.sort_by(f64::total_cmp);
        let mut depth = numbers(row, "/depth_ms");
        depth.sort_by(f64::total_cmp);
        let at = |v: &[f64], i: usize| v.get(i).map_or_else(String::new, |ms| format!("{ms:.2}"));
        table.row([
            format!("`{}`", text(row, "name")),
            at(&times, times.len() / 2),
            at(&times, 0),
            at(&times, times.len().saturating_sub(1)),
            at(&depth, depth.len() / 2),
        ]);
    }
    body.table(&table);
    seen.made_by("shadows", "path", body);
}

fn numbers(row: &Value, key: &str) -> Vec<f64> {
    rows(row, key).iter().filter_map(Value::as_f64).collect()
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
            "Ours: a ball rolls from the sun into a shadow and receives it from the baked file",
            body,
        );
    }
    seen.made_by("shadows", "ball", body);
}
