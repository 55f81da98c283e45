//! Self-contained pages: text, tables, plots and pictures in one HTML file, which makes no network requests.
//!
//! The input is strings and the output is a string; this module does no I/O. A page works without scripts
//! (pairs of pictures are then shown side by side), in print, in dark and light mode, and on narrow screens,
//! where tables and plots scroll in their own boxes.

mod body;
mod markdown;
mod picture;
mod table;

use std::fmt::Write as _;

pub use body::{Body, Pair};
pub use picture::{Embedded, PictureEncoding};
pub use table::Table;

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
/// Content security policy: the page may load only what it contains.
const POLICY: &str =
    "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

/// A whole page.
#[derive(Clone, Debug, Default)]
pub struct Page {
    /// Title, as plain text.
    pub title: String,
    /// Meta description, as plain text.
    pub description: String,
    /// Text before the table of contents.
    pub opening: Body,
    /// Sections. The table of contents lists them and their parts.
    pub sections: Vec<Section>,
}

/// A section of a page.
#[derive(Clone, Debug)]
pub struct Section {
    /// Anchor of links to the section; unique in the page.
    pub id: String,
    /// Title, as plain text.
    pub title: String,
    /// Contents.
    pub body: Body,
}

impl Page {
    /// Returns the page as HTML.
    pub fn html(&self) -> String {
        let mut page = format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
            <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
            <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
            <meta name=\"color-scheme\" content=\"light dark\">\n<meta name=\"description\" content=\"{}\">\n\
            <link rel=\"icon\" href=\"data:,\">\n\
            <title>{}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n<header>\n<h1>{}</h1>\n{}</header>\n",
            escape(&self.description),
            escape(&self.title),
            escape(&self.title),
            self.opening.html(),
        );
        page.push_str(&self.contents());
        for section in &self.sections {
            // Writing to a String does not fail.
            let _ = writeln!(
                page,
                "<section id=\"{0}\" aria-labelledby=\"{0}-title\">\n<h2 id=\"{0}-title\">{1}</h2>\n{2}</section>",
                escape(&section.id),
                escape(&section.title),
                section.body.html()
            );
        }
        let _ = write!(page, "</main>\n<script>\n{SCRIPT}</script>\n</body>\n</html>\n");
        page
    }

    /// Returns the table of contents, with links to the sections and their parts; empty if there are fewer
    /// than two sections.
    fn contents(&self) -> String {
        if self.sections.len() < 2 {
            return String::new();
        }
        let mut text =
            String::from("<nav aria-labelledby=\"contents\">\n<h2 id=\"contents\">Contents</h2>\n<ol>\n");
        for section in &self.sections {
            let link = |id: &str, title: &str| format!("<a href=\"#{}\">{}</a>", escape(id), escape(title));
            let _ = write!(text, "<li>{}", link(&section.id, &section.title));
            let parts = section.body.parts();
            if !parts.is_empty() {
                text.push_str("\n<ul>\n");
                for (id, title) in parts {
                    let _ = writeln!(text, "<li>{}</li>", link(id, title));
                }
                text.push_str("</ul>");
            }
            text.push_str("</li>\n");
        }
        text + "</ol>\n</nav>\n"
    }
}

/// Escapes plain text for HTML, quoted attributes included.
pub(crate) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn page() -> Page {
        let mut body = Body::default();
        body.part("first-a", "A & B");
        body.paragraph("<b>not bold</b>");
        let section = |id: &str, body| Section { id: id.to_owned(), title: format!("Title of {id}"), body };
        Page {
            title: "\"Shadows\"".to_owned(),
            sections: vec![section("first", body), section("second", Body::default())],
            ..Page::default()
        }
    }

    #[test]
    fn page_lists_its_sections_and_their_parts() {
        let html = page().html();
        assert!(html.contains("<a href=\"#first\">Title of first</a>"));
        assert!(html.contains("<a href=\"#first-a\">A &amp; B</a>"));
        assert!(html.contains("<section id=\"second\""));
        assert_eq!(html.matches("id=\"first-a\"").count(), 1);
    }

    #[test]
    fn page_escapes_text() {
        let html = page().html();
        assert!(html.contains("<h1>&quot;Shadows&quot;</h1>"));
        assert!(html.contains("&lt;b&gt;not bold&lt;/b&gt;") && !html.contains("<b>not"));
    }

    #[test]
    fn page_makes_no_network_requests() {
        let html = page().html();
        for from_elsewhere in ["src=\"http", "href=\"http", "url(", "@import"] {
            assert!(!html.contains(from_elsewhere), "{from_elsewhere}");
        }
        assert!(html.contains("default-src 'none'"));
    }
}
