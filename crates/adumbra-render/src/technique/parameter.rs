//! A parameter of a technique as data, for help, sliders and tests. Recorded while settings are read
//! ([`super::SpecReader`]).

use std::ops::RangeInclusive;

use super::SpecText;
use crate::error::Result;

/// Lists of choices longer than this are abbreviated in help.
const MAX_LISTED: usize = 6;
/// Largest factor by which a slider departs from a number's default, if the range is wider than that.
const USUAL_FACTOR: f64 = 100.0;

/// The values that a parameter accepts.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterKind {
    /// A number.
    Number {
        /// Least and greatest value.
        range: RangeInclusive<f64>,
    },
    /// A whole number.
    Count {
        /// Least and greatest value.
        range: RangeInclusive<u32>,
    },
    /// One of several whole numbers.
    Integer {
        /// The choices, in display order.
        choices: Vec<u32>,
    },
    /// One of several words.
    Word {
        /// The choices, in display order.
        choices: Vec<&'static str>,
    },
    /// Another technique, written with `/` for `:`.
    Technique {
        /// The technique whose parameters the value lists. `None` if the value starts with a technique's
        /// name.
        of: Option<&'static str>,
    },
}

/// A parameter that applies to a technique with its present parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Key by which the parameter is set.
    pub key: &'static str,
    /// Description with unit, in one line.
    pub what: &'static str,
    /// The values that it accepts.
    pub kind: ParameterKind,
    /// Present value.
    pub value: String,
    /// Value if none is given, which may depend on other parameters. Empty if no value expresses it.
    pub default: String,
}

impl Parameter {
    /// Whether the value equals the default: the same number, or the same text.
    pub fn is_default(&self) -> bool {
        match (self.value.parse::<f64>(), self.default.parse::<f64>()) {
            (Ok(value), Ok(default)) => value == default,
            _ => self.value == self.default,
        }
    }

    /// Returns the range of a slider for a number, and whether the slider should be logarithmic. A
    /// [`ParameterKind::Number`] whose range extends beyond 100 times a positive default gets at most a
    /// factor of 100 to either side of the default. Everything else gets its whole range. `None` if the
    /// parameter is not a number.
    pub fn slider(&self) -> Option<(RangeInclusive<f64>, bool)> {
        let (from, to) = match &self.kind {
            ParameterKind::Number { range } => (*range.start(), *range.end()),
            ParameterKind::Count { range } => {
                return Some((f64::from(*range.start())..=f64::from(*range.end()), false));
            }
            _ => return None,
        };
        let default = self.default.parse().unwrap_or(0.0);
        if default > 0.0 && to > USUAL_FACTOR * default {
            return Some((from.max(default / USUAL_FACTOR)..=USUAL_FACTOR * default, true));
        }
        Some((from..=to, from > 0.0 && to > USUAL_FACTOR * from))
    }

    /// Returns the technique that the value describes. `None` if the parameter does not take a technique.
    ///
    /// # Errors
    /// Returns [`crate::RenderError::Technique`] if the value does not parse as a technique.
    pub fn nested(&self) -> Result<Option<SpecText>> {
        let ParameterKind::Technique { of } = self.kind else { return Ok(None) };
        nested(of, &self.value).map(Some)
    }

    /// Writes the technique `spec` as a value of this parameter: the inverse of [`Parameter::nested`].
    pub fn nest(&self, spec: &SpecText) -> String {
        let text = spec.to_string().replace(':', "/");
        match self.kind {
            ParameterKind::Technique { of: Some(name) } => {
                text.strip_prefix(name).map_or("", |rest| rest.trim_start_matches('/')).to_owned()
            }
            _ => text,
        }
    }

    /// Returns `key=default` and the other accepted values, as shown in help.
    pub(crate) fn help(&self) -> String {
        let Self { key, default, .. } = self;
        match &self.kind {
            ParameterKind::Number { range } => {
                format!("{key}={default} ({} to {})", short(*range.start()), short(*range.end()))
            }
            ParameterKind::Count { range } => {
                format!("{key}={default} ({} to {})", range.start(), range.end())
            }
            ParameterKind::Integer { choices } => {
                self.listed(&choices.iter().map(u32::to_string).collect::<Vec<_>>())
            }
            ParameterKind::Word { choices } => {
                self.listed(&choices.iter().map(|&c| c.to_owned()).collect::<Vec<_>>())
            }
            ParameterKind::Technique { of: Some(name) } => {
                format!("{key}={default} (parameters of {name}, / for :)")
            }
            ParameterKind::Technique { of: None } => format!("{key}={default} (a technique, / for :)"),
        }
    }

    fn listed(&self, choices: &[String]) -> String {
        let Self { key, default, .. } = self;
        match choices {
            [first, second, .., last] if choices.len() > MAX_LISTED => {
                format!("{key}={default} (one of {first}, {second} .. {last})")
            }
            _ => {
                let others: Vec<&str> = choices.iter().map(String::as_str).filter(|c| c != default).collect();
                match others.split_last() {
                    Some((last, [])) => format!("{key}={default} or {last}"),
                    Some((last, rest)) => format!("{key}={default}, {} or {last}", rest.join(", ")),
                    None => format!("{key}={default}"),
                }
            }
        }
    }
}

/// Parses `value` as a technique written with `/` for `:`. `of` is the technique's name if the value does not
/// contain it.
pub(super) fn nested(of: Option<&str>, value: &str) -> Result<SpecText> {
    let text = value.replace('/', ":");
    match of {
        Some(name) if text.is_empty() => name.parse(),
        Some(name) => format!("{name}:{text}").parse(),
        None => text.parse(),
    }
}

/// Formats a number, in scientific notation if that is much shorter.
fn short(value: f64) -> String {
    let (plain, power) = (value.to_string(), format!("{value:e}"));
    if power.len() + 2 < plain.len() { power } else { plain }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Asserts that a technique accepts the defaults and range ends of its described parameters and rejects
    /// values beyond them, and that each parameter has a line of help.
    pub(crate) fn holds(spec: &SpecText, describe: impl Fn(&SpecText) -> Result<Vec<Parameter>>) {
        let plain = describe(spec).unwrap();
        for p in &plain {
            let parameter = format!("{spec}: {}: {}", p.help(), p.what);
            let takes = |value: &str| describe(&spec.with(p.key, Some(value))).is_ok();
            assert!(
                !p.what.is_empty() && !p.what.contains('\n') && p.is_default() != spec.value(p.key).is_some(),
                "{parameter}"
            );
            if !p.default.is_empty() {
                let same = describe(&spec.with(p.key, Some(&p.default)));
                assert!(spec.value(p.key).is_some() || same.unwrap() == plain, "{parameter}");
            }
            let ends = |ends: [f64; 2]| {
                assert!(ends.iter().all(|e| takes(&e.to_string())), "{parameter}");
                assert!(
                    !takes(&(ends[0] - 1.0).to_string()) && !takes(&(ends[1] * 1.01 + 1.0).to_string()),
                    "{parameter}"
                );
            };
            match &p.kind {
                ParameterKind::Number { range } => ends([*range.start(), *range.end()]),
                ParameterKind::Count { range } => {
                    ends([f64::from(*range.start()), f64::from(*range.end())]);
                    assert!(!takes(&format!("{}.5", range.start())), "{parameter}");
                }
                ParameterKind::Integer { choices } => {
                    assert!(choices.iter().all(|c| takes(&c.to_string())), "{parameter}");
                    assert!(!takes(&(choices.iter().max().unwrap() + 1).to_string()), "{parameter}");
                }
                ParameterKind::Word { choices } => {
                    assert!(choices.len() > 1 && choices.contains(&p.default.as_str()), "{parameter}");
                    assert!(choices.iter().all(|c| takes(c)), "{parameter}");
                }
                ParameterKind::Technique { .. } => {
                    assert!(p.nested().unwrap().is_some(), "{parameter}");
                    assert!(!takes("zzz=zzz"), "{parameter}");
                }
            }
            assert!(!takes("zzz"), "{parameter}");
        }
    }

    fn number(default: &str, range: RangeInclusive<f64>) -> Parameter {
        let (key, value) = ("x", default.to_owned());
        Parameter { key, what: "", kind: ParameterKind::Number { range }, default: value.clone(), value }
    }

    #[test]
    fn slider_of_a_wide_range_stays_near_the_default() {
        assert_eq!(number("0.5", 0.0..=1.0).slider(), Some((0.0..=1.0, false)));
        assert_eq!(number("0", 0.0..=16.0).slider(), Some((0.0..=16.0, false)));
        assert_eq!(number("2", 0.0..=1e9).slider(), Some((0.02..=200.0, true)));
        assert_eq!(number("", 1e-3..=1e12).slider(), Some((1e-3..=1e12, true)));
    }

    #[test]
    fn is_default_compares_numbers() {
        let p = Parameter { value: "0.50".to_owned(), ..number("0.5", 0.0..=1.0) };
        assert!(p.is_default());
        assert!(!Parameter { value: "0.51".to_owned(), ..p }.is_default());
    }

    #[test]
    fn parameter_nests_a_technique() {
        let spec: SpecText = "csm:cascades=2:filter=3".parse().unwrap();
        for (of, value) in [(Some("csm"), "cascades=2/filter=3"), (None, "csm/cascades=2/filter=3")] {
            let p = Parameter {
                kind: ParameterKind::Technique { of },
                value: value.to_owned(),
                ..number("", 0.0..=1.0)
            };
            assert_eq!(p.nested().unwrap().unwrap(), spec);
            assert_eq!(p.nest(&spec), value);
        }
    }

    #[test]
    fn parameter_s_help_names_default_and_range() {
        assert_eq!(number("0.5", 1e-3..=1e12).help(), "x=0.5 (0.001 to 1e12)");
        let words = |choices: &[&'static str]| {
            Parameter { kind: ParameterKind::Word { choices: choices.into() }, ..number("b", 0.0..=1.0) }
                .help()
        };
        assert_eq!(words(&["a", "b"]), "x=b or a");
        assert_eq!(words(&["a", "b", "c"]), "x=b, a or c");
        assert_eq!(words(&["a", "b", "c", "d", "e", "f", "g"]), "x=b (one of a, b .. g)");
    }
}
