//! The elements of a glTF file that cannot be read. A fault is an error where the element is used, and a
//! warning otherwise.

use std::collections::BTreeMap;
use std::path::Path;

use crate::budget::Budget;
use crate::error::{Error, Result};

/// The elements of a file that cannot be read, by kind and index.
#[derive(Default)]
pub(super) struct Faults {
    of: BTreeMap<(&'static str, usize), String>,
}

/// Memory for remembering a fault, bytes: a short text, and its place in the tree.
const FAULT_BYTES: u64 = 512;

/// Maximum number of characters to keep of a description, because a message may quote the whole element.
const MAX_CLAUSE: usize = 120;

impl Faults {
    /// Remembers that an element cannot be read. `kind` is the singular, such as "accessor"; `what` is a
    /// clause.
    ///
    /// # Errors
    /// Returns [`Error::SceneMemory`].
    pub(super) fn add(
        &mut self,
        budget: &Budget<'_>,
        kind: &'static str,
        index: usize,
        what: &str,
    ) -> Result<()> {
        budget.charge(FAULT_BYTES, || format!("the faults of {kind} {index}"))?;
        let mut clause: String = what.chars().take(MAX_CLAUSE).collect();
        if clause.len() < what.len() {
            clause.push('…');
        }
        self.of.insert((kind, index), clause);
        Ok(())
    }

    /// An error if this element cannot be read.
    pub(super) fn check(&self, path: &Path, kind: &'static str, index: usize) -> Result<()> {
        match self.of.get(&(kind, index)) {
            Some(what) => Err(bad(path, format!("{kind} {index} cannot be read: {what}"))),
            None => Ok(()),
        }
    }

    /// Number of elements of a kind that cannot be read.
    pub(super) fn count(&self, kind: &'static str) -> u64 {
        self.of.keys().filter(|(of, _)| *of == kind).count() as u64
    }

    /// A warning for each kind, to be used once it is known that none of the elements was needed. Animations
    /// are not included, because they are reported as omissions.
    pub(super) fn warnings(&self) -> impl Iterator<Item = String> {
        let mut counts: BTreeMap<&str, u64> = BTreeMap::new();
        for (kind, _) in self.of.keys().filter(|(kind, _)| *kind != "animation") {
            *counts.entry(kind).or_default() += 1;
        }
        counts.into_iter().map(|(kind, count)| {
            format!("elements that cannot be read, and that nothing needs: {count} of kind {kind}")
        })
    }
}

/// An [`Error::SceneParse`] for a glTF file.
pub(super) fn bad(path: &Path, what: impl Into<String>) -> Error {
    Error::SceneParse { path: path.to_owned(), format: "glTF", what: what.into() }
}
