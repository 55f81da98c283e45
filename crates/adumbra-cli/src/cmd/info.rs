//! `adumbra info`: what a shadow file holds.

use adumbra::format::{AnyFile, ShadowFile, TreeBody, TreeFile};
use serde_json::json;

use super::{GraphFigures, print_json};
use crate::args::Info;
use crate::exit::{Code, Outcome};
use crate::output::bytes_words;

pub(crate) fn run(args: &Info) -> Outcome {
    match AnyFile::read(&args.file)? {
        AnyFile::Light(file) => light(args, &file),
        AnyFile::Tree(file) => {
            tree(args, &file);
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
        print_json(&json!({
            "file": args.file.display().to_string(),
            "file_bytes": figures.file_bytes,
            "bits_per_texel": figures.bits_per_texel,
            "layout": layout,
            "nodes": made_of.nodes,
            "slabs": made_of.slabs,
            "times_smaller": times_smaller,
            "top_bytes": made_of.top_bytes,
            "node_bytes": made_of.header_bytes + made_of.pointer_bytes,
            "header_bytes": made_of.header_bytes,
            "pointer_bytes": made_of.pointer_bytes,
            "slab_bytes": made_of.slab_bytes,
            "size": size,
            "root_level": file.body.root_level(),
            "top_dims": file.body.top_dims(),
            "voxel_size": file.grid.voxel_size,
            "sun": file.grid.sun.towards(),
            "settings": s,
        }));
    } else {
        let sun = file.grid.sun.towards();
        say!("{}: {}", args.file.display(), bytes_words(figures.file_bytes));
        say!("  sun towards     {:.6}, {:.6}, {:.6}", sun[0], sun[1], sun[2]);
        say!("  resolution      {}, {:?} voxels of {:.6}", s.resolution, size, file.grid.voxel_size);
        say!(
            "  bits per texel  {:.4} ({times_smaller:.0} times smaller than 32 bits)",
            figures.bits_per_texel
        );
        say!("  layout          {}", layout.name());
        say!("  nodes, slabs    {}, {}", made_of.nodes, made_of.slabs);
        say!(
            "  bytes           top grid {}, headers {}, pointers {}, slabs {}",
            made_of.top_bytes,
            made_of.header_bytes,
            made_of.pointer_bytes,
            made_of.slab_bytes
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
        say!(
            "  bias            constant {}, slope {}, normal {} texels",
            s.bias.constant_texels,
            s.bias.slope_texels,
            s.bias.normal_offset_texels
        );
    }
    Ok(Code::Fine)
}

fn tree(args: &Info, file: &TreeFile) {
    let (space, settings) = (&file.space, &file.settings);
    // Inner nodes, which both bodies have: a block of eight words is one node's children.
    let (kind, body_bytes, nodes) = match &file.body {
        TreeBody::Words(tree) => ("words", tree.bytes(), tree.words().len() as u64 / 8),
        TreeBody::Symmetric(tree) => ("symmetric", tree.bytes().len() as u64, tree.node_count()),
    };
    let file_bytes = file.encoded_len();
    if args.json {
        print_json(&json!({
            "file": args.file.display().to_string(),
            "frame": "world",
            "file_bytes": file_bytes,
            "body": kind,
            "body_bytes": body_bytes,
            "nodes": nodes,
            "attribute": file.attribute_kind,
            "attribute_bytes": file.attribute.len(),
            "depth": space.depth,
            "voxel_size": space.voxel_size,
            "p_min": space.p_min,
            "sun": file.sun.towards(),
            "regions": file.regions,
            "settings": settings,
        }));
        return;
    }
    let sun = file.sun.towards();
    say!("{}: {}, world-aligned", args.file.display(), bytes_words(file_bytes));
    say!("  sun towards     {:.6}, {:.6}, {:.6}", sun[0], sun[1], sun[2]);
    say!(
        "  depth           {} ({} voxels of {:.6} a side)",
        space.depth,
        space.side_voxels(),
        space.voxel_size
    );
    say!("  cube from       {:.3}, {:.3}, {:.3}", space.p_min[0], space.p_min[1], space.p_min[2]);
    say!("  body            {kind}, {} in {nodes} inner nodes", bytes_words(body_bytes));
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
        say!("  attribute       {kind:?}, {}", bytes_words(file.attribute.len() as u64));
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
}
