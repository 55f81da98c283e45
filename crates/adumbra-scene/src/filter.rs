//! Selects triangles by the names of their node, mesh and material.

use std::collections::BTreeSet;

use globset::{Glob, GlobBuilder, GlobMatcher, GlobSet, GlobSetBuilder};

use crate::error::{Error, Result};
use crate::unmatched::UnmatchedPattern;

/// Glob patterns of names to keep and names to exclude. The default keeps everything.
#[derive(Clone, Debug, Default)]
pub struct NameFilter {
    /// If there are any, a triangle is kept only if at least one of its names matches one of these patterns.
    only: Patterns,
    /// A triangle is dropped if any of its names matches one of these patterns.
    exclude: Patterns,
}

/// Patterns and their compiled matchers.
#[derive(Clone, Debug, Default)]
struct Patterns {
    texts: Vec<String>,
    set: GlobSet,
    /// A case-insensitive matcher for each pattern.
    in_any_case: Vec<GlobMatcher>,
}

/// Which of the filter's pattern lists a name matches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Marks {
    only: bool,
    exclude: bool,
}

impl Marks {
    /// Combines the marks of two names of the same thing.
    pub(super) fn or(self, other: Self) -> Self {
        Self { only: self.only || other.only, exclude: self.exclude || other.exclude }
    }
}

/// Which patterns of a filter have matched in a scene. The patterns of `only` come before those of `exclude`.
#[derive(Debug, Default)]
pub(super) struct Met {
    /// Which patterns match a name.
    matched: Vec<bool>,
    /// Which patterns match a name of something that is not drawn.
    matched_hidden: Vec<bool>,
    /// Names in the scene, to suggest for patterns that match nothing.
    names: BTreeSet<String>,
}

/// Maximum number of similar names to suggest for a pattern.
const MOST_NEAR: usize = 3;
/// Maximum number of names to compare with patterns that match nothing, and their maximum length in bytes.
const MOST_NAMES: usize = 20_000;
const LONGEST_NAME: usize = 128;
/// Minimum similarity, from 0 to 1, of a suggested name.
const LEAST_LIKE: f64 = 0.75;

impl Met {
    fn note(&mut self, name: &str) {
        if name.len() <= LONGEST_NAME && self.names.len() < MOST_NAMES && !self.names.contains(name) {
            self.names.insert(name.to_owned());
        }
    }

    /// Records which patterns match the name of something without drawn triangles, such as an empty or hidden
    /// node.
    pub(super) fn meet_hidden(&mut self, filter: &NameFilter, name: &str) {
        if !filter.is_empty() {
            filter.mark(name, &mut self.matched_hidden);
        }
    }

    /// Returns the patterns that match nothing drawn. Cost: compares each of them with every name.
    pub(super) fn unmatched(&self, filter: &NameFilter) -> Vec<UnmatchedPattern> {
        let is_in = |matched: &[bool], i: usize| matched.get(i) == Some(&true);
        let all = filter.patterns().enumerate().filter(|(i, _)| !is_in(&self.matched, *i));
        all.map(|(i, (pattern, in_any_case))| {
            let like = |name: &'_ String| (likeness(pattern, in_any_case, name), name.clone());
            let mut near: Vec<(f64, String)> = self.names.iter().map(like).collect();
            near.retain(|(like, _)| *like >= LEAST_LIKE);
            near.sort_by(|(a, _), (b, _)| b.total_cmp(a));
            UnmatchedPattern {
                pattern: pattern.to_owned(),
                excludes: i >= filter.only.texts.len(),
                is_of_hidden: is_in(&self.matched_hidden, i),
                near: near.into_iter().take(MOST_NEAR).map(|(_, name)| name).collect(),
            }
        })
        .collect()
    }
}

/// Similarity of a name to a pattern that does not match it: 3 if it equals the pattern's text, 2 if only the
/// case differs, 1 if it contains the text, otherwise less than 1, by edit distance.
fn likeness(pattern: &str, in_any_case: &GlobMatcher, name: &str) -> f64 {
    if name == pattern {
        return 3.0;
    }
    if in_any_case.is_match(name) {
        return 2.0;
    }
    let text: String =
        pattern.chars().filter(|c| !"*?[]{}".contains(*c)).flat_map(char::to_lowercase).collect();
    let name = name.to_lowercase();
    if text.len() >= 3 && name.contains(&text) { 1.0 } else { strsim::jaro_winkler(&text, &name).min(0.99) }
}

impl NameFilter {
    /// Builds a filter from globs (`*`, `?`, `[a-z]`, `{a,b}`), matched case-sensitively against whole names.
    ///
    /// # Errors
    /// Returns [`Error::Pattern`] if a pattern is not a valid glob.
    pub fn new(only: &[String], exclude: &[String]) -> Result<Self> {
        Ok(Self { only: Patterns::new(only)?, exclude: Patterns::new(exclude)? })
    }

    /// Whether the filter keeps everything.
    pub fn is_empty(&self) -> bool {
        self.only.texts.is_empty() && self.exclude.texts.is_empty()
    }

    /// The patterns, those of `only` first, each with its case-insensitive matcher.
    fn patterns(&self) -> impl Iterator<Item = (&str, &GlobMatcher)> {
        let both = [&self.only, &self.exclude];
        both.into_iter().flat_map(|of| of.texts.iter().map(String::as_str).zip(&of.in_any_case))
    }

    /// The pattern lists that a name matches, for [`NameFilter::keeps_marked`]. Callers can cache the result:
    /// there are only four possible marks, but many names.
    pub(super) fn marks(&self, name: &str, met: &mut Met) -> Marks {
        if self.is_empty() {
            return Marks::default();
        }
        met.note(name);
        self.mark(name, &mut met.matched)
    }

    /// Records which patterns a name matches.
    fn mark(&self, name: &str, matched: &mut Vec<bool>) -> Marks {
        let [only, exclude] = [&self.only, &self.exclude].map(|of| of.set.matches(name));
        let first = self.only.texts.len();
        matched.resize(first + self.exclude.texts.len(), false);
        only.iter().for_each(|&i| matched[i] = true);
        exclude.iter().for_each(|&i| matched[first + i] = true);
        Marks { only: !only.is_empty(), exclude: !exclude.is_empty() }
    }

    /// Whether to keep a triangle whose node, mesh and material have these marks.
    pub(super) fn keeps_marked(&self, marks: [Marks; 3]) -> bool {
        (self.only.texts.is_empty() || marks.iter().any(|m| m.only)) && !marks.iter().any(|m| m.exclude)
    }
}

impl Patterns {
    fn new(texts: &[String]) -> Result<Self> {
        let bad = |pattern: &str, e: &globset::Error| Error::Pattern {
            pattern: pattern.to_owned(),
            what: e.kind().to_string(),
        };
        let mut builder = GlobSetBuilder::new();
        let mut in_any_case = Vec::with_capacity(texts.len());
        for text in texts {
            builder.add(Glob::new(text).map_err(|e| bad(text, &e))?);
            let any = GlobBuilder::new(text).case_insensitive(true).build().map_err(|e| bad(text, &e))?;
            in_any_case.push(any.compile_matcher());
        }
        let set = builder.build().map_err(|e| bad(&texts.join(", "), &e))?;
        Ok(Self { texts: texts.to_vec(), set, in_any_case })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filter(only: &[&str], exclude: &[&str]) -> NameFilter {
        let owned = |list: &[&str]| list.iter().map(|&s| s.to_owned()).collect::<Vec<_>>();
        NameFilter::new(&owned(only), &owned(exclude)).expect("valid globs")
    }

    fn keeps(filter: &NameFilter, names: [&str; 3]) -> bool {
        let mut met = Met::default();
        filter.keeps_marked(names.map(|name| filter.marks(name, &mut met)))
    }

    #[test]
    fn filter_default_keeps_everything() {
        assert!(keeps(&NameFilter::default(), ["", "", ""]));
        assert!(NameFilter::default().is_empty());
    }

    #[test]
    fn filter_matches_any_of_the_three_names() {
        let only = filter(&["tree*", "rock"], &[]);
        assert!(
            keeps(&only, ["tree_1", "m", "x"])
                && keeps(&only, ["n", "rock", "x"])
                && keeps(&only, ["n", "m", "tree"])
        );
        assert!(!keeps(&only, ["rocks", "m", "x"]));
        let both = filter(&["tree*"], &["*leaf*"]);
        assert!(keeps(&both, ["tree", "m", "bark"]) && !keeps(&both, ["tree", "m", "leaf_2"]));
    }

    #[test]
    fn unmatched_patterns_suggest_similar_names() {
        let filter = filter(&["Tower *", "bridge"], &["SkyDome*", "lamp [1]", "zebra"]);
        let mut met = Met::default();
        for name in ["Tower 1", "bridge_2", "the bridge", "sky_dome", "skydome_low", "lamp [1]", "house"] {
            filter.marks(name, &mut met);
        }
        let unmatched = met.unmatched(&filter);
        let said: Vec<(bool, String)> = unmatched.iter().map(|u| (u.excludes, u.to_string())).collect();
        let none = |pattern: &str| format!("{pattern:?} matches no node, mesh or material");
        assert_eq!(
            said,
            [
                (false, none("bridge") + "; similar: \"bridge_2\", \"the bridge\""),
                (true, none("SkyDome*") + "; similar: \"skydome_low\", \"sky_dome\""),
                (
                    true,
                    none("lamp [1]")
                        + "; *, ?, [ and { have a meaning in patterns: for the name itself, write lamp [[]1[]]"
                ),
                (true, none("zebra")),
            ]
        );
        // The suggested pattern matches the literal name only.
        let literal = NameFilter::new(&[], &["lamp [[]1[]]".to_owned()]).unwrap();
        assert!(!keeps(&literal, ["lamp [1]", "", ""]) && keeps(&literal, ["lamp 1", "", ""]));
    }

    #[test]
    fn error_names_the_invalid_pattern() {
        let error = NameFilter::new(&["[".to_owned()], &[]).expect_err("not a glob");
        assert!(matches!(error, Error::Pattern { pattern, .. } if pattern == "["));
    }
}
