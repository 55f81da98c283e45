//! `adumbra bake --frame world`: scene in, world-aligned tree out.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use adumbra::Error;
use adumbra::bake::Progress;
use adumbra::format::{AttributeKind, TreeBody, TreeFile};
use adumbra::scene::Scene;
use adumbra::tree::lossy;
use adumbra::tree::symmetric::SymmetricTree;
use adumbra::tree::{BakedTree, PreparedTree, TreeOptions, TreeProgress, leaf_voxels};
use serde_json::{Value, json};

use super::print_json;
use crate::args::Bake;
use crate::exit::{Code, Failure, Outcome};
use crate::memory;
use crate::output::bytes_words;
use crate::progress::{Reporter, Units};

/// What options beside the plain tree made of it.
struct Extras {
    plain_bytes: u64,
    body_bytes: u64,
    figures: Vec<(&'static str, Value)>,
    sentences: Vec<String>,
}

/// Bakes to a path. `start` is when the program began to load the scene.
pub(super) fn run(
    args: &Bake,
    scene: &Scene,
    options: &TreeOptions,
    empty_bounds: bool,
    (output, start): (&Path, Instant),
    cancel: &AtomicBool,
) -> Outcome {
    let prepared = PreparedTree::new(scene, options, cancel)?;
    let reporter = Reporter::new(args.progress, Units::VOXELS);
    let baked = prepared.build(options, &|p| reporter.update(cubes(p)), cancel)?;
    let report = baked.report;
    let (file, extras) = finish(args, prepared, options, baked, cancel)?;
    let file_bytes = file.write(output)?;
    let seconds = start.elapsed().as_secs_f64();
    let peak = memory::peak_bytes().unwrap_or(report.image_bytes + report.held_bytes);
    if args.json {
        let mut object = json!({
            "file": output.display().to_string(),
            "frame": "world",
            "seconds": seconds,
            "peak_bytes": peak,
            "file_bytes": file_bytes,
            "tree_bytes": extras.plain_bytes,
            "body_bytes": extras.body_bytes,
            "depth": file.space.depth,
            "voxel_size": file.space.voxel_size,
            "regions": file.regions.list.len(),
            "builder": options.builder,
            "reduction": options.reduction,
            "pruned": options.prune,
            "report": report,
            "triangles": file.settings.triangles,
            "empty_bounds": empty_bounds,
        });
        for (key, value) in extras.figures {
            object[key] = value;
        }
        print_json(&object);
    } else {
        say!(
            "{} -> {} ({}, depth {}, voxels of {:.4}) in {seconds:.1} s, peak memory {}",
            args.scene.display(),
            output.display(),
            bytes_words(file_bytes),
            file.space.depth,
            file.space.voxel_size,
            bytes_words(peak)
        );
        for sentence in extras.sentences {
            say!("  {sentence}");
        }
    }
    Ok(Code::Fine)
}

/// Progress in cubes of the same size, as many as a bar can show.
fn cubes(p: TreeProgress) -> Progress {
    const CUBES: usize = 512;
    Progress {
        done_tiles: (p.done_share * CUBES as f64) as usize,
        total_tiles: CUBES,
        texels_per_tile: p.voxels / CUBES as u64,
        graph_bytes: p.tree_bytes,
    }
}

/// The file, with what `--lossy`, `--symmetry` and `--attribute` ask for.
fn finish(
    args: &Bake,
    prepared: PreparedTree,
    options: &TreeOptions,
    baked: BakedTree,
    cancel: &AtomicBool,
) -> Result<(TreeFile, Extras), Failure> {
    let go_on = || if cancel.load(Ordering::Relaxed) { Err(Error::Interrupted) } else { Ok(()) };
    let wants_attribute = args.settings.tree.attribute.is_some();
    // The depth images are of no more use, and may be large.
    let prepared = wants_attribute.then_some(prepared);
    let BakedTree { space, regions, mut settings, mut tree, report } = baked;
    let mut extras =
        Extras { plain_bytes: tree.bytes(), body_bytes: 0, figures: Vec::new(), sentences: Vec::new() };
    if let Some(collisions) = report.collisions {
        extras.figures.push(("collisions", json!(collisions)));
        extras
            .sentences
            .push(format!("tree hash: {collisions} comparisons of different subtrees with one hash"));
    }
    if let Some(share) = args.settings.tree.lossy {
        go_on()?;
        // About what a round holds beside the tree: its blocks twice, and lists of similar ones.
        args.work.check_memory("merging similar subtrees", 6 * tree.bytes())?;
        let merged = lossy::merge_similar(&tree, share)?;
        settings.lossy = Some(merged.change);
        let change = merged.change;
        let changed_share = change.changed_voxels as f64 / change.leaf_voxels.max(1) as f64;
        extras.figures.push(("changed_voxels", json!(change.changed_voxels)));
        extras.figures.push(("leaf_voxels", json!(change.leaf_voxels)));
        extras.sentences.push(format!(
            "lossy: {} of {} border voxels changed ({:.3} %), {} -> {}",
            change.changed_voxels,
            change.leaf_voxels,
            100.0 * changed_share,
            bytes_words(tree.bytes()),
            bytes_words(merged.tree.bytes())
        ));
        tree = merged.tree;
    }
    let (mut attribute, mut attribute_kind) = (Vec::new(), None);
    if let Some(prepared) = prepared {
        go_on()?;
        args.work.check_memory("the penumbra's widths", 2 * tree.bytes() + leaf_voxels(&tree))?;
        attribute = prepared.penumbra(&tree)?;
        attribute_kind = (!attribute.is_empty()).then_some(AttributeKind::Penumbra);
        extras.figures.push(("attribute_bytes", json!(attribute.len())));
        extras.sentences.push(format!("penumbra: {} beside the tree", bytes_words(attribute.len() as u64)));
    }
    let body = if args.settings.tree.symmetry {
        go_on()?;
        args.work.check_memory("the symmetric trees", 4 * tree.bytes())?;
        // Mirrors share more nodes but widen pointers: which wins depends on the scene.
        let [narrow, mirrored] = [SymmetricTree::of(&tree, false)?, SymmetricTree::of(&tree, true)?];
        let bytes = [&narrow, &mirrored].map(|t| t.bytes().len() as u64);
        let mirrors = bytes[1] < bytes[0];
        extras.body_bytes = bytes[0].min(bytes[1]);
        extras.figures.push(("bytes_without_mirrors", json!(bytes[0])));
        extras.figures.push(("bytes_with_mirrors", json!(bytes[1])));
        extras.sentences.push(format!(
            "symmetry: {} -> {} with variable-width pointers, {} with mirrors too; the smaller is kept",
            bytes_words(tree.bytes()),
            bytes_words(bytes[0]),
            bytes_words(bytes[1])
        ));
        let symmetric = if mirrors { mirrored } else { narrow };
        TreeBody::Symmetric(symmetric)
    } else {
        extras.body_bytes = tree.bytes();
        TreeBody::Words(tree)
    };
    let file = TreeFile { space, sun: options.sun, settings, regions, body, attribute, attribute_kind };
    Ok((file, extras))
}
