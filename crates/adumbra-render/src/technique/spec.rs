//! Techniques by name: `NAME[:key=value…]`, such as `csm:cascades=4:size=2048:filter=5`. Two sizes alone, such as the `4096-1024` of
//! `hrsm:4096-1024`, are short for `sizes=4096-1024`; the `soft` of `voxel:soft` is short for `shade=soft`.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

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
    /// The technique's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Reads the parameters, one after the other.
    pub fn reader(&self) -> SpecReader<'_> {
        SpecReader { spec: self, asked: Vec::new() }
    }

    /// An error about this technique.
    pub fn wrong(&self, reason: String) -> RenderError {
        RenderError::Technique { name: self.text.clone(), reason }
    }
}

/// Reads parameters and remembers which were asked for.
pub struct SpecReader<'s> {
    spec: &'s TechniqueSpec,
    asked: Vec<&'static str>,
}

impl<'s> SpecReader<'s> {
    /// A word among `choices`; the first is the default.
    ///
    /// # Errors
    /// [`RenderError::Technique`] for any other.
    pub fn choice(&mut self, key: &'static str, choices: &[&'static str]) -> Result<&'static str> {
        let Some(value) = self.text(key) else { return Ok(choices.first().copied().unwrap_or_default()) };
        let found = choices.iter().copied().find(|c| *c == value);
        found.ok_or_else(|| self.spec.wrong(format!("{key}={value}: give {}", choices.join(", "))))
    }

    /// A number within `range`.
    ///
    /// # Errors
    /// [`RenderError::Technique`] for one outside, or no number.
    pub fn number(
        &mut self,
        key: &'static str,
        default: f64,
        range: std::ops::RangeInclusive<f64>,
    ) -> Result<f64> {
        let Some(value) = self.text(key) else { return Ok(default) };
        let wrong = || {
            let (from, to) = (range.start(), range.end());
            self.spec.wrong(format!("{key}={value}: give a number from {from} to {to}"))
        };
        value.parse().ok().filter(|n| range.contains(n)).ok_or_else(wrong)
    }

    /// One of `words`, as its place among them; a number within `range` where there are none.
    ///
    /// # Errors
    /// [`RenderError::Technique`] for any other.
    pub fn number_or_word(
        &mut self,
        key: &'static str,
        default: f64,
        range: std::ops::RangeInclusive<f64>,
        words: &[&'static str],
    ) -> Result<f64> {
        if words.is_empty() {
            return self.number(key, default, range);
        }
        let Some(value) = self.text(key) else { return Ok(default) };
        let place = words.iter().position(|w| *w == value);
        let wrong = || self.spec.wrong(format!("{key}={value}: give {}", words.join(", ")));
        place.map(|p| p as f64).ok_or_else(wrong)
    }

    /// A whole number among `choices`.
    ///
    /// # Errors
    /// [`RenderError::Technique`] for any other.
    pub fn integer(&mut self, key: &'static str, default: u32, choices: &[u32]) -> Result<u32> {
        let Some(value) = self.text(key) else { return Ok(default) };
        let wrong = || self.spec.wrong(format!("{key}={value}: give one of {choices:?}"));
        value.parse().ok().filter(|n| choices.contains(n)).ok_or_else(wrong)
    }

    /// A whole number within `range`.
    ///
    /// # Errors
    /// [`RenderError::Technique`] for one outside, or no number.
    pub fn count(
        &mut self,
        key: &'static str,
        default: u32,
        range: std::ops::RangeInclusive<u32>,
    ) -> Result<u32> {
        let Some(value) = self.text(key) else { return Ok(default) };
        let wrong = || {
            let (from, to) = (range.start(), range.end());
            self.spec.wrong(format!("{key}={value}: give a whole number from {from} to {to}"))
        };
        value.parse().ok().filter(|n| range.contains(n)).ok_or_else(wrong)
    }

    /// The text given for a key.
    pub fn text(&mut self, key: &'static str) -> Option<&'s str> {
        self.asked.push(key);
        self.spec.values.get(key).map(String::as_str)
    }

    /// Whether every parameter given was asked for.
    ///
    /// # Errors
    /// [`RenderError::Technique`] with the first that was not, and those that are.
    pub fn finish(self) -> Result<()> {
        let Some(unknown) = self.spec.values.keys().find(|k| !self.asked.contains(&k.as_str())) else {
            return Ok(());
        };
        let known = if self.asked.is_empty() { "none".to_owned() } else { self.asked.join(", ") };
        Err(self.spec.wrong(format!("it has no parameter {unknown:?}; it has: {known}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spec_reads_what_is_there_and_defaults_for_the_rest() {
        let spec: TechniqueSpec = "CSM:cascades=3:split=Uniform:lambda=0.25".parse().unwrap();
        assert_eq!(spec.name(), "csm");
        let mut reader = spec.reader();
        assert_eq!(reader.count("cascades", 4, 1..=8).unwrap(), 3);
        assert_eq!(reader.integer("size", 2048, &[1024, 2048]).unwrap(), 2048);
        assert_eq!(reader.choice("split", &["practical", "uniform"]).unwrap(), "uniform");
        assert_eq!(reader.number("lambda", 0.5, 0.0..=1.0).unwrap(), 0.25);
        reader.finish().unwrap();
    }

    #[test]
    fn spec_names_what_is_wrong_and_what_would_do() {
        let wrong = |text: &str| text.parse::<TechniqueSpec>().unwrap_err().to_string();
        assert!(wrong("pcf:5").contains("not key=value"));
        assert!(wrong("pcf:a=1:a=2").contains("twice"));
        assert!(wrong("hrsm:4096-1024:sizes=2048-1024").contains("twice"));
        assert!(wrong("hrsm:4096-").contains("not key=value"));
        assert!(wrong("").contains("no name"));
        let spec: TechniqueSpec = "pcf:filter=4:taps=3".parse().unwrap();
        let mut reader = spec.reader();
        let error = reader.integer("filter", 5, &[2, 3, 5, 7]).unwrap_err().to_string();
        assert!(error.contains("[2, 3, 5, 7]"), "{error}");
        let error = reader.finish().unwrap_err().to_string();
        assert!(error.contains("taps") && error.contains("filter"), "{error}");
    }
}
