//! Techniques by name: `NAME[:key=value…]`, such as `csm:cascades=4:size=2048:filter=5`. Two sizes alone, such as the `4096-1024` of
//! `hrsm:4096-1024`, are short for `sizes=4096-1024`; the `soft` of `voxel:soft` is short for `shade=soft`.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use super::SpecReader;
use crate::error::{RenderError, Result};

/// A technique's name and what was said of its parameters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TechniqueSpec {
    name: String,
    values: BTreeMap<String, String>,
    text: String,
}

impl FromStr for TechniqueSpec {
    type Err = RenderError;

    fn from_str(text: &str) -> Result<Self> {
        let wrong = |reason: String| RenderError::Technique { name: text.to_owned(), reason };
        let mut parts = text.split(':');
        let name = parts.next().unwrap_or_default().trim().to_lowercase();
        if name.is_empty() {
            return Err(wrong("it has no name".to_owned()));
        }
        let mut values = BTreeMap::new();
        for part in parts {
            let short = || match part.trim() {
                "soft" => Some(("shade", part)),
                _ => is_sizes(part).then_some(("sizes", part)),
            };
            let pair = part.split_once('=').or_else(short);
            let Some((key, value)) = pair else {
                return Err(wrong(format!("{part:?} is not key=value, nor two sizes such as 4096-1024")));
            };
            if values.insert(key.trim().to_lowercase(), value.trim().to_lowercase()).is_some() {
                return Err(wrong(format!("{key:?} is given twice")));
            }
        }
        Ok(Self { name, values, text: text.to_owned() })
    }
}

fn is_sizes(part: &str) -> bool {
    let is_number = |s: &str| !s.is_empty() && s.bytes().all(|b| b.is_ascii_digit());
    part.trim().split_once('-').is_some_and(|(a, b)| is_number(a) && is_number(b))
}

impl fmt::Display for TechniqueSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl TechniqueSpec {
    /// The technique that looks up: of a blur the one that it blurs.
    pub fn innermost(&self) -> Self {
        let base = self.value("base").filter(|_| self.blurs());
        base.and_then(|base| base.replace('/', ":").parse().ok()).unwrap_or_else(|| self.clone())
    }

    /// Whether it blurs another technique's factor on the screen.
    fn blurs(&self) -> bool {
        self.name.starts_with("blur")
    }

    /// Whether it asks a baked file for penumbrae, which only the layout hierarchy answers.
    pub fn needs_hierarchy(&self) -> bool {
        let inner = self.innermost();
        inner.name == "voxel" && inner.value("shade") == Some("soft")
    }

    /// Whether it sets out to show the penumbrae of the sun's disc, so that the disc judges it. All others answer for the sun's middle: their
    /// filters only smooth the edge.
    pub fn shows_disc(&self) -> bool {
        self.blurs() || self.name == "pcss" || self.needs_hierarchy()
    }

    /// This technique for a sun of this full angle, degrees, where it has an angle and names no other.
    ///
    /// # Errors
    /// None that its own text has not.
    pub fn for_sun_angle(&self, angle_degrees: f64) -> Result<Self> {
        if self.blurs() {
            let base = self.innermost();
            if base.blurs() || !base.shows_disc() {
                return Ok(self.clone());
            }
            let base = base.for_sun_angle(angle_degrees)?.to_string().replace(':', "/");
            return Ok(self.with("base", Some(&base)));
        }
        if !self.shows_disc() || self.value("angle").is_some() {
            return Ok(self.clone());
        }
        format!("{self}:angle={angle_degrees}").parse()
    }

    /// The technique's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What was said of a parameter.
    pub fn value(&self, key: &str) -> Option<&str> {
        self.values.get(key).map(String::as_str)
    }

    /// What was said, by key.
    pub(super) fn keys(&self) -> impl Iterator<Item = &str> {
        self.values.keys().map(String::as_str)
    }

    /// The same with another value of a parameter, or with nothing said of it; its text is written anew, parameters by their names. Whether
    /// there is such a parameter or value is not asked: see [`super::change`].
    pub fn with(&self, key: &str, value: Option<&str>) -> Self {
        let mut values = self.values.clone();
        let key = key.trim().to_lowercase();
        match value {
            // Within a value `/` stands for `:`.
            Some(value) => values.insert(key, value.trim().to_lowercase().replace(':', "/")),
            None => values.remove(&key),
        };
        let pair = |(key, value): (&String, &String)| match key.as_str() {
            "sizes" if is_sizes(value) => format!(":{value}"),
            "shade" if value == "soft" => ":soft".to_owned(),
            _ => format!(":{key}={value}"),
        };
        let text = self.name.clone() + &values.iter().map(pair).collect::<String>();
        Self { name: self.name.clone(), values, text }
    }

    /// Reads the parameters, one after the other.
    pub fn reader(&self) -> SpecReader<'_> {
        SpecReader::new(self)
    }

    /// An error about this technique.
    pub fn wrong(&self, reason: String) -> RenderError {
        RenderError::Technique { name: self.text.clone(), reason }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spec_names_what_is_wrong() {
        let wrong = |text: &str| text.parse::<TechniqueSpec>().unwrap_err().to_string();
        assert!(wrong("pcf:5").contains("not key=value"));
        assert!(wrong("pcf:a=1:a=2").contains("twice"));
        assert!(wrong("hrsm:4096-1024:sizes=2048-1024").contains("twice"));
        assert!(wrong("hrsm:4096-").contains("not key=value"));
        assert!(wrong("").contains("no name"));
    }

    #[test]
    fn spec_with_another_value_is_the_spec_of_its_text() {
        let spec: TechniqueSpec = "CSM: size = 1024:split=Uniform".parse().unwrap();
        for (key, value, text) in [
            ("filter", Some("Poisson"), "csm:filter=poisson:size=1024:split=uniform"),
            ("size", Some("512"), "csm:size=512:split=uniform"),
            ("size", None, "csm:split=uniform"),
            ("Split", None, "csm:size=1024"),
            ("absent", None, "csm:size=1024:split=uniform"),
            ("base", Some("csm:filter=3"), "csm:base=csm/filter=3:size=1024:split=uniform"),
        ] {
            let changed = spec.with(key, value);
            assert_eq!(changed.to_string(), text);
            assert_eq!(text.parse::<TechniqueSpec>().unwrap(), changed);
        }
        for (text, key, value, expected) in [
            ("hrsm", "sizes", Some("2048-512"), "hrsm:2048-512"),
            ("hrsm:2048-512:filter=3", "filter", None, "hrsm:2048-512"),
            ("voxel", "shade", Some("soft"), "voxel:soft"),
            ("voxel:soft", "angle", Some("2"), "voxel:angle=2:soft"),
            ("voxel:soft", "shade", None, "voxel"),
        ] {
            let changed = text.parse::<TechniqueSpec>().unwrap().with(key, value);
            assert_eq!(changed.to_string(), expected);
            assert_eq!(expected.parse::<TechniqueSpec>().unwrap(), changed);
        }
    }

    #[test]
    fn suns_discs_reach_every_technique_that_has_one() {
        let of = |text: &str| text.parse::<TechniqueSpec>().unwrap().for_sun_angle(3.0).unwrap().to_string();
        for (text, expected) in [
            ("pcss", "pcss:angle=3"),
            ("pcss:angle=2", "pcss:angle=2"),
            ("voxel:soft", "voxel:soft:angle=3"),
            ("voxel:filter=5", "voxel:filter=5"),
            ("blur:base=pcss", "blur:base=pcss/angle=3"),
            ("blur:base=csm/size=1024", "blur:base=csm/size=1024"),
            ("csm", "csm"),
        ] {
            assert_eq!(of(text), expected);
        }
    }

    #[test]
    fn what_has_an_angle_shows_the_disc() {
        let soft = ["voxel:soft"];
        for name in crate::TECHNIQUES.iter().map(|t| t.0).chain(soft) {
            let spec: TechniqueSpec = name.parse().unwrap();
            let parameters = crate::technique::describe(&spec, crate::Baked::default()).unwrap();
            let has_angle = parameters.iter().any(|p| p.key == "angle");
            assert_eq!(has_angle, spec.shows_disc() && !spec.blurs(), "{name}");
        }
        let soft: TechniqueSpec = "blur:base=voxel/soft".parse().unwrap();
        assert!(soft.needs_hierarchy() && soft.shows_disc());
    }
}
