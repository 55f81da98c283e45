//! Pages that need nothing but themselves: text, tables, plots and pictures in one HTML file, which asks no server for anything.
//!
//! Strings go in, a string comes out; nothing is read or written here. A page works without scripts (pairs of pictures stand side by
//! side then), in print, in dark and light, and on narrow screens, where tables and plots scroll in boxes of their own.

mod body;
mod markdown;
mod picture;
mod table;

use std::fmt::Write as _;

pub use body::{Body, Pair};
pub use picture::{Embedded, Encoding};
pub use table::Table;

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
/// What the page may load: what stands in it.
const POLICY: &str =
    "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

/// A whole page.
#[derive(Clone, Debug, Default)]
pub struct Page {
    /// Its title, as plain text.
    pub title: String,
    /// Said in the head for who lists the page, as plain text.
    pub description: String,
    /// What stands before the contents.
    pub opening: Body,
    /// Its sections; the contents list them and their parts.
    pub sections: Vec<Section>,
}

/// A section of a page.
#[derive(Clone, Debug)]
pub struct Section {
    /// Where links lead to; once a page.
    pub id: String,
    /// As plain text.
    pub title: String,
    /// What stands in it.
    pub body: Body,
}

impl Page {
    /// The page as HTML.
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

    /// Links to the sections and their parts; nothing where there is only one section.
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

/// Plain text as it may stand in HTML, in double-quoted attributes too.
pub fn escape(text: &str) -> String {
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
    fn page_takes_text_as_text() {
        let html = page().html();
        assert!(html.contains("<h1>&quot;Shadows&quot;</h1>"));
        assert!(html.contains("&lt;b&gt;not bold&lt;/b&gt;") && !html.contains("<b>not"));
    }

    #[test]
    fn page_asks_no_server() {
        let html = page().html();
        for from_elsewhere in ["src=\"http", "href=\"http", "url(", "@import"] {
            assert!(!html.contains(from_elsewhere), "{from_elsewhere}");
        }
        assert!(html.contains("default-src 'none'"));
    }
}
