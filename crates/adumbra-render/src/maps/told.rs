//! What parameters are that shadow maps share with other techniques, as help and sliders show it.

pub(crate) const BIAS: &str = "moves receivers towards the light, texels of what is looked up in";
/// Of files, which have one of their own.
pub(crate) const FILE_BIAS: &str = "moves receivers towards the light, texels of what is looked up in; the file's by default, as slope and normal";
pub(crate) const SLOPE: &str = "the same, times the slope towards the light";
pub(crate) const NORMAL: &str = "moves receivers along their normals, texels";
pub(crate) const SUN_ANGLE: &str = "full angle of the sun, degrees";
pub(crate) const PENUMBRA_RADIUS: &str = "most of a penumbra, from its middle to its edge, texels";
