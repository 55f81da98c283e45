//! From a technique's text to its settings, one parameter after the other. What is asked for is recorded with its default and range, so
//! that what help and sliders show is what reading takes.

use std::ops::RangeInclusive;

use super::parameter::nested;
use super::{Parameter, ParameterKind, TechniqueSpec};
use crate::error::Result;

/// Reads parameters and remembers what was asked for.
pub struct SpecReader<'s> {
    spec: &'s TechniqueSpec,
    asked: Vec<Parameter>,
}

impl<'s> SpecReader<'s> {
    pub(super) fn new(spec: &'s TechniqueSpec) -> Self {
        Self { spec, asked: Vec::new() }
    }

    /// What is read.
    pub fn spec(&self) -> &'s TechniqueSpec {
        self.spec
    }

    /// A word among `choices`; the first is the default.
    ///
    /// # Errors
    /// [`crate::RenderError::Technique`] for any other.
    pub fn choice(
        &mut self,
        key: &'static str,
        what: &'static str,
        choices: &[&'static str],
    ) -> Result<&'static str> {
        let default = choices.first().copied().unwrap_or_default();
        let kind = ParameterKind::Word { choices: choices.into() };
        let Some(value) = self.ask(key, what, kind, default.to_owned()) else { return Ok(default) };
        let found = choices.iter().copied().find(|c| *c == value);
        found.ok_or_else(|| self.spec.wrong(format!("{key}={value}: give {}", choices.join(", "))))
    }

    /// A number within `range`.
    ///
    /// # Errors
    /// [`crate::RenderError::Technique`] for one outside, or no number.
    pub fn number(
        &mut self,
        key: &'static str,
        what: &'static str,
        default: f64,
        range: RangeInclusive<f64>,
    ) -> Result<f64> {
        Ok(self.number_or(key, what, default.to_string(), range)?.unwrap_or(default))
    }

    /// A number within `range`, or none, which is something else than every number.
    ///
    /// # Errors
    /// As [`SpecReader::number`].
    pub fn optional_number(
        &mut self,
        key: &'static str,
        what: &'static str,
        range: RangeInclusive<f64>,
    ) -> Result<Option<f64>> {
        self.number_or(key, what, String::new(), range)
    }

    fn number_or(
        &mut self,
        key: &'static str,
        what: &'static str,
        default: String,
        range: RangeInclusive<f64>,
    ) -> Result<Option<f64>> {
        let kind = ParameterKind::Number { range: range.clone() };
        let Some(value) = self.ask(key, what, kind, default) else { return Ok(None) };
        let wrong = || {
            let (from, to) = (range.start(), range.end());
            self.spec.wrong(format!("{key}={value}: give a number from {from} to {to}"))
        };
        value.parse().ok().filter(|n| range.contains(n)).map(Some).ok_or_else(wrong)
    }

    /// One of `words`, as its place among them.
    ///
    /// # Errors
    /// [`crate::RenderError::Technique`] for any other.
    pub fn place(
        &mut self,
        key: &'static str,
        what: &'static str,
        default: usize,
        words: &[&'static str],
    ) -> Result<usize> {
        let kind = ParameterKind::Word { choices: words.into() };
        let word = words.get(default).copied().unwrap_or_default();
        let Some(value) = self.ask(key, what, kind, word.to_owned()) else { return Ok(default) };
        let place = words.iter().position(|w| *w == value);
        place.ok_or_else(|| self.spec.wrong(format!("{key}={value}: give {}", words.join(", "))))
    }

    /// A whole number among `choices`.
    ///
    /// # Errors
    /// [`crate::RenderError::Technique`] for any other.
    pub fn integer(
        &mut self,
        key: &'static str,
        what: &'static str,
        default: u32,
        choices: &[u32],
    ) -> Result<u32> {
        let kind = ParameterKind::Integer { choices: choices.into() };
        let Some(value) = self.ask(key, what, kind, default.to_string()) else { return Ok(default) };
        let wrong = || self.spec.wrong(format!("{key}={value}: give one of {choices:?}"));
        value.parse().ok().filter(|n| choices.contains(n)).ok_or_else(wrong)
    }

    /// A whole number within `range`.
    ///
    /// # Errors
    /// [`crate::RenderError::Technique`] for one outside, or no number.
    pub fn count(
        &mut self,
        key: &'static str,
        what: &'static str,
        default: u32,
        range: RangeInclusive<u32>,
    ) -> Result<u32> {
        let kind = ParameterKind::Count { range: range.clone() };
        let Some(value) = self.ask(key, what, kind, default.to_string()) else { return Ok(default) };
        let wrong = || {
            let (from, to) = (range.start(), range.end());
            self.spec.wrong(format!("{key}={value}: give a whole number from {from} to {to}"))
        };
        value.parse().ok().filter(|n| range.contains(n)).ok_or_else(wrong)
    }

    /// Another technique, with `/` for `:`: the parameters of technique `of`, or, where that is none, name and parameters.
    ///
    /// # Errors
    /// [`crate::RenderError::Technique`] for what is not written so; what it says is not read.
    pub fn technique(
        &mut self,
        key: &'static str,
        what: &'static str,
        of: Option<&'static str>,
        default: &'static str,
    ) -> Result<TechniqueSpec> {
        let value = self.ask(key, what, ParameterKind::Technique { of }, default.to_owned());
        nested(of, value.unwrap_or(default))
    }

    fn ask(
        &mut self,
        key: &'static str,
        what: &'static str,
        kind: ParameterKind,
        default: String,
    ) -> Option<&'s str> {
        let given = self.spec.value(key);
        let value = given.map_or_else(|| default.clone(), str::to_owned);
        self.asked.push(Parameter { key, what, kind, value, default });
        given
    }

    /// What was asked for so far.
    pub fn asked(&self) -> &[Parameter] {
        &self.asked
    }

    /// Whether every parameter given was asked for: all that were.
    ///
    /// # Errors
    /// [`crate::RenderError::Technique`] with the first that was not, and those that are.
    pub fn finish(self) -> Result<Vec<Parameter>> {
        let Some(unknown) = self.spec.keys().find(|k| self.asked.iter().all(|p| p.key != *k)) else {
            return Ok(self.asked);
        };
        let known: Vec<&str> = self.asked.iter().map(|p| p.key).collect();
        let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
        Err(self.spec.wrong(format!("it has no parameter {unknown:?}; it has: {known}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reader_takes_what_is_there_and_defaults_for_the_rest() {
        let spec: TechniqueSpec =
            "CSM:cascades=3:split=Uniform:lambda=0.25:base=pcf/filter=3".parse().unwrap();
        assert_eq!(spec.name(), "csm");
        let mut reader = spec.reader();
        assert_eq!(reader.count("cascades", "", 4, 1..=8).unwrap(), 3);
        assert_eq!(reader.integer("size", "", 2048, &[1024, 2048]).unwrap(), 2048);
        assert_eq!(reader.choice("split", "", &["practical", "uniform"]).unwrap(), "uniform");
        assert_eq!(reader.number("lambda", "", 0.5, 0.0..=1.0).unwrap(), 0.25);
        assert_eq!(reader.optional_number("far", "", 1.0..=2.0).unwrap(), None);
        assert_eq!(reader.technique("base", "", None, "sm").unwrap().to_string(), "pcf:filter=3");
        let parameters = reader.finish().unwrap();
        let read: Vec<_> = parameters.iter().map(|p| (p.key, p.value.as_str(), p.default.as_str())).collect();
        let expected = [
            ("cascades", "3", "4"),
            ("size", "2048", "2048"),
            ("split", "uniform", "practical"),
            ("lambda", "0.25", "0.5"),
            ("far", "", ""),
            ("base", "pcf/filter=3", "sm"),
        ];
        assert_eq!(read, expected);
    }

    #[test]
    fn reader_names_what_is_wrong_and_what_would_do() {
        let spec: TechniqueSpec = "pcf:filter=4:taps=3".parse().unwrap();
        let mut reader = spec.reader();
        let error = reader.integer("filter", "", 5, &[2, 3, 5, 7]).unwrap_err().to_string();
        assert!(error.contains("[2, 3, 5, 7]"), "{error}");
        let error = reader.finish().unwrap_err().to_string();
        assert!(error.contains("taps") && error.contains("filter"), "{error}");
    }
}
