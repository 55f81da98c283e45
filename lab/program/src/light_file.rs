//! A file of columns along the light, in the product's layout or as a graph of the 2014 paper, so that both
//! have a row in the tables.

use adumbra::{FileSettings, Filter, LightGrid, PointVisibility, ShadowFile};
use adumbra_bake::{Bake, BakeOptions, Watch};
use adumbra_compare::Result;
use adumbra_papers::dag::build::{DagOptions, bake as bake_graph};
use adumbra_papers::dag::{DagFile, DagLayout, DagQuery};
use adumbra_papers::techniques::PaperFiles;
use adumbra_render::TechniqueFiles;
use adumbra_scene::Scene;
use adumbra_truth::verify::LightAnswers;

/// The two kinds, in the order of their rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A packed graph.
    Packed,
    /// The product's quadtree of switch depths.
    Quadtree,
}

impl Kind {
    pub(crate) const ALL: [Self; 2] = [Self::Packed, Self::Quadtree];

    /// The name in tables.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Packed => "packed",
            Self::Quadtree => "depths",
        }
    }
}

/// A baked file.
pub(crate) enum LightFile {
    Graph { files: Box<PaperFiles>, graph: Box<DagFile> },
    Quadtree(Box<ShadowFile>),
}

impl LightFile {
    /// Bakes a file.
    pub(crate) fn bake(scene: &Scene, options: &BakeOptions, kind: Kind) -> Result<Self> {
        Ok(match kind {
            Kind::Quadtree => Self::Quadtree(Box::new(Bake::with_options(scene, options).in_memory()?)),
            Kind::Packed => {
                let options = DagOptions { bake: options.clone(), layout: DagLayout::Packed };
                let graph = bake_graph(scene, &options, Watch::none())?.file;
                let files = Box::new(PaperFiles { graph: Some(graph.clone()), ..PaperFiles::default() });
                Self::Graph { files, graph: Box::new(graph) }
            }
        })
    }

    pub(crate) fn kind(&self) -> Kind {
        match self {
            Self::Graph { .. } => Kind::Packed,
            Self::Quadtree(_) => Kind::Quadtree,
        }
    }

    pub(crate) fn grid(&self) -> &LightGrid {
        match self {
            Self::Graph { graph, .. } => &graph.grid,
            Self::Quadtree(file) => &file.grid,
        }
    }

    pub(crate) fn settings(&self) -> &FileSettings {
        match self {
            Self::Graph { graph, .. } => &graph.settings,
            Self::Quadtree(file) => &file.settings,
        }
    }

    /// Returns the files in the form that techniques take.
    pub(crate) fn baked(&self) -> TechniqueFiles<'_> {
        match self {
            Self::Graph { files, .. } => files.baked(),
            Self::Quadtree(file) => TechniqueFiles::of(file),
        }
    }

    /// Returns the technique that looks up the file with this filter.
    pub(crate) fn technique(&self, filter: u32) -> String {
        match self {
            Self::Graph { .. } => format!("voxel-dag:filter={filter}"),
            Self::Quadtree(_) => format!("voxel:filter={filter}"),
        }
    }

    /// Returns the file's answers, with its own bias.
    pub(crate) fn answers(&self, filter: Filter) -> LightAnswers<Box<dyn PointVisibility + '_>> {
        let bias = self.settings().bias;
        let look_up: Box<dyn PointVisibility + '_> = match self {
            Self::Graph { graph, .. } => {
                Box::new(DagQuery::new(&graph.grid, graph.body.leaf_masks(), bias, filter))
            }
            Self::Quadtree(file) => Box::new(file.sampler(filter)),
        };
        LightAnswers::new(*self.grid(), *self.settings(), look_up, (filter, bias))
    }
}
