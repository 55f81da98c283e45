//! Reads the mark of elements that cast no shadow: `extras: {"adumbra": {"cast": false}}`, on nodes, meshes
//! and materials.

use ::gltf::json::extras::Extras;
use serde_json::Value;

/// A message shows at most this many characters of a mark.
const MOST_CHARACTERS: usize = 40;

/// Reads marks, and collects those that are neither true nor false.
#[derive(Default)]
pub(super) struct Casting {
    /// The first such mark, as a clause.
    first: Option<String>,
    others: u64,
}

impl Casting {
    /// Whether an element casts: true unless its mark is `false` or 0. `name` describes the element, such as
    /// `node "lamp"`.
    pub(super) fn of(&mut self, extras: &Extras, name: impl FnOnce() -> String) -> bool {
        let Some(raw) = extras else { return true };
        let value: Value = serde_json::from_str(raw.get()).unwrap_or_default();
        let Some(mark) = value.get("adumbra").and_then(|a| a.get("cast")) else { return true };
        let number = mark.as_f64();
        match mark.as_bool() {
            Some(casts) => return casts,
            None if number == Some(0.0) => return false,
            None if number == Some(1.0) => return true,
            None => {}
        }
        match &self.first {
            Some(_) => self.others += 1,
            None => {
                let text: String = mark.to_string().chars().take(MOST_CHARACTERS).collect();
                self.first = Some(format!("{} is {text}", name()));
            }
        }
        true
    }

    /// A warning about marks that are neither true nor false.
    pub(super) fn warning(&self) -> Option<String> {
        let first = self.first.as_ref()?;
        let others = match self.others {
            0 => String::new(),
            count => format!(", and {count} more are neither"),
        };
        Some(format!("extras.adumbra.cast of {first}, which is neither true nor false, so it casts{others}"))
    }
}
