//! `adumbra-lab dag info`: what a graph file contains.

use adumbra::{FileSettings, Frame};
use adumbra_papers::dag::{DagFile, DagLayout};
use adumbra_program::exit::{Code, Failure, Outcome};
use adumbra_program::output::{format_bytes, print_json};
use adumbra_program::say;
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::DagInfo;
use crate::mirrors;

/// What a graph file contains.
#[derive(Serialize, JsonSchema)]
pub(crate) struct DagContents {
    /// The graph file.
    file: String,
    /// Length of the file, in bytes.
    file_bytes: u64,
    /// Bits of the file per texel of its grid.
    bits_per_texel: f64,
    /// How the file stores the graph.
    #[schemars(with = "mirrors::DagLayout")]
    layout: DagLayout,
    /// How the grid lies in the world.
    #[schemars(with = "adumbra_program::mirrors::Frame")]
    frame: Frame,
    /// Number of nodes of the graph.
    nodes: u64,
    /// Number of leaf masks and planes of 64 bits, wherever the file stores them.
    leaf_masks: u64,
    /// Bytes of the top grid.
    top_bytes: u64,
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
    #[schemars(with = "adumbra_program::mirrors::FileSettings")]
    settings: FileSettings,
}

pub(super) fn run(args: &DagInfo) -> Outcome {
    let file = DagFile::read(&args.file)?;
    let (grid, body, file_bytes) = (&file.grid, &file.body, file.encoded_len());
    let made_of = body.composition().map_err(|e| Failure::BadInput(e.to_string()))?;
    let (size, root_level, top_dims) = body.space();
    let contents = DagContents {
        file: args.file.display().to_string(),
        file_bytes,
        bits_per_texel: file_bytes as f64 * 8.0 / (f64::from(size[0]) * f64::from(size[1])),
        layout: body.layout(),
        frame: grid.frame,
        nodes: made_of.nodes,
        leaf_masks: made_of.leaf_masks,
        top_bytes: made_of.top_bytes,
        header_bytes: made_of.header_bytes,
        pointer_bytes: made_of.pointer_bytes,
        leaf_mask_bytes: made_of.leaf_mask_bytes,
        size,
        root_level,
        top_dims,
        voxel_size: grid.voxel_size,
        sun: grid.sun.towards(),
        settings: file.settings,
    };
    if args.json {
        print_json(&contents)?;
        return Ok(Code::Fine);
    }
    let c = &contents;
    say!("{}: {}, {} graph", c.file, format_bytes(file_bytes), c.layout.name());
    say!("  sun towards     {:.6}, {:.6}, {:.6}", c.sun[0], c.sun[1], c.sun[2]);
    say!("  resolution      {}, {size:?} voxels of {:.6}", c.settings.resolution, c.voxel_size);
    say!("  bits per texel  {:.4}", c.bits_per_texel);
    say!("  frame           {}", c.frame.name());
    say!("  nodes, leaf masks    {}, {}", c.nodes, c.leaf_masks);
    say!(
        "  bytes           top grid {}, headers {}, pointers {}, leaf masks {}",
        c.top_bytes,
        c.header_bytes,
        c.pointer_bytes,
        c.leaf_mask_bytes
    );
    Ok(Code::Fine)
}
