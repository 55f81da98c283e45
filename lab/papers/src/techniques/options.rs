//! Parsing of the look-up options of a world-aligned tree from a technique's text. Without a file, the bias
//! is the default of a bake.

use adumbra::Bias;
use adumbra_render::Result;
use adumbra_render::technique::SpecReader;
use adumbra_render::voxel::read_bias;

use crate::tree::TreeFile;
use crate::tree::query::{KERNEL_SIDES, Weights};

/// The storage that words are read from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CubesStore {
    /// Storage buffers.
    Words,
    /// The texels of an RGBA8 texture.
    Texels,
    /// Storage buffers, decoded from such a texture at load.
    Decoded,
}

/// Options of a tree's look-up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CubesOptions {
    /// Bias, in cells.
    pub bias: Bias,
    /// Side of the filter's cube, one of [`KERNEL_SIDES`].
    pub filter: u32,
    /// Weights of the taps.
    pub weights: Weights,
    /// Whether taps behind the receiver's plane count too.
    pub all_taps: bool,
    /// The storage that words are read from.
    pub store: CubesStore,
}

impl CubesOptions {
    /// Parses
    /// `voxel-cubes[:filter=1|3|5][:weights=mean|poisson][:taps=front|all][:bias=…][:slope=…][:normal=…]`.
    /// `voxel-texture` (`from_texture`) also takes `read=texels|buffer`. Defaults: 3³, mean, and the file's
    /// bias.
    ///
    /// # Errors
    /// Returns [`adumbra_render::RenderError::Technique`] if a parameter is unknown or out of range.
    pub(crate) fn from_reader(
        reader: &mut SpecReader<'_>,
        file: Option<&TreeFile>,
        from_texture: bool,
    ) -> Result<Self> {
        let filter = reader.integer("filter", "voxels per side of a cube", 3, &KERNEL_SIDES)?;
        let weights =
            match reader.choice("weights", "weights of the filter's voxels", &["mean", "poisson"])? {
                "poisson" => Weights::Poisson,
                _ => Weights::Mean,
            };
        let taps = "which voxels count: those in front of the receiver's plane, or all";
        let all_taps = reader.choice("taps", taps, &["front", "all"])? == "all";
        let bias = read_bias(reader, file.map_or_else(Bias::default, |f| f.settings.bias))?;
        let read = "read words from texels, or from a buffer that they are decoded into at load";
        let store = if !from_texture {
            CubesStore::Words
        } else if reader.choice("read", read, &["texels", "buffer"])? == "buffer" {
            CubesStore::Decoded
        } else {
            CubesStore::Texels
        };
        Ok(Self { bias, filter, weights, all_taps, store })
    }

    /// The technique's text for these options, without the bias.
    pub(super) fn name(&self) -> String {
        let weights = match self.weights {
            Weights::Mean => "mean",
            Weights::Poisson => "poisson",
        };
        let (name, read) = match self.store {
            CubesStore::Words => ("voxel-cubes", ""),
            CubesStore::Texels => ("voxel-texture", ""),
            CubesStore::Decoded => ("voxel-texture", ":read=buffer"),
        };
        let taps = if self.all_taps { ":taps=all" } else { "" };
        format!("{name}:filter={}:weights={weights}{taps}{read}", self.filter)
    }
}
