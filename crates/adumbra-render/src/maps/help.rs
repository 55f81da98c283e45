//! Help texts of parameters that shadow maps share with other techniques. Sliders show them too.

pub(crate) const BIAS: &str = "moves receivers towards the light, texels of the map";
/// Bias of techniques that read a file, which has a default bias of its own.
pub(crate) const FILE_BIAS: &str =
    "moves receivers towards the light, texels of the file; bias, slope and normal default to the file's";
pub(crate) const SLOPE: &str = "moves receivers towards the light, texels per unit of slope towards it";
pub(crate) const NORMAL: &str = "moves receivers along their normals, texels";
pub(crate) const SUN_DEGREES: &str = "angular diameter of the sun, degrees";
pub(crate) const PENUMBRA_RADIUS: &str = "largest radius of a penumbra, from its centre to its edge, texels";
