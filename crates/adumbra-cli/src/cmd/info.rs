//! `adumbra info`: what a shadow file contains.

use adumbra::file::Layout;
use adumbra::{FileSettings, Frame, Receivers, ShadowFile};
use adumbra_program::exit::{Code, Failure, Outcome};
use adumbra_program::output::{format_bytes, print_json};
use adumbra_program::say;
use adumbra_tree::{AnyFile, AttributeKind, Regions, TreeBody, TreeFile, TreeSettings};
use serde::Serialize;

use super::GraphFigures;
use crate::args::Info;

/// A light-aligned file.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct LightInfo {
    /// The shadow file.
    file: String,
    /// Length of the shadow file, in bytes.
    file_bytes: u64,
    /// Bits of the shadow file per texel of its grid.
    bits_per_texel: f64,
    /// How the file stores its shadows.
    layout: Layout,
    /// How the grid lies in the world.
    frame: Frame,
    /// Number of nodes of the graph.
    nodes: u64,
    /// Number of leaf masks and planes of 64 bits, wherever the file stores them.
    leaf_masks: u64,
    /// How many times smaller the file is than a shadow map of the grid's texels with 32 bits per texel.
    times_smaller: f64,
    /// Bytes of the top grid.
    top_bytes: u64,
    /// Bytes of the nodes: headers and pointers.
    node_bytes: u64,
    /// Bytes of the nodes' headers.
    header_bytes: u64,
    /// Bytes of the nodes' pointers.
    pointer_bytes: u64,
    /// Bytes of leaf masks and planes.
    leaf_mask_bytes: u64,
    /// Number of voxels along x, y and z of the grid.
    size: [u32; 3],
    /// Level of the root cubes. A root cube is 2^level voxels wide.
    root_level: u32,
    /// Number of root cubes along x, y and z.
    top_dims: [u32; 3],
    /// Edge of a voxel, world units.
    voxel_size: f64,
    /// Unit vector towards the sun.
    sun: [f64; 3],
    /// The settings of the bake.
    settings: FileSettings,
}

/// A world-aligned file.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct TreeInfo {
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
    /// The attribute that the file stores for each voxel of a leaf, next to the tree. Null without an attribute.
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
    regions: Regions,
    /// The settings of the bake.
    settings: TreeSettings,
}

pub(crate) fn run(args: &Info) -> Outcome {
    match AnyFile::read(&args.file)? {
        AnyFile::Light(file) => light(args, &file),
        AnyFile::Tree(file) => {
            tree(args, &file)?;
            Ok(Code::Fine)
        }
    }
}

fn light(args: &Info, file: &ShadowFile) -> Outcome {
    let figures = GraphFigures::of(file, file.encoded_len())?;
    let s = &file.settings;
    let (size, layout, made_of) = (file.grid.size, file.body.layout(), &figures.composition);
    let raw = f64::from(size[0]) * f64::from(size[1]) * 4.0;
    let times_smaller = raw / figures.file_bytes as f64;
    if args.json {
        print_json(&LightInfo {
            file: args.file.display().to_string(),
            file_bytes: figures.file_bytes,
            bits_per_texel: figures.bits_per_texel,
            layout,
            frame: file.grid.frame,
            nodes: made_of.nodes,
            leaf_masks: made_of.leaf_masks,
            times_smaller,
            top_bytes: made_of.top_bytes,
            node_bytes: made_of.header_bytes + made_of.pointer_bytes,
            header_bytes: made_of.header_bytes,
            pointer_bytes: made_of.pointer_bytes,
            leaf_mask_bytes: made_of.leaf_mask_bytes,
            size,
            root_level: file.body.root_level(),
            top_dims: file.body.top_dims(),
            voxel_size: file.grid.voxel_size,
            sun: file.grid.sun.towards(),
            settings: *s,
        })?;
    } else {
        let sun = file.grid.sun.towards();
        say!("{}: {}", args.file.display(), format_bytes(figures.file_bytes));
        say!("  sun towards     {:.6}, {:.6}, {:.6}", sun[0], sun[1], sun[2]);
        say!("  resolution      {}, {:?} voxels of {:.6}", s.resolution, size, file.grid.voxel_size);
        say!(
            "  bits per texel  {:.4} ({times_smaller:.0} times smaller than 32 bits)",
            figures.bits_per_texel
        );
        say!("  layout          {}", layout.name());
        match file.grid.frame {
            Frame::Light => say!("  frame           light"),
            Frame::Oblique { yaw_radians } => {
                say!("  frame           oblique, x turned by {:.4}° from +X to +Z", yaw_radians.to_degrees());
            }
        }
        say!("  nodes, leaf masks    {}, {}", made_of.nodes, made_of.leaf_masks);
        say!(
            "  bytes           top grid {}, headers {}, pointers {}, leaf masks {}",
            made_of.top_bytes,
            made_of.header_bytes,
            made_of.pointer_bytes,
            made_of.leaf_mask_bytes
        );
        say!("  baked from      {} triangles in {} instances", s.triangles, s.instances);
        say!(
            "  ground assumed {}, closed regions {}, receivers {:?}, thickness {} m, switch within {} voxels, alpha ignored {}",
            s.assume_ground,
            s.closed_regions,
            s.receivers,
            s.thickness_world,
            s.switch_within_voxels,
            s.ignore_alpha
        );
        if s.receivers == Receivers::Static {
            say!("  static receivers: what moves and receives this file is wrong in 1 to 3 % of its points");
        }
        say!(
            "  bias            constant {}, slope {}, normal {} texels",
            s.bias.constant_texels,
            s.bias.slope_texels,
            s.bias.normal_offset_texels
        );
    }
    Ok(Code::Fine)
}

fn tree(args: &Info, file: &TreeFile) -> Result<(), Failure> {
    let (space, settings) = (&file.space, &file.settings);
    // Both kinds of body have inner nodes. In the words, a block of eight holds the children of one node.
    let (kind, body_bytes, nodes) = match &file.body {
        TreeBody::Words(tree) => ("words", tree.bytes(), tree.words().len() as u64 / 8),
        TreeBody::Symmetric(tree) => ("symmetric", tree.bytes().len() as u64, tree.node_count()),
    };
    let file_bytes = file.encoded_len();
    if args.json {
        return print_json(&TreeInfo {
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
        });
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
    Ok(())
}
