//! Names and numbers as text for tables and Markdown.

/// Escapes a name, such as a file's, as Markdown text. The result has no markup and stays on one line.
pub fn escaped(name: &str) -> String {
    let mut text = String::with_capacity(name.len());
    for c in name.chars() {
        match c {
            '&' => text.push_str("&amp;"),
            '<' => text.push_str("&lt;"),
            '>' => text.push_str("&gt;"),
            '\\' | '`' | '*' | '_' | '[' | ']' | '|' | '#' | '!' | '~' | '$' => text.extend(['\\', c]),
            c if c.is_control() => text.push(' '),
            c => text.push(c),
        }
    }
    text
}

/// Formats a value with `digits` digits after the point, or as a dash if there is none.
pub fn figure(value: impl Into<Option<f64>>, digits: usize) -> String {
    value.into().map_or_else(|| "–".to_owned(), |v| format!("{v:.digits$}"))
}

/// Formats a share in percent, see [`figure`].
pub fn percent(share: impl Into<Option<f64>>, digits: usize) -> String {
    figure(share.into().map(|s| 100.0 * s), digits)
}

/// Formats a size in MB of 10^6 bytes, see [`figure`].
pub fn megabytes(bytes: impl Into<Option<u64>>, digits: usize) -> String {
    figure(bytes.into().map(|b| b as f64 / 1e6), digits)
}

/// Formats a number with thousands separators: 2400000 as 2,400,000.
pub fn grouped(whole: u64) -> String {
    let digits = whole.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escaped_names_contain_no_markup() {
        assert_eq!(escaped("box-city-5k.glb"), "box-city-5k.glb");
        let name = "a<b&c`|d\n# e_f.obj";
        let text = escaped(name);
        assert!(!text.contains('\n'), "{text}");
        let mut html = String::new();
        let markdown = format!("# {text}\n");
        pulldown_cmark::html::push_html(&mut html, pulldown_cmark::Parser::new(&markdown));
        assert_eq!(html, "<h1>a&lt;b&amp;c`|d # e_f.obj</h1>\n");
    }

    #[test]
    fn missing_figures_are_dashes() {
        assert_eq!((figure(None::<f64>, 3), figure(0.5, 3)), ("–".to_owned(), "0.500".to_owned()));
        assert_eq!((percent(0.01234, 2), megabytes(1_500_000, 1)), ("1.23".to_owned(), "1.5".to_owned()));
    }

    #[test]
    fn grouped_separates_thousands() {
        for (number, text) in [(0, "0"), (999, "999"), (1000, "1,000"), (15_058_044, "15,058,044")] {
            assert_eq!(grouped(number), text);
        }
    }
}
