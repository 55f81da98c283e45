//! The baked files that the papers' techniques read: given, or baked on demand.

use std::any::Any;
use std::path::Path;

use adumbra::{Filter, PointVisibility};
use adumbra_bake::{BakeOptions, Size, Watch};
use adumbra_compare::Result;
use adumbra_compare::baked::{BakeOnDemand, FileFacts, MoreFiles};
use adumbra_compare::report::BakedFigures;
use adumbra_program::exit::Failure;
use adumbra_program::lookup::LookupArgs;
use adumbra_render::{Reads, TechniqueFiles, TechniqueSpec};
use adumbra_scene::LoadedAs;

use crate::dag::build::{DagOptions, bake as bake_graph};
use crate::dag::{DagFile, DagLayout, DagQuery};
use crate::tree::query::{TreeQuery, Weights};
use crate::tree::{TreeBody, TreeFile, TreeOptions, bake_tree};

/// The name of the kind of file that a tree's techniques read.
pub const TREE_FILE: &str = "a world-aligned file";

/// The name of the kind of file that a graph's technique reads.
pub const GRAPH_FILE: &str = "a graph file";

/// The baked files of the papers' techniques.
pub struct PaperFiles {
    /// A graph file, for `voxel-dag`.
    pub graph: Option<DagFile>,
    /// A world-aligned file, for `voxel-cubes` and `voxel-texture`.
    pub tree: Option<TreeFile>,
    /// Voxels along the side of a tree that is baked on demand.
    pub cube_resolution: u64,
}

impl Default for PaperFiles {
    fn default() -> Self {
        Self { graph: None, tree: None, cube_resolution: Self::CUBE_RESOLUTION }
    }
}

impl PaperFiles {
    /// Default of [`PaperFiles::cube_resolution`].
    pub const CUBE_RESOLUTION: u64 = 2048;

    /// Returns the papers' files among the files of a technique.
    pub fn among(baked: TechniqueFiles<'_>) -> Option<&Self> {
        baked.other?.downcast_ref()
    }

    /// Returns the files in the form that techniques take.
    pub fn baked(&self) -> TechniqueFiles<'_> {
        TechniqueFiles { light: None, other: Some(self) }
    }
}

impl MoreFiles for PaperFiles {
    fn read(&mut self, path: &Path) -> Result<Option<FileFacts>> {
        let (facts, twice) = if TreeFile::is_one(path)? {
            let file = TreeFile::read(path)?;
            let scene = LoadedAs { ignore_alpha: file.settings.ignore_alpha, ..LoadedAs::default() };
            let facts = FileFacts { sun: file.sun, scene };
            (facts, self.tree.replace(file).is_some())
        } else if DagFile::is_one(path)? {
            let file = DagFile::read(path)?;
            let facts = FileFacts { sun: file.grid.sun, scene: LoadedAs::from(&file.settings) };
            (facts, self.graph.replace(file).is_some())
        } else {
            return Ok(None);
        };
        if twice {
            return Err(Failure::Usage("--shadow-file: give at most one file of a kind".to_owned()).into());
        }
        Ok(Some(facts))
    }

    fn serves(&self, spec: &TechniqueSpec) -> bool {
        if spec.reads() == Reads::Other(GRAPH_FILE) { self.graph.is_some() } else { self.tree.is_some() }
    }

    fn announcement(&self, spec: &TechniqueSpec, how: &BakeOnDemand<'_>) -> String {
        if spec.reads() == Reads::Other(GRAPH_FILE) {
            return format!("no --shadow-file with a graph; baking one with {} texels", how.resolution);
        }
        let side = self.cube_resolution;
        format!("no world-aligned --shadow-file; baking one with {side} voxels per side")
    }

    fn bake(&mut self, spec: &TechniqueSpec, how: &BakeOnDemand<'_>) -> Result<()> {
        if spec.reads() == Reads::Other(GRAPH_FILE) {
            let bake = BakeOptions::new(how.sun, Size::Resolution(how.resolution)).with(|o| {
                o.ignore_alpha = how.ignore_alpha;
                o.max_memory_bytes = how.max_memory_bytes;
            });
            let options = DagOptions { bake, layout: DagLayout::Packed };
            self.graph = Some(bake_graph(how.scene, &options, Watch::none())?.file);
            return Ok(());
        }
        let options = TreeOptions {
            ignore_alpha: how.ignore_alpha,
            max_memory_bytes: how.max_memory_bytes,
            ..TreeOptions::new(how.sun, Size::Resolution(self.cube_resolution))
        };
        self.tree = Some(bake_tree(how.scene, &options, Watch::none())?.into());
        Ok(())
    }

    fn files(&self) -> &(dyn Any + Send + Sync) {
        self
    }

    fn lookup(&self, args: &LookupArgs) -> Result<Option<Box<dyn PointVisibility + '_>>> {
        if let Some(file) = &self.graph {
            let bias = args.bias.over(file.settings.bias)?;
            let filter = Filter::try_from(args.filter)?;
            return Ok(Some(Box::new(DagQuery::new(&file.grid, file.body.leaf_masks(), bias, filter))));
        }
        let Some(file) = &self.tree else { return Ok(None) };
        let bias = args.bias.over(file.settings.bias)?;
        let (space, regions, sun) = (&file.space, &file.regions, &file.sun);
        Ok(Some(match &file.body {
            TreeBody::Words(tree) => {
                Box::new(TreeQuery::new(space, regions, sun, tree, bias, args.filter, Weights::Mean)?)
            }
            TreeBody::Symmetric(tree) => {
                Box::new(TreeQuery::new(space, regions, sun, tree, bias, args.filter, Weights::Mean)?)
            }
        }))
    }

    fn technique(&self, args: &LookupArgs) -> Option<String> {
        if self.graph.is_some() {
            return Some(format!("voxel-dag:filter={}{}", args.filter, args.bias.parameters()));
        }
        self.tree.as_ref()?;
        Some(format!("voxel-cubes:filter={}{}", args.filter, args.bias.parameters()))
    }

    fn figures(&self) -> Vec<BakedFigures> {
        let figures = |f: &TreeFile| BakedFigures {
            frame: "world".to_owned(),
            resolution: f.space.side_voxels().into(),
            voxel_size: f.space.voxel_size,
            file_bytes: f.encoded_len(),
        };
        let of_graph = |f: &DagFile| BakedFigures {
            frame: "light".to_owned(),
            resolution: f.settings.resolution.into(),
            voxel_size: f.grid.voxel_size,
            file_bytes: f.encoded_len(),
        };
        self.graph.iter().map(of_graph).chain(self.tree.iter().map(figures)).collect()
    }
}
