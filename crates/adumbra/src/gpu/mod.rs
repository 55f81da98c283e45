//! The contents of a file for shaders, independent of any graphics library: its words, its parameter block, both
//! combined in a texture, and the list of WGSL files that read them.
//!
//! There are two ways to give a shader a file:
//!
//! - *Buffers.* [`Words`] go into a storage buffer, [`Parameters`] into a uniform buffer.
//! - *A texture.* [`LookUpTexture`] holds both in rows of texels, `R32Uint` or `Rgba8Unorm`, for engines whose
//!   materials can add a texture but no buffer. `spec/look-up-texture.md` describes it.
//!
//! [`wgsl_files`] lists the files of `adumbra-shaders` for either way.
//!
//! ```no_run
//! use adumbra::ShadowFile;
//! use adumbra::gpu::LookUpTexture;
//!
//! let file = ShadowFile::read("city.adumbra")?;
//! let texture = LookUpTexture::new(&file, file.settings.bias, 5, 8192)?;
//! println!("{} x {} texels, {} bytes", texture.width(), texture.height(), texture.bytes().len());
//! # Ok::<(), adumbra::Error>(())
//! ```

mod grid;
mod parameters;
mod texture;
mod wgsl;
mod words;

pub use grid::GridParameters;
pub use parameters::{PENUMBRA_ANGLES_DEGREES, PENUMBRA_RADII_TEXELS, Parameters};
pub use texture::{HEADER_WORDS, LookUpTexture, TEXTURE_MAGIC, TEXTURE_VERSION};
pub use wgsl::{WordSource, wgsl_files};
pub use words::Words;
