//! What stands in a section: words, tables, plots, pictures, pairs of pictures.

use std::fmt::Write as _;

use super::picture::Embedded;
use super::table::{Table, scroll_box, words};
use super::{escape, markdown};

/// HTML that grows. Texts are plain; between backquotes they stand as code.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Body {
    html: String,
    /// Id and title of its parts.
    parts: Vec<(String, String)>,
}

/// Two pictures of one size in one place, with a divider that moves.
#[derive(Clone, Debug)]
pub struct Pair<'a> {
    /// Left of the divider, and what it is called.
    pub left: (&'a Embedded, &'a str),
    /// Right of the divider, and what it is called.
    pub right: (&'a Embedded, &'a str),
    /// Below both.
    pub caption: &'a str,
}

/// Pixels on the page a pixel of a pair, at most.
const LARGEST: f64 = 1.5;
/// Height of a pair on the page, pixels.
const TALLEST: f64 = 600.0;

// Writing to a String does not fail, so what `write!` gives is dropped throughout.
impl Body {
    /// What was said so far.
    pub fn html(&self) -> &str {
        &self.html
    }

    /// Nothing was said yet.
    pub fn is_empty(&self) -> bool {
        self.html.is_empty()
    }

    pub(super) fn parts(&self) -> &[(String, String)] {
        &self.parts
    }

    /// A part of the section that the contents list; `id` once a page.
    pub fn part(&mut self, id: &str, title: &str) {
        let _ = writeln!(self.html, "<h3 id=\"{}\">{}</h3>", escape(id), words(title));
        self.parts.push((id.to_owned(), title.to_owned()));
    }

    /// A heading below a part's, which the contents do not list.
    pub fn heading(&mut self, title: &str) {
        let _ = writeln!(self.html, "<h4>{}</h4>", words(title));
    }

    /// A paragraph.
    pub fn paragraph(&mut self, text: &str) {
        let _ = writeln!(self.html, "<p>{}</p>", words(text));
    }

    /// A paragraph in another language, such as `zh`.
    pub fn foreign(&mut self, language: &str, text: &str) {
        let _ = writeln!(self.html, "<p lang=\"{}\">{}</p>", escape(language), words(text));
    }

    /// A paragraph that stands out: what failed, what is missing.
    pub fn note(&mut self, text: &str) {
        let _ = writeln!(self.html, "<p class=\"note\">{}</p>", words(text));
    }

    /// A paragraph that stands back: that there is nothing to show, and why.
    pub fn aside(&mut self, text: &str) {
        let _ = writeln!(self.html, "<p class=\"aside\">{}</p>", words(text));
    }

    /// Items in a list.
    pub fn list<T: AsRef<str>>(&mut self, items: impl IntoIterator<Item = T>) {
        self.html.push_str("<ul>\n");
        for item in items {
            let _ = writeln!(self.html, "<li>{}</li>", words(item.as_ref()));
        }
        self.html.push_str("</ul>\n");
    }

    /// Commands or other text as typed, line by line; `name` says what it is.
    pub fn code(&mut self, name: &str, text: &str) {
        let lines: String = text.lines().map(|l| format!("<code>{}\n</code>", escape(l))).collect();
        let _ = writeln!(self.html, "<pre role=\"group\" aria-label=\"{}\">{lines}</pre>", escape(name));
    }

    /// A table.
    pub fn table(&mut self, table: &Table) {
        self.html.push_str(&table.html());
    }

    /// A picture with its caption; `alt` says what is seen in it.
    pub fn picture(&mut self, picture: &Embedded, alt: &str, caption: &str) {
        let _ = writeln!(
            self.html,
            "<figure class=\"picture\">\n{}\n<figcaption>{}</figcaption>\n</figure>",
            image(picture, alt),
            words(caption)
        );
    }

    /// Two pictures with a divider. They should be of one size; the right one is shown at the left one's.
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

    /// A plot, given as SVG; `alt` says what it shows.
    pub fn plot(&mut self, svg: &str, alt: &str, caption: &str) {
        // What stands before the element belongs to a file.
        let svg = svg.find("<svg").map_or("", |at| &svg[at..]);
        let _ = writeln!(
            self.html,
            "<figure class=\"plot\">\n{}<div role=\"img\" aria-label=\"{}\">{svg}</div>\n</div>\n<figcaption>{}</figcaption>\n</figure>",
            scroll_box(&alt.replace('`', "")),
            plain(alt),
            words(caption)
        );
    }

    /// Markdown, its headings `down` levels lower; pictures in it are left out.
    pub fn markdown(&mut self, text: &str, down: usize) {
        self.html.push_str(&markdown::html(text, down));
    }

    /// What is shown when `title` is opened, and always in print.
    pub fn folded(&mut self, title: &str, inside: &Self) {
        let _ =
            writeln!(self.html, "<details>\n<summary>{}</summary>\n{}</details>", words(title), inside.html);
    }
}

fn image(picture: &Embedded, alt: &str) -> String {
    let Embedded { uri, width, height } = picture;
    format!("<img src=\"{uri}\" width=\"{width}\" height=\"{height}\" alt=\"{}\">", plain(alt))
}

/// A text that only readers of the screen get: as an attribute, without backquotes.
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
    fn body_plot_leaves_out_what_belongs_to_a_file() {
        let mut body = Body::default();
        body.plot("<?xml version=\"1.0\"?>\n<svg></svg>", "times", "Times");
        assert!(body.html().contains("<svg></svg>") && !body.html().contains("<?xml"));
    }
}
