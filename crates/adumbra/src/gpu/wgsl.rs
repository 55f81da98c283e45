//! The WGSL of look-ups, as one text that an engine puts before its own.

use adumbra_shaders::{Source, assemble, source};

/// Where the resources of a look-up are among the bindings of an engine's pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bindings {
    /// The bind group.
    pub group: u32,
    /// The first binding in the group. The others follow it.
    pub first: u32,
}

impl Default for Bindings {
    /// Group 1, from binding 0 on.
    fn default() -> Self {
        Self { group: 1, first: 0 }
    }
}

/// The format of a [`LookUpTexture`](super::LookUpTexture) on the device. Its bytes are the same in either.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TexelFormat {
    /// A texel is a word.
    R32Uint,
    /// A texel is four bytes, for engines whose materials have textures of floats only.
    Rgba8Unorm,
}

/// Returns the WGSL of look-ups in buffers.
pub(super) fn of_buffers(bindings: Bindings) -> String {
    let access = [source::WORDS_1, source::VOXEL_PARAMS, source::VOXEL_PARAMS_SOFT, source::VISIBILITY];
    text(&access, bindings)
}

/// Returns the WGSL of look-ups in a texture.
pub(super) fn of_texture(format: TexelFormat, bindings: Bindings) -> String {
    let texels = match format {
        TexelFormat::R32Uint => source::TEXTURE_R32UINT,
        TexelFormat::Rgba8Unorm => source::TEXTURE_RGBA8UNORM,
    };
    let access = [
        source::DEPTHS_BLEND,
        texels,
        source::LOOK_UP_TEXTURE,
        source::LOOK_UP_PARAMETERS,
        source::LOOK_UP_FILE,
        source::VISIBILITY,
    ];
    text(&access, bindings)
}

/// Returns the WGSL of look-ups in the words and levels of a stream.
pub(crate) fn of_stream(bindings: Bindings) -> String {
    let access = [
        source::WORDS_1,
        source::DEPTHS_BLEND,
        source::VOXEL_LEVELS,
        source::VOXEL_LEVELS_SOFT,
        source::VISIBILITY,
    ];
    text(&access, bindings)
}

fn text(access: &[Source], bindings: Bindings) -> String {
    let look_up = [&[source::SURFACE], source::LOOK_UP, &[source::DISC, source::DEPTHS_SOFT]];
    bound(&assemble(&[&look_up.concat(), access].concat()), bindings)
}

/// Moves the bindings of a text, which are in group 1 from binding 0 on.
fn bound(text: &str, bindings: Bindings) -> String {
    let moved = |line: &str| {
        let (number, declared) = line.strip_prefix("@group(1) @binding(")?.split_once(')')?;
        let binding = bindings.first.saturating_add(number.parse().ok()?);
        Some(format!("@group({}) @binding({binding}){declared}\n", bindings.group))
    };
    text.lines().map(|line| moved(line).unwrap_or_else(|| format!("{line}\n"))).collect()
}
