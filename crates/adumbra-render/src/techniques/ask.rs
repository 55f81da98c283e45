//! Properties of a technique that follow from its text, from the registry's entry for its name.

use super::registry::Kind;
use super::traits::{Reads, Truth};
use crate::screen_blur::BlurName;
use crate::technique::TechniqueSpec;

impl TechniqueSpec {
    /// The baked file that the technique reads.
    pub fn reads(&self) -> Reads {
        self.traits().reads
    }

    /// The truth that the technique is compared with.
    pub fn truth(&self) -> Truth {
        self.traits().truth
    }

    /// Whether the technique, or the one that it blurs, has the sun's angle as a parameter.
    fn takes_sun_angle(&self) -> bool {
        self.traits().takes_sun_angle
    }

    /// Whether movers cast shadows, as static objects do.
    pub fn shows_movers(&self) -> bool {
        self.traits().shows_movers
    }

    /// Whether the technique is ray tracing on the CPU, whose factors the renderer receives from outside: see
    /// [`crate::Given`].
    pub fn is_traced(&self) -> bool {
        self.kind() == Some(Kind::Truth)
    }

    /// Whether the technique consists of cascaded shadow maps alone.
    pub fn is_cascades(&self) -> bool {
        matches!(self.kind(), Some(Kind::Map(map)) if map.has_cascades())
    }

    /// The kind of blur, if the technique blurs another technique's factor.
    pub(super) fn blur(&self) -> Option<BlurName> {
        match self.kind() {
            Some(Kind::Blur(name)) => Some(name),
            _ => None,
        }
    }

    fn kind(&self) -> Option<Kind> {
        self.entry().map(|entry| entry.kind)
    }

    /// Returns this technique with the sun's full angle set, if it has that parameter and does not set it already. For
    /// a blur, the angle is set on its base.
    pub fn with_sun_angle(&self, degrees: f64) -> Self {
        if !self.takes_sun_angle() {
            return self.clone();
        }
        if self.blur().is_some() {
            let base = self.innermost().with_sun_angle(degrees).to_string();
            return self.with("base", Some(&base));
        }
        if self.value("angle").is_some() {
            return self.clone();
        }
        self.extended("angle", &degrees.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::techniques::{Baked, TECHNIQUES, describe};

    fn spec(text: &str) -> TechniqueSpec {
        text.parse().unwrap()
    }

    #[test]
    fn sun_angle_reaches_every_technique_that_takes_one() {
        let of = |text: &str| text.parse::<TechniqueSpec>().unwrap().with_sun_angle(3.0).to_string();
        for (text, expected) in [
            ("pcss", "pcss:angle=3"),
            ("pcss:angle=2", "pcss:angle=2"),
            ("voxel:soft", "voxel:soft:angle=3"),
            ("voxel:filter=5", "voxel:filter=5"),
            ("blur:base=pcss", "blur:base=pcss/angle=3"),
            ("voxel:shade=soft:bias=2", "voxel:shade=soft:bias=2:angle=3"),
            ("voxel:soft:angle=1", "voxel:soft:angle=1"),
            ("blur:base=voxel/soft", "blur:base=voxel/soft/angle=3"),
            ("blur:base=pcss/angle=1", "blur:base=pcss/angle=1"),
            ("blur:base=csm/size=1024", "blur:base=csm/size=1024"),
            ("blur", "blur"),
            ("csm", "csm"),
        ] {
            assert_eq!(of(text), expected);
        }
    }

    #[test]
    fn registry_s_sun_angle_is_a_parameter_and_means_the_disc() {
        for name in TECHNIQUES.iter().map(|t| t.name).chain(["voxel:soft", "blur:base=voxel/soft"]) {
            let spec = spec(name);
            let inner = spec.innermost();
            let parameters = describe(&inner, Baked::default()).unwrap();
            let has_angle = parameters.iter().any(|p| p.key == "angle");
            assert_eq!(has_angle, spec.takes_sun_angle(), "{name}");
            assert_eq!(spec.truth() == Truth::SunDisc, has_angle || spec.blur().is_some(), "{name}");
        }
    }

    #[test]
    fn registry_knows_what_is_read() {
        for (text, reads) in [
            ("csm", Reads::Nothing),
            ("truth", Reads::Nothing),
            ("blur", Reads::Nothing),
            ("voxel", Reads::LightFile),
            ("voxel:shade=hard", Reads::LightFile),
            ("voxel:soft", Reads::LightDepths),
            ("voxel+csm:csm=cascades=2", Reads::LightFile),
            ("voxel-cubes", Reads::TreeFile),
            ("voxel-texture:read=buffer", Reads::TreeFile),
            ("blur:base=voxel/soft", Reads::LightDepths),
            ("blur-dilate:base=voxel-cubes/filter=5", Reads::TreeFile),
        ] {
            assert_eq!(spec(text).reads(), reads, "{text}");
        }
    }

    #[test]
    fn registry_knows_which_baked_shadows_leave_movers_out() {
        for (text, shows) in [
            ("csm", true),
            ("none", true),
            ("truth", true),
            ("voxel", false),
            ("voxel:soft", false),
            ("voxel-texture", false),
            ("voxel+csm", true),
            ("blur:base=voxel", false),
            ("blur:base=voxel+csm", true),
        ] {
            assert_eq!(spec(text).shows_movers(), shows, "{text}");
        }
    }

    #[test]
    fn registry_gives_unknown_names_nothing_to_read() {
        let unknown = spec("unknown:angle=3");
        assert_eq!((unknown.reads(), unknown.truth()), (Reads::Nothing, Truth::HardSun));
        assert_eq!(unknown.with_sun_angle(2.0), unknown);
        assert!(describe(&unknown, Baked::default()).unwrap_err().to_string().contains("voxel+csm"));
    }
}
