//! Techniques as text: `NAME[:key=value…]`, such as `csm:cascades=4:size=2048:filter=5`. Two sizes without a
//! key, such as `4096-1024` in `hrsm:4096-1024`, are short for `sizes=4096-1024`; `soft` in
//! `voxel:soft` is short for `shade=soft`, and `path` in `voxel:path` for `shade=path`.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use crate::error::{RenderError, Result};

/// A technique's name and the parameters that were given.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SpecText {
    name: String,
    values: BTreeMap<String, String>,
    text: String,
}

impl FromStr for SpecText {
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
                shade if is_shade(shade) => Some(("shade", part)),
                _ => is_sizes(part).then_some(("sizes", part)),
            };
            let pair = part.split_once('=').or_else(short);
            let Some((key, value)) = pair else {
                return Err(wrong(format!("{part:?} is not key=value and not two sizes such as 4096-1024")));
            };
            if values.insert(key.trim().to_lowercase(), value.trim().to_lowercase()).is_some() {
                return Err(wrong(format!("{key:?} is given twice")));
            }
        }
        Ok(Self { name, values, text: text.to_owned() })
    }
}

/// Whether a word may be written without its key, `shade`.
fn is_shade(word: &str) -> bool {
    ["soft", "path"].contains(&word)
}

fn is_sizes(part: &str) -> bool {
    let is_number = |s: &str| !s.is_empty() && s.bytes().all(|b| b.is_ascii_digit());
    part.trim().split_once('-').is_some_and(|(a, b)| is_number(a) && is_number(b))
}

impl fmt::Display for SpecText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl SpecText {
    /// The technique's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The given value of a parameter.
    pub fn value(&self, key: &str) -> Option<&str> {
        self.values.get(key).map(String::as_str)
    }

    /// The keys of the given parameters, sorted.
    pub(super) fn keys(&self) -> impl Iterator<Item = &str> {
        self.values.keys().map(String::as_str)
    }

    /// Returns this technique with a parameter set to another value, or removed for `None`. The text is
    /// rewritten with parameters sorted by key. Whether the parameter and the value exist is not checked: see
    /// [`crate::TechniqueSpec::change`].
    pub fn with(&self, key: &str, value: Option<&str>) -> Self {
        let mut values = self.values.clone();
        let key = key.trim().to_lowercase();
        match value {
            // Within a value, `/` replaces `:`.
            Some(value) => values.insert(key, value.trim().to_lowercase().replace(':', "/")),
            None => values.remove(&key),
        };
        let pair = |(key, value): (&String, &String)| match key.as_str() {
            "sizes" if is_sizes(value) => format!(":{value}"),
            "shade" if is_shade(value) => format!(":{value}"),
            _ => format!(":{key}={value}"),
        };
        let text = self.name.clone() + &values.iter().map(pair).collect::<String>();
        Self { name: self.name.clone(), values, text }
    }

    /// Returns this technique with one more parameter, at the end of its text.
    pub(crate) fn extended(&self, key: &str, value: &str) -> Self {
        let mut extended = self.clone();
        extended.values.insert(key.to_owned(), value.to_owned());
        extended.text = format!("{self}:{key}={value}");
        extended
    }

    /// Returns an error about this technique.
    pub fn wrong(&self, reason: String) -> RenderError {
        RenderError::Technique { name: self.text.clone(), reason }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spec_errors_name_the_fault() {
        let wrong = |text: &str| text.parse::<SpecText>().unwrap_err().to_string();
        assert!(wrong("pcf:5").contains("not key=value"));
        assert!(wrong("pcf:a=1:a=2").contains("twice"));
        assert!(wrong("hrsm:4096-1024:sizes=2048-1024").contains("twice"));
        assert!(wrong("hrsm:4096-").contains("not key=value"));
        assert!(wrong("").contains("no name"));
    }

    #[test]
    fn with_gives_a_sorted_text_that_parses_to_the_same() {
        let spec: SpecText = "CSM: size = 1024:split=Uniform".parse().unwrap();
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
            assert_eq!(text.parse::<SpecText>().unwrap(), changed);
        }
        for (text, key, value, expected) in [
            ("hrsm", "sizes", Some("2048-512"), "hrsm:2048-512"),
            ("hrsm:2048-512:filter=3", "filter", None, "hrsm:2048-512"),
            ("voxel", "shade", Some("soft"), "voxel:soft"),
            ("voxel:soft", "sun-degrees", Some("2"), "voxel:soft:sun-degrees=2"),
            ("voxel:soft", "shade", None, "voxel"),
            ("voxel:path:filter=3", "filter", Some("1"), "voxel:filter=1:path"),
        ] {
            let changed = text.parse::<SpecText>().unwrap().with(key, value);
            assert_eq!(changed.to_string(), expected);
            assert_eq!(expected.parse::<SpecText>().unwrap(), changed);
        }
    }
}
