//! Reads a technique's settings from its text, parameter by parameter. Each parameter read is recorded with
//! its default and range, so help and sliders show exactly what is accepted.

use std::ops::RangeInclusive;

use super::parameter::nested;
use super::{Parameter, ParameterKind, SpecText};
use crate::error::Result;

/// Reads parameters and records those that were read.
pub struct SpecReader<'s> {
    spec: &'s SpecText,
    asked: Vec<Parameter>,
}

impl SpecText {
    /// Returns a reader of the parameters.
    pub fn reader(&self) -> SpecReader<'_> {
        SpecReader { spec: self, asked: Vec::new() }
    }

    /// Reads all parameters with `read`.
    ///
    /// # Errors
    /// Returns the errors of `read` and of [`SpecReader::finish`].
    pub fn read<T>(&self, read: impl FnOnce(&mut SpecReader<'_>) -> Result<T>) -> Result<T> {
        let mut reader = self.reader();
        let value = read(&mut reader)?;
        reader.finish()?;
        Ok(value)
    }
}

impl<'s> SpecReader<'s> {
    /// The technique whose parameters are read.
    pub fn spec(&self) -> &'s SpecText {
        self.spec
    }

    /// Reads a word, one of `choices`. The first is the default.
    ///
    /// # Errors
    /// Returns [`crate::RenderError::Technique`] for any other word.
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
        found.ok_or_else(|| self.spec.wrong(format!("{key}={value}: choose one of: {}", choices.join(", "))))
    }

    /// Reads a number within `range`.
    ///
    /// # Errors
    /// Returns [`crate::RenderError::Technique`] if the value is not a number or is out of range.
    pub fn number(
        &mut self,
        key: &'static str,
        what: &'static str,
        default: f64,
        range: RangeInclusive<f64>,
    ) -> Result<f64> {
        Ok(self.number_or(key, what, default.to_string(), range)?.unwrap_or(default))
    }

    /// Reads a number within `range`, or `None` if none is given, which differs from every number.
    ///
    /// # Errors
    /// Returns the errors of [`SpecReader::number`].
    pub(crate) fn optional_number(
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

    /// Reads one of `words` and returns its index. `default` is an index too.
    ///
    /// # Errors
    /// Returns [`crate::RenderError::Technique`] for any other word.
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
        place.ok_or_else(|| self.spec.wrong(format!("{key}={value}: choose one of: {}", words.join(", "))))
    }

    /// Reads a whole number, one of `choices`.
    ///
    /// # Errors
    /// Returns [`crate::RenderError::Technique`] for anything else.
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

    /// Reads a whole number within `range`.
    ///
    /// # Errors
    /// Returns [`crate::RenderError::Technique`] if the value is not a whole number or is out of range.
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

    /// Reads another technique, written with `/` for `:`: only the parameters of technique
    /// `of`, or name and parameters if `of` is `None`.
    ///
    /// # Errors
    /// Returns [`crate::RenderError::Technique`] if the value does not parse as a technique. The parameters
    /// within it are not validated.
    pub fn technique(
        &mut self,
        key: &'static str,
        what: &'static str,
        of: Option<&'static str>,
        default: &'static str,
    ) -> Result<SpecText> {
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

    /// The parameters read so far.
    pub fn asked(&self) -> &[Parameter] {
        &self.asked
    }

    /// Checks that every given parameter was read, and returns all parameters that were read.
    ///
    /// # Errors
    /// Returns [`crate::RenderError::Technique`] with the first parameter that was not read and a list of
    /// those that exist.
    pub fn finish(self) -> Result<Vec<Parameter>> {
        let Some(unknown) = self.spec.keys().find(|k| self.asked.iter().all(|p| p.key != *k)) else {
            return Ok(self.asked);
        };
        let known: Vec<&str> = self.asked.iter().map(|p| p.key).collect();
        let known = if known.is_empty() {
            "there are none".to_owned()
        } else {
            format!("choose one of: {}", known.join(", "))
        };
        Err(self.spec.wrong(format!("unknown parameter {unknown:?}; {known}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reader_returns_given_values_and_defaults() {
        let spec: SpecText = "CSM:cascades=3:split=Uniform:lambda=0.25:base=pcf/filter=3".parse().unwrap();
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
    fn reader_errors_name_the_fault_and_the_choices() {
        let spec: SpecText = "pcf:filter=4:taps=3".parse().unwrap();
        let mut reader = spec.reader();
        let error = reader.integer("filter", "", 5, &[2, 3, 5, 7]).unwrap_err().to_string();
        assert!(error.contains("[2, 3, 5, 7]"), "{error}");
        let error = reader.finish().unwrap_err().to_string();
        assert!(error.contains("taps") && error.contains("filter"), "{error}");
    }
}
