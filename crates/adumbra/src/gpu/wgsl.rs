//! The WGSL files that a look-up needs.

/// The source of a shader's words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WordSource {
    /// One storage buffer, with the parameters in a uniform buffer.
    Buffer,
    /// A [`LookUpTexture`](super::LookUpTexture) of format `R32Uint`, which includes the parameters.
    R32Uint,
    /// A [`LookUpTexture`](super::LookUpTexture) of format `Rgba8Unorm`, which includes the parameters.
    Rgba8Unorm,
}

/// Returns the paths, relative to `adumbra-shaders/wgsl`, of the files that define `adumbra_voxel_factor` in
/// the order in which they must be included. `adumbra_shaders::source::by_path` returns their texts, and
/// `adumbra_shaders::assemble` puts the shared structures before them.
pub fn wgsl_files(words: WordSource) -> Vec<&'static str> {
    let mut files = vec![
        "core/surface.wgsl",
        "core/grid.wgsl",
        "core/voxel.wgsl",
        "core/depths.wgsl",
        "core/depths_leaf.wgsl",
    ];
    let texels = match words {
        WordSource::Buffer => {
            files.push("access/words_1.wgsl");
            return files;
        }
        WordSource::R32Uint => "access/texture_r32uint.wgsl",
        WordSource::Rgba8Unorm => "access/texture_rgba8unorm.wgsl",
    };
    files.extend([
        "core/depths_blend.wgsl",
        texels,
        "access/look_up_texture.wgsl",
        "access/look_up_parameters.wgsl",
    ]);
    files
}
