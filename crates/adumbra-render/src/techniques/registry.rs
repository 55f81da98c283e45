//! The list of shadow techniques: what each is called, reads and shows, and how it is built. All other code queries
//! this list through the methods of [`TechniqueSpec`] and never compares names.

use super::traits::{Reads, Traits, Truth};
use crate::error::RenderError;
use crate::maps::MapKind;
use crate::screen_blur::{BlurName, DEFAULT_BASE};
use crate::technique::TechniqueSpec;
use crate::voxel::VoxelSettings;

/// An entry of the list of techniques.
#[derive(Debug)]
pub struct TechniqueEntry {
    /// The technique's name.
    pub name: &'static str,
    /// Summary in one line.
    pub summary: &'static str,
    traits: fn(&TechniqueSpec) -> Traits,
    pub(super) kind: Kind,
}

/// How a technique is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    NoShadows,
    Map(MapKind),
    Hybrid,
    Blur(BlurName),
    Voxel,
    VoxelCsm,
    Cubes { from_texture: bool },
    Truth,
}

/// Every technique, ray tracing last.
pub const TECHNIQUES: &[TechniqueEntry] = &[
    entry("none", "no shadows", Kind::NoShadows, |_| Traits::DRAWN),
    entry("sm", "shadow map, nearest texel", Kind::Map(MapKind::NEAREST), |_| Traits::DRAWN),
    entry(
        "pcf",
        "shadow map, percentage-closer filtering; filter=2 is the sampler's own",
        Kind::Map(MapKind::PCF),
        |_| Traits::DRAWN,
    ),
    entry("pcss", "shadow map, penumbrae of the sun's disc", Kind::Map(MapKind::PCSS), |_| Traits::SOFT),
    entry("vsm", "variance shadow map", Kind::Map(MapKind::VSM), |_| Traits::DRAWN),
    entry("evsm", "exponential variance shadow map", Kind::Map(MapKind::EVSM), |_| Traits::DRAWN),
    entry("msm", "moment shadow map", Kind::Map(MapKind::MSM), |_| Traits::DRAWN),
    entry("csm", "cascades of shadow maps along the view", Kind::Map(MapKind::CSM), |_| Traits::DRAWN),
    entry("csm-vsm", "cascades of variance shadow maps", Kind::Map(MapKind::CSM_VSM), |_| Traits::DRAWN),
    entry("csm-evsm", "cascades of exponential variance shadow maps", Kind::Map(MapKind::CSM_EVSM), |_| {
        Traits::DRAWN
    }),
    entry("hrsm", "hybrid-resolution shadow map: hrsm:START-TARGET texels per side", Kind::Hybrid, |_| {
        Traits::DRAWN
    }),
    entry(
        "blur",
        "another technique's factor, blurred in screen space",
        Kind::Blur(BlurName::Plain),
        from_blur,
    ),
    entry(
        "blur-dilate",
        "another technique's factor, its shadows dilated and then blurred in screen space",
        Kind::Blur(BlurName::Dilated),
        from_blur,
    ),
    entry(
        "blur-bilateral",
        "another technique's factor, blurred in screen space within surfaces",
        Kind::Blur(BlurName::Bilateral),
        from_blur,
    ),
    entry(
        "voxel",
        "a light-aligned file, filtered over texels; voxel:soft, penumbrae (layout depths)",
        Kind::Voxel,
        from_voxel,
    ),
    entry(
        "voxel+csm",
        "a light-aligned file for static casters, cascades for movers: csm=cascades=2/filter=3",
        Kind::VoxelCsm,
        |_| Traits { reads: Reads::LightFile, ..Traits::DRAWN },
    ),
    entry(
        "voxel-cubes",
        "a world-aligned file, filtered over voxels",
        Kind::Cubes { from_texture: false },
        |_| Traits::CUBES,
    ),
    entry(
        "voxel-texture",
        "a world-aligned file, read from an RGBA8 texture",
        Kind::Cubes { from_texture: true },
        |_| Traits::CUBES,
    ),
    entry("truth", "rays, on the CPU", Kind::Truth, |_| Traits::DRAWN),
];

const fn entry(
    name: &'static str,
    summary: &'static str,
    kind: Kind,
    traits: fn(&TechniqueSpec) -> Traits,
) -> TechniqueEntry {
    TechniqueEntry { name, summary, traits, kind }
}

impl TechniqueEntry {
    /// Returns the technique of this name, if there is one.
    fn find(name: &str) -> Option<&'static Self> {
        TECHNIQUES.iter().find(|t| t.name == name)
    }

    /// Whether it is a reference that others are measured against (no shadows, or ray tracing), not a shadow technique.
    pub fn is_reference(&self) -> bool {
        matches!(self.kind, Kind::NoShadows | Kind::Truth)
    }

    /// Whether its factors are ray-traced on the CPU, so that [`super::build()`] cannot build it.
    pub fn is_traced(&self) -> bool {
        self.kind == Kind::Truth
    }

    /// Whether its factor can be blurred in screen space.
    pub fn can_be_blurred(&self) -> bool {
        !matches!(self.kind, Kind::Blur(_) | Kind::Truth)
    }

    /// Whether it blurs the factor of another technique.
    fn blurs(&self) -> bool {
        matches!(self.kind, Kind::Blur(_))
    }
}

impl TechniqueSpec {
    /// The registry's entry of this name, or `None` if the name does not exist.
    pub(super) fn entry(&self) -> Option<&'static TechniqueEntry> {
        TechniqueEntry::find(self.name())
    }

    /// Returns the technique that performs the look-up: for a blur, the technique that it blurs.
    pub(super) fn innermost(&self) -> Self {
        if !self.entry().is_some_and(TechniqueEntry::blurs) {
            return self.clone();
        }
        let base = self.value("base").unwrap_or(DEFAULT_BASE);
        base.replace('/', ":").parse().unwrap_or_else(|_| self.clone())
    }

    /// Properties that are known without a device. For a name that does not exist, those of most techniques.
    pub(super) fn traits(&self) -> Traits {
        self.entry().map_or(Traits::DRAWN, |entry| (entry.traits)(self))
    }
}

fn from_voxel(spec: &TechniqueSpec) -> Traits {
    let soft = Traits { reads: Reads::LightDepths, shows_movers: false, ..Traits::SOFT };
    let hard = Traits { reads: Reads::LightFile, shows_movers: false, ..Traits::DRAWN };
    if VoxelSettings::has_penumbrae(spec) { soft } else { hard }
}

/// Returns the traits of a blur. It widens edges as the sun's disc does, whatever it blurs.
fn from_blur(spec: &TechniqueSpec) -> Traits {
    let base = spec.innermost();
    let of_base = if base.entry().is_some_and(TechniqueEntry::blurs) { Traits::DRAWN } else { base.traits() };
    Traits { truth: Truth::SunDisc, ..of_base }
}

/// Returns the error for a name that is not in [`TECHNIQUES`].
pub(super) fn unknown(spec: &TechniqueSpec) -> RenderError {
    let names: Vec<&str> = TECHNIQUES.iter().map(|t| t.name).collect();
    spec.wrong(format!("unknown technique; choose one of: {}", names.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn registry_has_each_name_once() {
        for (i, entry) in TECHNIQUES.iter().enumerate() {
            assert!(TECHNIQUES[..i].iter().all(|t| t.name != entry.name), "{}", entry.name);
            assert!(!entry.summary.is_empty() && !entry.summary.contains('\n'), "{}", entry.name);
            assert_eq!(TechniqueEntry::find(entry.name).unwrap().kind, entry.kind);
        }
    }
}
