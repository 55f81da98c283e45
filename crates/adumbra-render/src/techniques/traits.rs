//! Properties of a technique that are known without a device: the file that it reads, the truth that it is
//! compared with, and whether it shows shadows of movers.

/// The baked file that a technique reads besides the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reads {
    /// No baked file.
    Nothing,
    /// A light-aligned file.
    LightFile,
    /// A file of another kind, which a dependent crate knows, by its name.
    Other(&'static str),
}

/// The ray-traced truth that a technique is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Truth {
    /// Rays to the sun's centre. The technique's filter, if any, only smooths shadow edges.
    HardSun,
    /// Rays over the sun's disc. The technique shows penumbrae.
    SunDisc,
}

/// Properties of a technique that are known from its name and parameters alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Traits {
    /// The baked file that it reads.
    pub reads: Reads,
    /// The truth that it is compared with.
    pub truth: Truth,
    /// Whether it has a parameter `sun-degrees`, the sun's full angle in degrees.
    pub takes_sun_degrees: bool,
    /// Whether movers cast shadows, as static objects do.
    pub shows_movers: bool,
}

impl Traits {
    /// Traits of a technique that is redrawn in every frame, for the sun's centre.
    pub const DRAWN: Self =
        Self { reads: Reads::Nothing, truth: Truth::HardSun, takes_sun_degrees: false, shows_movers: true };
    /// Traits of a technique that is redrawn in every frame and shows the penumbrae of the sun's disc.
    pub const SOFT: Self = Self { truth: Truth::SunDisc, takes_sun_degrees: true, ..Self::DRAWN };
}
