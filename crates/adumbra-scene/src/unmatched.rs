//! Patterns of a name filter that match no name in the scene.

use std::fmt;

/// A pattern that matches no name in the scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnmatchedPattern {
    /// The pattern.
    pub pattern: String,
    /// Whether the pattern excludes names. If false, it keeps names.
    pub excludes: bool,
    /// Whether the pattern matches names of nodes without drawn triangles: empty or hidden nodes, or coarser
    /// levels of detail. The nodes below them have their own names.
    pub is_of_hidden: bool,
    /// Names similar to the pattern, the most similar first.
    pub near: Vec<String>,
}

impl fmt::Display for UnmatchedPattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_of_hidden {
            return write!(
                f,
                "{:?} matches only nodes without triangles of their own that are drawn; what is below them has names of its own",
                self.pattern
            );
        }
        write!(f, "{:?} matches no node, mesh or material", self.pattern)?;
        if self.near.contains(&self.pattern) {
            let literal = pattern_of(&self.pattern);
            return write!(
                f,
                "; *, ?, [ and {{ have a meaning in patterns: for the name itself, write {literal}"
            );
        }
        if !self.near.is_empty() {
            let near: Vec<String> = self.near.iter().map(|name| format!("{name:?}")).collect();
            write!(f, "; similar: {}", near.join(", "))?;
        }
        Ok(())
    }
}

/// Returns the pattern that matches just this name.
pub fn pattern_of(name: &str) -> String {
    let literal = |c: char| match c {
        '*' | '?' | '[' | ']' | '{' | '}' => format!("[{c}]"),
        // The meaning of a backslash in a pattern depends on the system.
        '\\' => "?".to_owned(),
        c => c.to_string(),
    };
    name.chars().map(literal).collect()
}
