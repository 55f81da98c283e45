//! The contents of a file for shaders, independent of any graphics library: its words, its parameter block,
//! both combined in a texture, and the WGSL that reads them.
//!
//! There are two ways to give a shader a file:
//!
//! - *Buffers.* [`FileForGpu::words`] go into a storage buffer, [`Parameters`] into a uniform buffer.
//! - *A texture.* [`LookUpTexture`] holds both in rows of texels, `R32Uint` or `Rgba8Unorm`, for engines
//!   whose materials can add a texture but no buffer. `spec/look-up-texture.md` describes it.
//!
//! [`FileForGpu::wgsl`] and [`LookUpTexture::wgsl`] return the WGSL of either way, as one text.
//!
//! ```no_run
//! use adumbra::gpu::{Bindings, LookUp};
//! use adumbra::{Filter, ShadowFile};
//!
//! let file = ShadowFile::read("city.adumbra")?;
//! let gpu = file.gpu();
//! // The storage buffer.
//! let words: Vec<u32> = gpu.words().to_vec();
//! // The uniform buffer.
//! let look_up = LookUp { filter: Filter::Box5, ..LookUp::default() };
//! let parameters = gpu.parameters(&look_up, [10.0, 1.8, 4.0])?.to_bytes();
//! // The shader. The engine's own text calls `adumbra_visibility(p_relative, normal)`.
//! let wgsl = gpu.wgsl(Bindings { group: 1, first: 0 });
//! println!("{} words, {} bytes, {} characters", words.len(), parameters.len(), wgsl.len());
//! # Ok::<(), adumbra::Error>(())
//! ```

mod grid;
mod parameters;
mod texture;
mod wgsl;
mod words;

pub use grid::GridParameters;
pub(crate) use parameters::WordPlaces;
pub use parameters::{LookUp, Parameters, Penumbra};
pub use texture::{HEADER_WORDS, LookUpTexture, TEXTURE_MAGIC, TEXTURE_VERSION};
pub(crate) use texture::{middle, put_header};
pub(crate) use wgsl::of_stream;
pub use wgsl::{Bindings, TexelFormat};
pub use words::Words;

use crate::error::Result;
use crate::file::ShadowFile;

/// A file as shaders read it.
#[derive(Clone, Copy, Debug)]
pub struct FileForGpu<'f> {
    file: &'f ShadowFile,
}

impl ShadowFile {
    /// Returns the file's contents in the form that shaders read.
    pub fn gpu(&self) -> FileForGpu<'_> {
        FileForGpu { file: self }
    }
}

impl<'f> FileForGpu<'f> {
    /// Returns the words of the file's voxels, for a storage buffer.
    pub fn words(self) -> Words<'f> {
        Words::new(&self.file.tree)
    }

    /// Returns the WGSL of look-ups in buffers: a uniform buffer with the [parameters](Self::parameters) at
    /// the first binding, and a read-only storage buffer with the [words](Self::words) at the next. An engine
    /// puts its own text after it. It defines, for any stage:
    ///
    /// ```wgsl
    /// fn adumbra_visibility(p_relative: vec3f, normal: vec3f) -> f32
    /// fn adumbra_soft_visibility(p_relative: vec3f, normal: vec3f, pixel: vec2u) -> f32
    /// ```
    ///
    /// Both return visibility, 1 = lit. The second averages over the sun's disc: its parameters must have a
    /// [`Penumbra`], and `pixel`, the fragment's coordinates, rotates the taps. Positions are relative to the
    /// anchor of the parameters. The normal is the triangle's, of unit length, or zero where there is none.
    /// All names begin with `adumbra_`, `Adumbra` or `ADUMBRA_`. The text is the same for every file. A
    /// module can hold it only once, because a second copy would define the same names again.
    pub fn wgsl(self, bindings: Bindings) -> String {
        wgsl::of_buffers(bindings)
    }

    /// Returns the parameters of a look-up, for a uniform buffer. Positions in the shader are relative to
    /// `anchor_world`, which is near the camera.
    ///
    /// # Errors
    /// Returns the errors of [`Parameters::new`].
    pub fn parameters(self, look_up: &LookUp, anchor_world: [f64; 3]) -> Result<Parameters> {
        Parameters::new(self.file, look_up, anchor_world)
    }

    /// Returns only the header of the file's texture, for an engine that places the words itself. Positions
    /// in the shader are relative to the same anchor as in [`FileForGpu::texture`].
    ///
    /// # Errors
    /// Returns the errors of [`Parameters::new`].
    pub fn texture_header(self, look_up: &LookUp) -> Result<Vec<u8>> {
        let grid = self.file.grid.placed(&look_up.placement);
        let anchor_world = middle(&grid);
        let parameters = self.parameters(look_up, anchor_world.map(f64::from))?;
        let mut header = Vec::with_capacity(4 * HEADER_WORDS);
        // The number of words of a texture fits 32 bits.
        put_header(&mut header, &parameters, anchor_world, &grid, self.words().count() as u32);
        Ok(header)
    }

    /// Returns words and parameters as one texture of at most `max_side` texels along each side.
    ///
    /// # Errors
    /// Returns the errors of [`LookUpTexture::new`].
    pub fn texture(self, look_up: &LookUp, max_side: u32) -> Result<LookUpTexture> {
        LookUpTexture::new(self.file, look_up, max_side)
    }
}
