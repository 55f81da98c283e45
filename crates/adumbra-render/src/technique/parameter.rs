//! One parameter of a technique as data, recorded while settings are read ([`super::SpecReader`]): for help, sliders and tests.

use std::ops::RangeInclusive;

use super::TechniqueSpec;
use crate::error::Result;

/// Lists longer than this are shown by their ends.
const MOST_LISTED: usize = 6;
/// How far from its default a number is usually looked for, where its range is wider than that.
const USUAL_FACTOR: f64 = 100.0;

/// What a parameter takes.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterKind {
    /// A number.
    Number {
        /// Least and largest.
        range: RangeInclusive<f64>,
    },
    /// A whole number.
    Count {
        /// Least and largest.
        range: RangeInclusive<u32>,
    },
    /// One of some whole numbers.
    Integer {
        /// In the order in which they are shown.
        choices: Vec<u32>,
    },
    /// One of some words.
    Word {
        /// In the order in which they are shown.
        choices: Vec<&'static str>,
    },
    /// Another technique, with `/` for `:`.
    Technique {
        /// The technique whose parameters the value is; none where the value begins with a name of its own.
        of: Option<&'static str>,
    },
}

/// A parameter that applies to a technique as it was called for.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// As it is called for.
    pub key: &'static str,
    /// What it is, with its unit, in one line.
    pub what: &'static str,
    /// What it takes.
    pub kind: ParameterKind,
    /// As it is now.
    pub value: String,
    /// As it is where nothing is said, which may depend on other parameters; empty where that is no value of its own.
    pub default: String,
}

impl Parameter {
    /// Whether it is as where nothing is said: the same number, or the same text.
    pub fn is_default(&self) -> bool {
        match (self.value.parse::<f64>(), self.default.parse::<f64>()) {
            (Ok(value), Ok(default)) => value == default,
            _ => self.value == self.default,
        }
    }

    /// Ends of a slider for a number, and whether it should go by factors: the whole range, but no further than a factor of 100 from a
    /// default that has one. None for what is no number.
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

    /// The technique that its value is; none where it is none, or empty.
    ///
    /// # Errors
    /// [`crate::RenderError::Technique`] for a value that is not written as a technique is.
    pub fn nested(&self) -> Result<Option<TechniqueSpec>> {
        let ParameterKind::Technique { of } = self.kind else { return Ok(None) };
        nested(of, &self.value).map(Some)
    }

    /// `spec`, a technique, as a value of this parameter: the other way of [`Parameter::nested`].
    pub fn nest(&self, spec: &TechniqueSpec) -> String {
        let text = spec.to_string().replace(':', "/");
        match self.kind {
            ParameterKind::Technique { of: Some(name) } => {
                text.strip_prefix(name).map_or("", |rest| rest.trim_start_matches('/')).to_owned()
            }
            _ => text,
        }
    }

    /// `key=default` and what else it may be, as help shows it.
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
            [first, second, .., last] if choices.len() > MOST_LISTED => {
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

/// The technique that stands in `value`, with `/` for `:`; `of` is its name, where the value has none.
pub(super) fn nested(of: Option<&str>, value: &str) -> Result<TechniqueSpec> {
    let text = value.replace('/', ":");
    match of {
        Some(name) if text.is_empty() => name.parse(),
        Some(name) => format!("{name}:{text}").parse(),
        None => text.parse(),
    }
}

/// Powers of ten as such where they are long.
fn short(value: f64) -> String {
    let (plain, power) = (value.to_string(), format!("{value:e}"));
    if power.len() + 2 < plain.len() { power } else { plain }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// That a technique takes the defaults and the ends of the ranges of what it is said to have, and refuses what lies beyond; and that every
    /// one has its line of help.
    pub(crate) fn holds(spec: &TechniqueSpec, describe: impl Fn(&TechniqueSpec) -> Result<Vec<Parameter>>) {
        let plain = describe(spec).unwrap();
        for p in &plain {
            let told = format!("{spec}: {}: {}", p.help(), p.what);
            let takes = |value: &str| describe(&spec.with(p.key, Some(value))).is_ok();
            assert!(
                !p.what.is_empty() && !p.what.contains('\n') && p.is_default() != spec.value(p.key).is_some(),
                "{told}"
            );
            if !p.default.is_empty() {
                let same = describe(&spec.with(p.key, Some(&p.default)));
                assert!(spec.value(p.key).is_some() || same.unwrap() == plain, "{told}");
            }
            let ends = |ends: [f64; 2]| {
                assert!(ends.iter().all(|e| takes(&e.to_string())), "{told}");
                assert!(
                    !takes(&(ends[0] - 1.0).to_string()) && !takes(&(ends[1] * 1.01 + 1.0).to_string()),
                    "{told}"
                );
            };
            match &p.kind {
                ParameterKind::Number { range } => ends([*range.start(), *range.end()]),
                ParameterKind::Count { range } => {
                    ends([f64::from(*range.start()), f64::from(*range.end())]);
                    assert!(!takes(&format!("{}.5", range.start())), "{told}");
                }
                ParameterKind::Integer { choices } => {
                    assert!(choices.iter().all(|c| takes(&c.to_string())), "{told}");
                    assert!(!takes(&(choices.iter().max().unwrap() + 1).to_string()), "{told}");
                }
                ParameterKind::Word { choices } => {
                    assert!(choices.len() > 1 && choices.contains(&p.default.as_str()), "{told}");
                    assert!(choices.iter().all(|c| takes(c)), "{told}");
                }
                ParameterKind::Technique { .. } => {
                    assert!(p.nested().unwrap().is_some(), "{told}");
                    assert!(!takes("zzz=zzz"), "{told}");
                }
            }
            assert!(!takes("zzz"), "{told}");
        }
    }

    fn number(default: &str, range: RangeInclusive<f64>) -> Parameter {
        let (key, value) = ("x", default.to_owned());
        Parameter { key, what: "", kind: ParameterKind::Number { range }, default: value.clone(), value }
    }

    #[test]
    fn parameter_s_slider_stays_near_a_default_of_a_wide_range() {
        assert_eq!(number("0.5", 0.0..=1.0).slider(), Some((0.0..=1.0, false)));
        assert_eq!(number("0", 0.0..=16.0).slider(), Some((0.0..=16.0, false)));
        assert_eq!(number("2", 0.0..=1e9).slider(), Some((0.02..=200.0, true)));
        assert_eq!(number("", 1e-3..=1e12).slider(), Some((1e-3..=1e12, true)));
    }

    #[test]
    fn parameter_is_its_default_by_number() {
        let p = Parameter { value: "0.50".to_owned(), ..number("0.5", 0.0..=1.0) };
        assert!(p.is_default());
        assert!(!Parameter { value: "0.51".to_owned(), ..p }.is_default());
    }

    #[test]
    fn parameter_holds_a_technique() {
        let spec: TechniqueSpec = "csm:cascades=2:filter=3".parse().unwrap();
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
