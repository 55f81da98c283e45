//! `cargo xtask vectors`: regenerates `test_vectors/`, with the same bytes every time.
//!
//! | module | writes |
//! |---|---|
//! | `quadtree` | `valid` and `invalid`: shadow files |
//! | `dag` | `dag`: graph files of the papers |
//! | [`tree_vectors`] | `tree`: tree files of the papers |
//!
//! Valid files are made from functions voxel -> lit, and their answers come from these functions, not from
//! the file. A reader that agrees with them has therefore decoded the file correctly. Each broken file is a
//! valid one with one fault.

mod dag;
mod flipped;
mod graph;
mod grids;
mod headers;
mod quadtree;
mod shadow_bytes;

use std::error::Error;
use std::fs;
use std::path::Path;

use adumbra_papers::dag::DagLayout;
use adumbra_papers::dag::build::convert::body_in;
use adumbra_papers::dag::plain::Dag;

use crate::broken;
use crate::tree_vectors;
use grids::Grid;

/// Writes all vectors below `root/test_vectors`.
pub(crate) fn run(root: &Path) -> Result<(), Box<dyn Error>> {
    let folder = root.join("test_vectors");
    let known: Vec<Known> = grids::all()?.into_iter().map(Known::new).collect();
    let graphs = dag::valid(&known)?;
    let quadtrees = quadtree::valid(&known, &grids::large()?)?;
    write(&graphs, &folder.join("dag/valid"))?;
    write(&quadtrees, &folder.join("valid"))?;
    broken::write(&dag::broken(&graphs, &quadtrees)?, &folder.join("dag/invalid"))?;
    broken::write(&quadtree::broken(&quadtrees)?, &folder.join("invalid"))?;
    tree_vectors::run(&folder.join("tree"))
}

/// A grid whose voxels are known, and its graph.
struct Known {
    grid: Grid,
    dag: Dag,
}

impl Known {
    fn new(grid: Grid) -> Self {
        let dag = graph::build(grid.grid.size, grid.root_level, &grid.lit);
        Self { grid, dag }
    }

    /// Whether every column is lit and then shadowed, so that it has one depth.
    fn is_monotone(&self) -> bool {
        body_in(DagLayout::Packed, self.dag.clone()).is_ok()
    }
}

/// A valid file.
struct Vector {
    name: String,
    bytes: Vec<u8>,
    answers: String,
}

fn write(vectors: &[Vector], folder: &Path) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(folder)?;
    for Vector { name, bytes, answers } in vectors {
        fs::write(folder.join(format!("{name}.adumbra")), bytes)?;
        fs::write(folder.join(format!("{name}.json")), answers)?;
    }
    Ok(())
}

/// A graph file that is being broken.
type Bytes = broken::Bytes<280, 384>;

const TOP: usize = 0;
const NODES: usize = 1;
const LEAF_MASKS: usize = 2;

/// Returns the bytes of a valid file.
fn bytes_of(name: &str, vectors: &[Vector]) -> Result<Bytes, String> {
    let vector = vectors.iter().find(|v| v.name == name).ok_or_else(|| format!("no vector {name}"))?;
    Ok(broken::Bytes(vector.bytes.clone()))
}
