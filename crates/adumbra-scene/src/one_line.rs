//! Escapes text from a scene file, such as a texture's name, so that it fits in a message of one line.

use std::fmt::{self, Display, Write};

/// Shows a text with its control characters and line breaks escaped, as `\n` or `\u{1b}`.
pub(crate) fn one_line(text: &str) -> impl Display {
    OneLine(text)
}

struct OneLine<'t>(&'t str);

impl Display for OneLine<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.chars().try_for_each(|c| match c {
            '\u{2028}' | '\u{2029}' => write!(f, "{}", c.escape_unicode()),
            c if c.is_control() => write!(f, "{}", c.escape_debug()),
            c => f.write_char(c),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escapes_only_line_breaks_and_control_characters() {
        assert_eq!(one_line("a\n\r\tb\u{1b}[2J\u{2028}").to_string(), r"a\n\r\tb\u{1b}[2J\u{2028}");
        let plain = "caf\u{e9} \u{6728} \"q\" C:\\x";
        assert_eq!(one_line(plain).to_string(), plain);
    }
}
