//! The contents of a section: text, tables, plots, pictures, pairs of pictures.

use std::fmt::Write as _;

use super::picture::Embedded;
use super::table::{Table, scroll_box, words};
use super::{escape, markdown};

/// HTML to which elements are appended. Texts are plain text, with code between backquotes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Body {
    html: String,
    /// Id and title of each part.
    parts: Vec<(String, String)>,
}

/// Two pictures of equal size on top of each other, with a divider that moves.
#[derive(Clone, Debug)]
pub struct Pair<'a> {
    /// Picture left of the divider, and its name.
    pub left: (&'a Embedded, &'a str),
    /// Picture right of the divider, and its name.
    pub right: (&'a Embedded, &'a str),
    /// Text below both.
    pub caption: &'a str,
}

/// Largest magnification of a pair: pixels on the page per pixel of the picture.
const LARGEST: f64 = 1.5;
/// Largest height of a pair on the page, in pixels.
const TALLEST: f64 = 600.0;

// Writing to a String does not fail, so the result of `write!` is ignored throughout.
impl Body {
    /// Returns the HTML so far.
    pub fn html(&self) -> &str {
        &self.html
    }

    /// Whether nothing was appended yet.
    pub fn is_empty(&self) -> bool {
        self.html.is_empty()
    }

    pub(super) fn parts(&self) -> &[(String, String)] {
        &self.parts
    }

    /// Appends the heading of a part of the section, which the table of contents lists. `id` must be unique
    /// in the page.
    pub fn part(&mut self, id: &str, title: &str) {
        let _ = writeln!(self.html, "<h3 id=\"{}\">{}</h3>", escape(id), words(title));
        self.parts.push((id.to_owned(), title.to_owned()));
    }

    /// Appends a heading one level below a part's, which the table of contents does not list.
    pub fn heading(&mut self, title: &str) {
        let _ = writeln!(self.html, "<h4>{}</h4>", words(title));
    }

    /// Appends a paragraph.
    pub fn paragraph(&mut self, text: &str) {
        let _ = writeln!(self.html, "<p>{}</p>", words(text));
    }

    /// Appends a paragraph in another language. `language` is its tag, such as `zh`.
    pub fn foreign(&mut self, language: &str, text: &str) {
        let _ = writeln!(self.html, "<p lang=\"{}\">{}</p>", escape(language), words(text));
    }

    /// Appends an emphasised paragraph, for what failed or is missing.
    pub fn note(&mut self, text: &str) {
        let _ = writeln!(self.html, "<p class=\"note\">{}</p>", words(text));
    }

    /// Appends a subdued paragraph, which says why there is nothing to show.
    pub fn aside(&mut self, text: &str) {
        let _ = writeln!(self.html, "<p class=\"aside\">{}</p>", words(text));
    }

    /// Appends a list.
    pub fn list<T: AsRef<str>>(&mut self, items: impl IntoIterator<Item = T>) {
        self.html.push_str("<ul>\n");
        for item in items {
            let _ = writeln!(self.html, "<li>{}</li>", words(item.as_ref()));
        }
        self.html.push_str("</ul>\n");
    }

    /// Appends preformatted text such as commands, line by line. `name` describes it to screen readers.
    pub fn code(&mut self, name: &str, text: &str) {
        let lines: String = text.lines().map(|l| format!("<code>{}\n</code>", escape(l))).collect();
        let _ = writeln!(self.html, "<pre role=\"group\" aria-label=\"{}\">{lines}</pre>", escape(name));
    }

    /// Appends a table.
    pub fn table(&mut self, table: &Table) {
        self.html.push_str(&table.html());
    }

    /// Appends a picture with its caption. `alt` describes its contents.
    pub fn picture(&mut self, picture: &Embedded, alt: &str, caption: &str) {
        let _ = writeln!(
            self.html,
            "<figure class=\"picture\">\n{}\n<figcaption>{}</figcaption>\n</figure>",
            image(picture, alt),
            words(caption)
        );
    }

    /// Appends two pictures with a divider. They should have equal size; the right one is shown at the size
    /// of the left one.
    pub fn pair(&mut self, pair: &Pair<'_>) {
        let Pair { left, right, caption } = pair;
        let side = |class: &str, (picture, name): &(&Embedded, &str)| {
            let alt = format!("{name}: {caption}");
            format!(
                "<div class=\"{class}\">{}<span class=\"name\">{}</span></div>",
                image(picture, &alt),
                words(name)
            )
        };
        let [width, height] = [left.0.width, left.0.height].map(f64::from);
        let widest = (LARGEST * width).min(TALLEST * width / height.max(1.0)).round();
        let _ = writeln!(
            self.html,
            "<figure class=\"pair\" style=\"--widest:{widest}px\">\n<div class=\"frame\" style=\"--ratio:{width}/{height};--at:50%\">\n{}\n{}\n<div class=\"divider\"></div>\n</div>\n\
            <label class=\"control\"><span>{} ← divider → {}</span><input type=\"range\" min=\"0\" max=\"100\" value=\"50\" step=\"1\"></label>\n\
            <figcaption>{}</figcaption>\n</figure>",
            side("left", left),
            side("right", right),
            words(left.1),
            words(right.1),
            words(caption)
        );
    }

    /// Appends a plot, given as SVG. `alt` describes its contents.
    pub fn plot(&mut self, svg: &str, alt: &str, caption: &str) {
        // An XML declaration before the element is for files only.
        let svg = svg.find("<svg").map_or("", |at| &svg[at..]);
        let _ = writeln!(
            self.html,
            "<figure class=\"plot\">\n{}<div role=\"img\" aria-label=\"{}\">{svg}</div>\n</div>\n<figcaption>{}</figcaption>\n</figure>",
            scroll_box(&alt.replace('`', "")),
            plain(alt),
            words(caption)
        );
    }

    /// Appends Markdown, with its headings `down` levels lower and without its pictures.
    pub fn markdown(&mut self, text: &str, down: usize) {
        self.html.push_str(&markdown::html(text, down));
    }

    /// Appends a collapsed section, shown when the reader opens `title`, and always in print.
    pub fn folded(&mut self, title: &str, inside: &Self) {
        let _ =
            writeln!(self.html, "<details>\n<summary>{}</summary>\n{}</details>", words(title), inside.html);
    }
}

fn image(picture: &Embedded, alt: &str) -> String {
    let Embedded { uri, width, height } = picture;
    format!("<img src=\"{uri}\" width=\"{width}\" height=\"{height}\" alt=\"{}\">", plain(alt))
}

/// Returns a text for screen readers: escaped for an attribute, without backquotes.
fn plain(text: &str) -> String {
    escape(&text.replace('`', ""))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn embedded() -> Embedded {
        Embedded { uri: "data:image/png;base64,AA==".to_owned(), width: 4, height: 2 }
    }

    #[test]
    fn body_pair_has_both_pictures_and_a_range() {
        let mut body = Body::default();
        let picture = embedded();
        body.pair(&Pair { left: (&picture, "rays"), right: (&picture, "`csm`"), caption: "A `city` street" });
        assert_eq!(body.html().matches("<img ").count(), 2);
        assert!(
            body.html().contains("type=\"range\"") && body.html().contains("alt=\"rays: A city street\"")
        );
        assert!(
            body.html().contains("alt=\"csm: A city street\"") && body.html().contains("<code>csm</code>")
        );
        assert!(body.html().contains("--ratio:4/2"));
    }

    #[test]
    fn body_plot_drops_the_xml_declaration() {
        let mut body = Body::default();
        body.plot("<?xml version=\"1.0\"?>\n<svg></svg>", "times", "Times");
        assert!(body.html().contains("<svg></svg>") && !body.html().contains("<?xml"));
    }
}
