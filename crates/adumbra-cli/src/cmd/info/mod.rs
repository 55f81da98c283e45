//! `adumbra info`: what a shadow file contains.

mod pages;
mod snippet;

use adumbra::file::sections::read_file;
use adumbra::file::{
    BUNDLE_ENTRY_BYTES, BundleEntry, Contents, GRID_BYTES, GridEntry, HEADER_BYTES, Header, Level,
};
use adumbra::{Encoding, Error, FileSettings, Frame, Receivers, Region, ShadowFile};
use adumbra_program::exit::{Code, Failure, Outcome};
use adumbra_program::moment;
use adumbra_program::output::{format_bytes, print_json, refuse_inputs, write_png};
use adumbra_program::threads::with_threads;
use adumbra_program::{mirrors, say};
use schemars::JsonSchema;
use serde::Serialize;

use self::pages::PageBytes;
use super::bits_per_texel;
use super::path::{self, PathInfo};
use super::regions::{self, ManifestInfo};
use crate::args::{Info, LevelArg};

/// What is printed with `--json`.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
pub(super) enum Printed {
    /// Of a shadow file.
    File(FileInfo),
    /// Of a manifest of regions.
    Manifest(ManifestInfo),
    /// Of a sun path.
    Path(PathInfo),
}

/// What a shadow file contains.
#[derive(Serialize, JsonSchema)]
pub(super) struct FileInfo {
    /// The shadow file.
    file: String,
    /// Length of the shadow file, in bytes.
    file_bytes: u64,
    /// How the file is stored.
    #[schemars(with = "mirrors::Encoding")]
    encoding: Encoding,
    /// Bytes of header and directory.
    front_bytes: u64,
    /// Bits of the shadow file per texel of its finest grid.
    bits_per_texel: f64,
    /// How many times smaller the file is than a shadow map of the finest grid's texels with 32 bits per
    /// texel.
    times_smaller: f64,
    /// How the grids lie in the world.
    #[schemars(with = "mirrors::Frame")]
    frame: Frame,
    /// Unit vector towards the sun.
    sun: [f64; 3],
    /// The settings of the bake.
    #[schemars(with = "mirrors::FileSettings")]
    settings: FileSettings,
    /// The levels of detail, the finest first.
    levels: Vec<LevelInfo>,
}

/// A level of detail.
#[derive(Serialize, JsonSchema)]
pub(super) struct LevelInfo {
    /// Number of voxels along x, y and z of the grid.
    size: [u32; 3],
    /// Edge of a voxel, world units.
    voxel_size: f64,
    /// Number of pages along x and y.
    pages: [u32; 2],
    /// The fewest, the median and the most bytes of a page, of those that have any, not coded.
    page_bytes: Option<[u64; 3]>,
    /// Number of bundles of 4 x 4 pages.
    bundles: usize,
    /// Number of bundles without bytes, because all of their columns switch at one depth.
    uniform_bundles: usize,
    /// Bytes of the table of bundles.
    table_bytes: u64,
    /// Bytes of the common section in the file.
    common_bytes: u64,
    /// Bytes of all bundles in the file.
    bundle_bytes: u64,
    /// Bytes of common section and bundles once decoded.
    raw_bytes: u64,
    /// Bytes that look-ups read, all pages resident: common section, pages, and the table of blocks at which
    /// they begin.
    resident_bytes: u64,
    /// Level of the blocks at which look-ups begin. A block is 2^level columns wide.
    root_level: u32,
    /// Number of nodes of the quadtree.
    nodes: u64,
    /// Number of leaves.
    leaves: u64,
    /// Number of leaves whose depths are on parallel planes.
    slanted_leaves: u64,
    /// Bytes of the nodes' heads.
    head_bytes: u64,
    /// Bytes of the nodes' pointers and differences.
    field_bytes: u64,
    /// Bytes of the leaves' heads and differences.
    depth_bytes: u64,
    /// Bytes of the leaves' planes.
    plane_bytes: u64,
}

pub(crate) fn run(args: &Info) -> Outcome {
    if let Some(picture) = &args.picture {
        refuse_inputs("--picture", picture, [("the shadow file", args.file.as_path())])?;
    }
    let of_one_file =
        args.picture.as_ref().map(|_| "--picture").or(args.snippet.as_ref().map(|_| "--snippet"));
    if let Some(regions) = regions::manifest(&args.file)? {
        if let Some(option) = of_one_file {
            let file = args.file.display();
            return Err(Failure::Usage(format!("{option}: {file} is a manifest; give a region's file")));
        }
        let info = ManifestInfo::of(&regions, &args.file);
        if args.run.json {
            print_json(&Printed::Manifest(info))?;
        } else {
            info.print();
        }
        return Ok(Code::Fine);
    }
    if let Some(sun_path) = moment::sun_path(&args.file)? {
        if let Some(option) = of_one_file {
            let file = args.file.display();
            return Err(Failure::Usage(format!("{option}: {file} is a sun path; give the file of one sun")));
        }
        if let Some(info) = path::info(&sun_path, &args.file, args.run.json)? {
            print_json(&Printed::Path(info))?;
        }
        return Ok(Code::Fine);
    }
    with_threads(args.run.threads, || info_of_file(args))?
}

fn info_of_file(args: &Info) -> Outcome {
    args.run.memory_limit().check_shadow_file(&args.file)?;
    let bytes = read_file(&args.file, HEADER_BYTES, |front| Ok(Header::parse(front)?.file_bytes))?;
    let error = |source| Error::Format { path: Some(args.file.clone()), source: Box::new(source) };
    let contents = Contents::parse(&bytes).map_err(error)?;
    let file = ShadowFile::from_bytes(&bytes).map_err(error)?;
    if let Some(of) = args.snippet {
        say!("{}", snippet::snippet(of, &args.file));
        return Ok(Code::Fine);
    }
    if let Some(picture) = &args.picture {
        let level = LevelArg { level: args.level };
        write_png(picture, &PageBytes::of(&level.of(&file, &args.file)?.tree).picture())?;
    }
    let file_bytes = bytes.len() as u64;
    let [nx, ny, _] = file.grid.size.map(f64::from);
    let info = FileInfo {
        file: args.file.display().to_string(),
        file_bytes,
        encoding: contents.header.encoding,
        front_bytes: (HEADER_BYTES + GRID_BYTES * contents.grids.len()) as u64,
        bits_per_texel: bits_per_texel(&file.grid, file_bytes),
        times_smaller: 4.0 * nx * ny / file_bytes as f64,
        frame: file.grid.frame,
        sun: file.sun().towards(),
        settings: file.settings,
        levels: levels(&contents, &file),
    };
    if args.run.json {
        print_json(&Printed::File(info))?;
    } else {
        print(&info);
    }
    Ok(Code::Fine)
}

fn levels(contents: &Contents, file: &ShadowFile) -> Vec<LevelInfo> {
    let levels = file.levels().into_iter().zip(&contents.grids).zip(&contents.tables);
    let level = |((level, entry), table): ((Level, &GridEntry), &Vec<BundleEntry>)| {
        let census = level.tree.census();
        LevelInfo {
            size: level.grid.size,
            voxel_size: level.grid.voxel_size,
            pages: level.tree.page_dims(),
            page_bytes: PageBytes::of(&level.tree).spread(),
            bundles: table.len(),
            uniform_bundles: table.iter().filter(|bundle| bundle.stored_bytes == 0).count(),
            table_bytes: (BUNDLE_ENTRY_BYTES * table.len()) as u64,
            common_bytes: entry.common.length,
            bundle_bytes: entry.bundles.length,
            raw_bytes: entry.common_raw_bytes
                + table.iter().map(|bundle| u64::from(bundle.raw_bytes)).sum::<u64>(),
            resident_bytes: level.tree.bytes(),
            root_level: level.tree.root_level(),
            nodes: census.nodes,
            leaves: census.leaves,
            slanted_leaves: census.slanted_leaves,
            head_bytes: census.head_bytes,
            field_bytes: census.field_bytes,
            depth_bytes: census.depth_bytes,
            plane_bytes: census.plane_bytes,
        }
    };
    levels.map(level).collect()
}

fn print(info: &FileInfo) {
    let s = &info.settings;
    let encoding = if info.encoding == Encoding::Raw { "raw" } else { "coded" };
    say!("{}: {}, {encoding}", info.file, format_bytes(info.file_bytes));
    say!("  sun towards     {:.6}, {:.6}, {:.6}", info.sun[0], info.sun[1], info.sun[2]);
    say!("  resolution      {}", s.resolution);
    if let Some(Region { x, y, texels }) = s.region {
        say!("  region          ({x}, {y}) of {texels} texels a side; positions are relative to its origin");
    }
    say!(
        "  bits per texel  {:.4} ({:.0} times smaller than 32 bits)",
        info.bits_per_texel,
        info.times_smaller
    );
    match info.frame {
        Frame::Light => say!("  frame           light"),
        Frame::Oblique { yaw_radians } => {
            say!("  frame           oblique, x turned by {:.4}° from +X to +Z", yaw_radians.to_degrees());
        }
    }
    say!("  header          {} bytes with the directory", info.front_bytes);
    for (number, level) in info.levels.iter().enumerate() {
        let [px, py] = level.pages;
        say!("  level {number}         {:?} voxels of {:.6}", level.size, level.voxel_size);
        say!(
            "    {px} x {py} pages in {} bundles, {} of them uniform; {} in memory, look-ups begin at level {}",
            level.bundles,
            level.uniform_bundles,
            format_bytes(level.resident_bytes),
            level.root_level
        );
        say!(
            "    bytes         table {}, common section {}, bundles {}; {} decoded",
            level.table_bytes,
            level.common_bytes,
            level.bundle_bytes,
            level.raw_bytes
        );
        if let Some([fewest, median, most]) = level.page_bytes {
            say!("    page          {fewest} to {most} bytes, median {median}, not coded");
        }
        say!(
            "    {} nodes: heads {}, pointers {} bytes; {} leaves: depths {}, planes {} bytes",
            level.nodes,
            level.head_bytes,
            level.field_bytes,
            level.leaves,
            level.depth_bytes,
            level.plane_bytes
        );
    }
    say!("  baked from      {} triangles in {} instances", s.triangles, s.instances);
    say!(
        "  ground assumed {}, closed regions {}, receivers {:?}, thickness {} world units, switch within {} voxels, alpha ignored {}",
        s.assume_ground,
        s.closed_regions,
        s.receivers,
        s.thickness_world,
        s.switch_within_voxels,
        s.ignore_alpha
    );
    if s.scene_is_z_up {
        say!("  of a scene with Z up: its (x, y, z) is (x, z, -y) in this file's world");
    }
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
