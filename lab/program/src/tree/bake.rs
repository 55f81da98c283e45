//! `adumbra-lab tree bake`: bakes a scene into a world-aligned tree.

use std::path::Path;
use std::time::Instant;

use adumbra_bake::{Progress, Watch};
use adumbra_files::{check_output, replace_file};
use adumbra_papers::tree::symmetric::SymmetricTree;
use adumbra_papers::tree::{
    AttributeKind, BakedTree, PreparedTree, Reduction, TreeBody, TreeBuilder, TreeFile, TreeOptions,
    TreeProgress, TreeReport, leaf_voxels, lossy,
};
use adumbra_program::exit::{Code, Failure, Outcome};
use adumbra_program::memory::{Guard, Share};
use adumbra_program::output::{SCENE, format_bytes, print_json, refuse_inputs, refuse_read};
use adumbra_program::progress::{Reporter, Units};
use adumbra_program::scene::{Omitted, load_scene_within, omitted};
use adumbra_program::sun::{ChosenSun, SunOrigin, warn_of_low_sun};
use adumbra_program::threads::with_threads;
use adumbra_program::{bounds, memory, say};
use adumbra_scene::Scene;
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::TreeBake;
use crate::mirrors;

/// The result of a bake of a world-aligned tree.
#[derive(Serialize, JsonSchema)]
pub(crate) struct TreeBaked {
    /// The shadow file that was written.
    file: String,
    /// Always `world`.
    frame: &'static str,
    /// Total wall time: loading, baking and writing.
    seconds: f64,
    /// The largest resident size of the process. If the system does not report it, what the bake counted.
    peak_bytes: u64,
    /// Length of the shadow file, in bytes.
    file_bytes: u64,
    /// Bytes of the plain tree's words.
    tree_bytes: u64,
    /// Bytes of the body that was written, after `--lossy` and `--symmetry`.
    body_bytes: u64,
    /// Levels of the deepest part of the tree.
    depth: u32,
    /// Edge of a voxel of the deepest level, world units.
    voxel_size: f64,
    /// Number of regions that have a depth of their own.
    regions: usize,
    /// Which builder built the tree. The file does not depend on it.
    #[schemars(with = "mirrors::TreeBuilder")]
    builder: TreeBuilder,
    /// How equal subtrees were found. The file does not depend on it.
    #[schemars(with = "mirrors::Reduction")]
    reduction: Reduction,
    /// Whether cubes that the pyramid decides were skipped. The file does not depend on it.
    pruned: bool,
    /// Report of the bake.
    #[schemars(with = "mirrors::TreeReport")]
    report: TreeReport,
    /// Number of triangles that were baked. Instances are counted.
    triangles: u64,
    /// Unit vector towards the sun.
    sun: [f64; 3],
    /// Where the sun comes from.
    sun_origin: SunOrigin,
    /// What the scene's file holds and the loader left out, each kind once.
    omissions: Vec<Omitted>,
    /// Whether `--bounds` were given and contain no part of the scene.
    empty_bounds: bool,
    #[serde(flatten)]
    extras: ExtraFigures,
}

/// Fields that are added by options beyond the plain tree.
#[derive(Default, Serialize, JsonSchema)]
struct ExtraFigures {
    /// With `--reduction tree-hash`: comparisons of different subtrees with one hash.
    #[serde(skip_serializing_if = "Option::is_none")]
    collisions: Option<u64>,
    /// With `--lossy`: number of voxels of the finest level that changed.
    #[serde(skip_serializing_if = "Option::is_none")]
    changed_voxels: Option<u64>,
    /// With `--lossy`: number of voxels at the borders of shadows, the only ones that may change.
    #[serde(skip_serializing_if = "Option::is_none")]
    leaf_voxels: Option<u64>,
    /// With `--attribute`: bytes of the attribute.
    #[serde(skip_serializing_if = "Option::is_none")]
    attribute_bytes: Option<usize>,
    /// With `--symmetry`: bytes of the encoding without mirrored subtrees. The smaller encoding is written.
    #[serde(skip_serializing_if = "Option::is_none")]
    bytes_without_mirrors: Option<u64>,
    /// With `--symmetry`: bytes of the encoding with mirrored subtrees. The smaller encoding is written.
    #[serde(skip_serializing_if = "Option::is_none")]
    bytes_with_mirrors: Option<u64>,
}

/// Results of options beyond the plain tree.
struct Extras {
    plain_bytes: u64,
    body_bytes: u64,
    figures: ExtraFigures,
    sentences: Vec<String>,
}

/// Bakes and writes the tree.
pub(super) fn run(args: &TreeBake) -> Outcome {
    let start = Instant::now();
    let bad_input = |e: Failure| Failure::BadInput(e.to_string());
    let output = args.output.clone().unwrap_or_else(|| args.scene.with_extension("adumtree"));
    // Refuse an invalid sun before loading the scene.
    args.sun.given_for(&args.scene, &args.load)?;
    refuse_inputs("--output", &output, [(SCENE, &*args.scene)]).map_err(bad_input)?;
    check_output(&output)?;
    with_threads(args.run.threads, || {
        let limit = args.run.memory_limit();
        let scene = load_scene_within(limit, &args.scene, &args.load.load_options()?)?;
        let sun = args.sun.choose(&scene, &args.scene)?;
        warn_of_low_sun(&sun.sun);
        let share = limit.share(scene.memory_bytes());
        let options = args.options(sun.sun, share.bytes());
        refuse_read("--output", &output).map_err(bad_input)?;
        let empty_bounds = bounds::warn_if_empty(options.bounds.as_ref(), &scene, &args.scene);
        let guard = Guard::new(limit);
        let job = Job { args, scene: &scene, sun: &sun, empty_bounds, output: &output, start };
        job.run(&options, &guard, &share)
    })?
}

/// A bake of a tree.
struct Job<'a> {
    args: &'a TreeBake,
    scene: &'a Scene,
    sun: &'a ChosenSun,
    empty_bounds: bool,
    /// The tree file to write.
    output: &'a Path,
    /// When the program began to load the scene.
    start: Instant,
}

impl Job<'_> {
    fn run(&self, options: &TreeOptions, guard: &Guard, share: &Share) -> Outcome {
        let Self { args, scene, .. } = *self;
        let prepared = PreparedTree::new(scene, options, guard.cancel());
        let prepared = guard.end("the light's depth images", share, prepared)?;
        let reporter = Reporter::new(args.progress, Units::VOXELS);
        let progress = |p| {
            guard.look();
            reporter.update(cubes(p));
        };
        let baked =
            guard.end("the tree", share, prepared.build(options, Watch::new(&progress, guard.cancel())))?;
        let report = baked.report;
        let finished = finish(args, prepared, baked);
        let (file, extras) = guard.end("the finished tree", share, finished)?;
        self.write(options, report, &file, extras)
    }

    fn write(&self, options: &TreeOptions, report: TreeReport, file: &TreeFile, extras: Extras) -> Outcome {
        let Self { args, scene, sun, empty_bounds, output, start } = *self;
        let file_bytes = replace_file(output, |out| file.write_to(out))?;
        let seconds = start.elapsed().as_secs_f64();
        let peak = memory::peak_bytes().unwrap_or(report.image_bytes + report.held_bytes);
        if args.run.json {
            print_json(&TreeBaked {
                file: output.display().to_string(),
                frame: "world",
                seconds,
                peak_bytes: peak,
                file_bytes,
                tree_bytes: extras.plain_bytes,
                body_bytes: extras.body_bytes,
                depth: file.space.depth,
                voxel_size: file.space.voxel_size,
                regions: file.regions.list.len(),
                builder: options.builder,
                reduction: options.reduction,
                pruned: options.prune,
                report,
                triangles: file.settings.triangles,
                sun: sun.sun.towards(),
                sun_origin: sun.origin.clone(),
                omissions: omitted(scene),
                empty_bounds,
                extras: extras.figures,
            })?;
        } else {
            say!(
                "{} -> {} ({}, depth {}, voxels of {:.4}) in {seconds:.1} s, peak memory {}",
                args.scene.display(),
                output.display(),
                format_bytes(file_bytes),
                file.space.depth,
                file.space.voxel_size,
                format_bytes(peak)
            );
            say!("  {sun}");
            for sentence in extras.sentences {
                say!("  {sentence}");
            }
        }
        Ok(Code::Fine)
    }
}

/// Converts the progress into equal cubes, a number that a bar can show.
fn cubes(p: TreeProgress) -> Progress {
    const CUBES: usize = 512;
    Progress {
        done: (p.done_share * CUBES as f64) as usize,
        total: CUBES,
        texels_per_unit: p.voxels / CUBES as u64,
        result_bytes: p.tree_bytes,
    }
}

/// Builds the file, and applies `--lossy`, `--symmetry` and `--attribute`.
fn finish(args: &TreeBake, prepared: PreparedTree, baked: BakedTree) -> Result<(TreeFile, Extras), Failure> {
    let wants_attribute = args.attribute.is_some();
    // The depth images may be large. They are dropped here unless the attribute needs them.
    let prepared = wants_attribute.then_some(prepared);
    let BakedTree { space, regions, mut settings, sun, mut tree, report } = baked;
    let mut extras = Extras {
        plain_bytes: tree.bytes(),
        body_bytes: 0,
        figures: ExtraFigures::default(),
        sentences: Vec::new(),
    };
    if let Some(collisions) = report.collisions {
        extras.figures.collisions = Some(collisions);
        extras
            .sentences
            .push(format!("tree hash: {collisions} comparisons of different subtrees with the same hash"));
    }
    if let Some(share) = args.lossy {
        // Approximate memory of a round besides the tree: its blocks twice, and lists of similar blocks.
        args.run.check_memory("merging similar subtrees", 0, 6 * tree.bytes())?;
        let merged = lossy::merge_similar(&tree, share)?;
        settings.lossy = Some(merged.change);
        let change = merged.change;
        let changed_share = change.changed_voxels as f64 / change.leaf_voxels.max(1) as f64;
        extras.figures.changed_voxels = Some(change.changed_voxels);
        extras.figures.leaf_voxels = Some(change.leaf_voxels);
        extras.sentences.push(format!(
            "lossy: {} of {} border voxels changed ({:.3} %), {} -> {}",
            change.changed_voxels,
            change.leaf_voxels,
            100.0 * changed_share,
            format_bytes(tree.bytes()),
            format_bytes(merged.tree.bytes())
        ));
        tree = merged.tree;
    }
    let (mut attribute, mut attribute_kind) = (Vec::new(), None);
    if let Some(prepared) = prepared {
        args.run.check_memory("the penumbra's widths", 0, 2 * tree.bytes() + leaf_voxels(&tree))?;
        attribute = prepared.penumbra(&tree)?;
        attribute_kind = (!attribute.is_empty()).then_some(AttributeKind::Penumbra);
        extras.figures.attribute_bytes = Some(attribute.len());
        extras
            .sentences
            .push(format!("penumbra: {} in addition to the tree", format_bytes(attribute.len() as u64)));
    }
    let body = if args.symmetry {
        args.run.check_memory("the symmetric trees", 0, 4 * tree.bytes())?;
        // Mirrors share more nodes but need wider pointers. Which one is smaller depends on the scene.
        let [narrow, mirrored] = [SymmetricTree::of(&tree, false)?, SymmetricTree::of(&tree, true)?];
        let bytes = [&narrow, &mirrored].map(|t| t.bytes().len() as u64);
        let mirrors = bytes[1] < bytes[0];
        extras.body_bytes = bytes[0].min(bytes[1]);
        extras.figures.bytes_without_mirrors = Some(bytes[0]);
        extras.figures.bytes_with_mirrors = Some(bytes[1]);
        extras.sentences.push(format!(
            "symmetry: {} -> {} with variable-width pointers, {} with mirrors too; the smaller is kept",
            format_bytes(tree.bytes()),
            format_bytes(bytes[0]),
            format_bytes(bytes[1])
        ));
        let symmetric = if mirrors { mirrored } else { narrow };
        TreeBody::Symmetric(symmetric)
    } else {
        extras.body_bytes = tree.bytes();
        TreeBody::Words(tree)
    };
    let file = TreeFile { space, sun, settings, regions, body, attribute, attribute_kind };
    Ok((file, extras))
}
