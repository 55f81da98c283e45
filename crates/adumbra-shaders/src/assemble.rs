//! Assembles a module: the requested texts, preceded by the constants and structures shared with Rust that
//! they use.

use std::collections::HashSet;

use crate::source::Source;
use crate::{constants, layout};

/// Assembles one module: the shared constants and structures that `texts` use, then `texts` in the given
/// order. An engine's own shader may be one of them. If it uses no shared names, it may also be appended to
/// the module.
pub fn assemble(texts: &[Source]) -> String {
    let structs: Vec<_> = layout::STRUCTS.iter().map(|s| (s.name, (s.declare)())).collect();
    let constants = constants::declarations();
    let mut used: HashSet<&str> = texts.iter().flat_map(|source| identifiers(source.text)).collect();
    let mut declared = Vec::new();
    // Every structure is listed after the ones it contains, so reverse order visits users first.
    for (name, text) in structs.iter().rev() {
        if used.contains(name) {
            used.extend(identifiers(text));
            declared.push(text.as_str());
        }
    }
    let constants = constants.iter().filter(|(name, _)| used.contains(name));
    let shared = constants.map(|(_, text)| text.as_str()).chain(declared.into_iter().rev());
    let mut module: String = shared.collect();
    for source in texts {
        module += &format!("// {}\n{}\n", source.name, source.text);
    }
    module
}

/// The identifiers and keywords of a WGSL text, without its comments.
pub fn identifiers(text: &str) -> impl Iterator<Item = &str> {
    let code = text.lines().map(|line| line.split("//").next().unwrap_or_default());
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    code.flat_map(move |line| line.split(move |c| !is_part(c))).filter(|word| !word.is_empty())
}
