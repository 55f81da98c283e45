//! Selects triangles by the names of their node, mesh and material.

use globset::{Glob, GlobSet, GlobSetBuilder};

use crate::error::{Error, Result};

/// Glob patterns of names to keep and names to exclude. The default keeps everything.
#[derive(Clone, Debug, Default)]
pub struct NameFilter {
    /// If present, a triangle is kept only if at least one of its names matches one of these patterns.
    only: Option<GlobSet>,
    /// A triangle is dropped if any of its names matches one of these patterns.
    exclude: Option<GlobSet>,
}

/// Which of the filter's pattern lists a name matches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Marks {
    only: bool,
    exclude: bool,
}

impl Marks {
    /// The marks of a thing with two names.
    pub(super) fn or(self, other: Self) -> Self {
        Self { only: self.only || other.only, exclude: self.exclude || other.exclude }
    }
}

impl NameFilter {
    /// Builds a filter from globs (`*`, `?`, `[a-z]`, `{a,b}`), matched case-sensitively against whole names.
    ///
    /// # Errors
    /// Returns [`Error::Pattern`] if a pattern is not a valid glob.
    pub fn new(only: &[String], exclude: &[String]) -> Result<Self> {
        Ok(Self { only: set(only)?, exclude: set(exclude)? })
    }

    /// Whether the filter keeps everything.
    pub fn is_empty(&self) -> bool {
        self.only.is_none() && self.exclude.is_none()
    }

    /// Whether a triangle with these names is kept.
    pub fn keeps(&self, node: &str, mesh: &str, material: &str) -> bool {
        self.keeps_marked([node, mesh, material].map(|name| self.marks(name)))
    }

    /// The pattern lists that a name matches, for [`NameFilter::keeps_marked`]. Callers can cache the result: there are
    /// only four possible marks, but many names.
    pub(super) fn marks(&self, name: &str) -> Marks {
        let matches = |set: &Option<GlobSet>| set.as_ref().is_some_and(|set| set.is_match(name));
        Marks { only: matches(&self.only), exclude: matches(&self.exclude) }
    }

    /// Whether a triangle is kept whose node, mesh and material have these marks.
    pub(super) fn keeps_marked(&self, marks: [Marks; 3]) -> bool {
        (self.only.is_none() || marks.iter().any(|m| m.only)) && !marks.iter().any(|m| m.exclude)
    }
}

fn set(patterns: &[String]) -> Result<Option<GlobSet>> {
    if patterns.is_empty() {
        return Ok(None);
    }
    let bad = |pattern: &str, e: &globset::Error| Error::Pattern {
        pattern: pattern.to_owned(),
        what: e.kind().to_string(),
    };
    let mut builder = GlobSetBuilder::new();
    for pattern in patterns {
        builder.add(Glob::new(pattern).map_err(|e| bad(pattern, &e))?);
    }
    builder.build().map(Some).map_err(|e| bad(&patterns.join(", "), &e))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filter(only: &[&str], exclude: &[&str]) -> NameFilter {
        let owned = |list: &[&str]| list.iter().map(|&s| s.to_owned()).collect::<Vec<_>>();
        NameFilter::new(&owned(only), &owned(exclude)).expect("valid globs")
    }

    #[test]
    fn filter_default_keeps_everything() {
        assert!(NameFilter::default().keeps("", "", ""));
        assert!(NameFilter::default().is_empty());
    }

    #[test]
    fn filter_matches_any_of_the_three_names() {
        let only = filter(&["tree*", "rock"], &[]);
        assert!(
            only.keeps("tree_1", "m", "x") && only.keeps("n", "rock", "x") && only.keeps("n", "m", "tree")
        );
        assert!(!only.keeps("rocks", "m", "x"));
        let both = filter(&["tree*"], &["*leaf*"]);
        assert!(both.keeps("tree", "m", "bark") && !both.keeps("tree", "m", "leaf_2"));
    }

    #[test]
    fn filter_names_the_bad_pattern() {
        let error = NameFilter::new(&["[".to_owned()], &[]).expect_err("not a glob");
        assert!(matches!(error, Error::Pattern { pattern, .. } if pattern == "["));
    }
}
