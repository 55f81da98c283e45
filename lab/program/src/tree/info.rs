//! `adumbra-lab tree info`: what a tree file contains.

use adumbra_papers::tree::{AttributeKind, Regions, TreeBody, TreeFile, TreeSettings};
use adumbra_program::exit::{Code, Outcome};
use adumbra_program::output::{format_bytes, print_json};
use adumbra_program::say;
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::TreeInfo;
use crate::mirrors;

/// A world-aligned file.
#[derive(Serialize, JsonSchema)]
pub(crate) struct TreeContents {
    /// The shadow file.
    file: String,
    /// Always `world`.
    frame: &'static str,
    /// Length of the shadow file, in bytes.
    file_bytes: u64,
    /// How the file stores its tree: `words` or `symmetric`.
    body: &'static str,
    /// Bytes of the tree.
    body_bytes: u64,
    /// Number of inner nodes. A shared node counts once.
    nodes: u64,
    /// The attribute that the file stores for each voxel of a leaf, next to the tree. Null without an
    /// attribute.
    #[schemars(with = "Option<mirrors::AttributeKind>")]
    attribute: Option<AttributeKind>,
    /// Bytes of the attribute. 0 if there is none.
    attribute_bytes: usize,
    /// Levels of the deepest part of the tree.
    depth: u32,
    /// Edge of a voxel of the deepest level, world units.
    voxel_size: f64,
    /// Lowest corner of the tree's cube, world units.
    p_min: [f64; 3],
    /// Unit vector towards the sun.
    sun: [f64; 3],
    /// The depth of the tree in each region and elsewhere.
    #[schemars(with = "mirrors::Regions")]
    regions: Regions,
    /// The settings of the bake.
    #[schemars(with = "mirrors::TreeSettings")]
    settings: TreeSettings,
}

pub(super) fn run(args: &TreeInfo) -> Outcome {
    let file = TreeFile::read(&args.file)?;
    let (space, settings) = (&file.space, &file.settings);
    // Both kinds of body have inner nodes. In the words, a block of eight holds the children of one node.
    let (kind, body_bytes, nodes) = match &file.body {
        TreeBody::Words(tree) => ("words", tree.bytes(), tree.words().len() as u64 / 8),
        TreeBody::Symmetric(tree) => ("symmetric", tree.bytes().len() as u64, tree.node_count()),
    };
    let file_bytes = file.encoded_len();
    if args.json {
        print_json(&TreeContents {
            file: args.file.display().to_string(),
            frame: "world",
            file_bytes,
            body: kind,
            body_bytes,
            nodes,
            attribute: file.attribute_kind,
            attribute_bytes: file.attribute.len(),
            depth: space.depth,
            voxel_size: space.voxel_size,
            p_min: space.p_min,
            sun: file.sun.towards(),
            regions: file.regions.clone(),
            settings: *settings,
        })?;
        return Ok(Code::Fine);
    }
    let sun = file.sun.towards();
    say!("{}: {}, world-aligned", args.file.display(), format_bytes(file_bytes));
    say!("  sun towards     {:.6}, {:.6}, {:.6}", sun[0], sun[1], sun[2]);
    say!(
        "  depth           {} ({} voxels per side, edge {:.6})",
        space.depth,
        space.side_voxels(),
        space.voxel_size
    );
    say!("  cube from       {:.3}, {:.3}, {:.3}", space.p_min[0], space.p_min[1], space.p_min[2]);
    say!("  body            {kind}, {} in {nodes} inner nodes", format_bytes(body_bytes));
    if let Some(b) = settings.bounds {
        say!("  bounds          {:?} to {:?}", b.min, b.max);
    }
    for r in &file.regions.list {
        say!("  region          x {} to {}, z {} to {}: depth {}", r.x[0], r.x[1], r.z[0], r.z[1], r.depth);
    }
    if !file.regions.list.is_empty() {
        say!("  elsewhere       depth {}", file.regions.base_depth);
    }
    if let Some(kind) = file.attribute_kind {
        say!("  attribute       {kind:?}, {}", format_bytes(file.attribute.len() as u64));
    }
    if let Some(lossy) = settings.lossy {
        say!(
            "  lossy           {} of {} border voxels changed, at most {} % allowed",
            lossy.changed_voxels,
            lossy.leaf_voxels,
            100.0 * lossy.max_share
        );
    }
    say!("  baked from      {} triangles in {} instances", settings.triangles, settings.instances);
    say!("  closed regions {}, alpha ignored {}", settings.closed_regions, settings.ignore_alpha);
    say!(
        "  bias            constant {}, slope {}, normal {} voxels",
        settings.bias.constant_texels,
        settings.bias.slope_texels,
        settings.bias.normal_offset_texels
    );
    Ok(Code::Fine)
}
