//! `adumbra info`: what a shadow file contains.

use adumbra::{FileSettings, Frame, Receivers, ShadowFile};
use adumbra_program::exit::{Code, Outcome};
use adumbra_program::output::{format_bytes, print_json};
use adumbra_program::{mirrors, say};
use schemars::JsonSchema;
use serde::Serialize;

use super::FileFigures;
use crate::args::Info;

/// What a shadow file contains.
#[derive(Serialize, JsonSchema)]
pub(super) struct FileInfo {
    /// The shadow file.
    file: String,
    /// Length of the shadow file, in bytes.
    file_bytes: u64,
    /// Bits of the shadow file per texel of its grid.
    bits_per_texel: f64,
    /// How the grid lies in the world.
    #[schemars(with = "mirrors::Frame")]
    frame: Frame,
    /// Number of nodes of the quadtree.
    nodes: u64,
    /// Number of planes of 64 bits.
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
    /// Bytes of leaves: depths and planes.
    leaf_mask_bytes: u64,
    /// Number of voxels along x, y and z of the grid.
    size: [u32; 3],
    /// Level of the roots. A root is 2^level columns wide.
    root_level: u32,
    /// Number of roots along x and y.
    top_dims: [u32; 2],
    /// Edge of a voxel, world units.
    voxel_size: f64,
    /// Unit vector towards the sun.
    sun: [f64; 3],
    /// The settings of the bake.
    #[schemars(with = "mirrors::FileSettings")]
    settings: FileSettings,
}

pub(crate) fn run(args: &Info) -> Outcome {
    let file = &ShadowFile::read(&args.file)?;
    let figures = FileFigures::of(file, file.encoded_len());
    let s = &file.settings;
    let (size, made_of) = (file.grid.size, &figures.composition);
    let raw = f64::from(size[0]) * f64::from(size[1]) * 4.0;
    let times_smaller = raw / figures.file_bytes as f64;
    if args.json {
        print_json(&FileInfo {
            file: args.file.display().to_string(),
            file_bytes: figures.file_bytes,
            bits_per_texel: figures.bits_per_texel,
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
            root_level: file.tree.root_level,
            top_dims: file.tree.top_dims,
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
