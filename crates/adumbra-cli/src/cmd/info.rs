//! `adumbra info`: what a shadow file holds.

use adumbra::format::ShadowFile;
use serde_json::json;

use super::{GraphFigures, print_json};
use crate::args::Info;
use crate::exit::{Code, Outcome};
use crate::output::bytes_words;

pub(crate) fn run(args: &Info) -> Outcome {
    let file = ShadowFile::read(&args.file)?;
    let figures = GraphFigures::of(&file);
    let s = &file.settings;
    let dag = &file.dag;
    let raw = f64::from(dag.size[0]) * f64::from(dag.size[1]) * 4.0;
    let times_smaller = raw / figures.file_bytes as f64;
    if args.json {
        print_json(&json!({
            "file": args.file.display().to_string(),
            "file_bytes": figures.file_bytes,
            "bits_per_texel": figures.bits_per_texel,
            "nodes": figures.nodes,
            "slabs": figures.slabs,
            "times_smaller": times_smaller,
            "top_bytes": dag.top.len() * 4,
            "node_bytes": dag.nodes.len() * 4,
            "slab_bytes": dag.slabs.len() * 8,
            "size": dag.size,
            "root_level": dag.root_level,
            "top_dims": dag.top_dims,
            "voxel_size": file.grid.voxel_size,
            "sun": file.grid.sun.towards(),
            "settings": s,
        }));
    } else {
        let sun = file.grid.sun.towards();
        say!("{}: {}", args.file.display(), bytes_words(figures.file_bytes));
        say!("  sun towards     {:.6}, {:.6}, {:.6}", sun[0], sun[1], sun[2]);
        say!("  resolution      {}, {:?} voxels of {:.6}", s.resolution, dag.size, file.grid.voxel_size);
        say!(
            "  bits per texel  {:.4} ({times_smaller:.0} times smaller than 32 bits)",
            figures.bits_per_texel
        );
        say!("  nodes, slabs    {}, {}", figures.nodes, figures.slabs);
        say!(
            "  bytes           top grid {}, nodes {}, slabs {}",
            dag.top.len() * 4,
            dag.nodes.len() * 4,
            dag.slabs.len() * 8
        );
        say!("  baked from      {} triangles in {} instances", s.triangles, s.instances);
        say!(
            "  ground assumed {}, closed regions {}, receivers {:?}, thickness {} m, alpha ignored {}",
            s.assume_ground,
            s.closed_regions,
            s.receivers,
            s.thickness_world,
            s.ignore_alpha
        );
        say!(
            "  bias            constant {}, slope {}, normal {} texels",
            s.bias.constant_texels,
            s.bias.slope_texels,
            s.bias.normal_offset_texels
        );
    }
    Ok(Code::Fine)
}
