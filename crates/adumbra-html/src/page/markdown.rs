//! Conversion of the benchmarks' Markdown to HTML for a page.

use pulldown_cmark::{CowStr, Event, HeadingLevel, Options, Parser, Tag, TagEnd, html};

use super::table::scroll_box;

/// Returns the text as HTML.
///
/// Headings are `down` levels lower, tables are in boxes that scroll, and raw HTML is shown as text. Pictures
/// are omitted, because a page shows them in its own way. Links are kept only if they are absolute
/// (`https://`).
pub(super) fn html(text: &str, down: usize) -> String {
    let mut inside_picture = 0_u32;
    let mut links = Vec::new();
    let events = Parser::new_ext(text, Options::ENABLE_TABLES).filter_map(|event| {
        match event {
            Event::Start(Tag::Image { .. }) => {
                inside_picture += 1;
                return None;
            }
            Event::End(TagEnd::Image) => {
                inside_picture -= 1;
                return None;
            }
            _ if inside_picture > 0 => return None,
            _ => {}
        }
        Some(match event {
            Event::Start(Tag::Heading { level, id, classes, attrs }) => {
                Event::Start(Tag::Heading { level: lower(level, down), id, classes, attrs })
            }
            Event::End(TagEnd::Heading(level)) => Event::End(TagEnd::Heading(lower(level, down))),
            Event::Start(Tag::Link { ref dest_url, .. }) => {
                let kept = dest_url.starts_with("https://");
                links.push(kept);
                return kept.then_some(event);
            }
            Event::End(TagEnd::Link) => return links.pop().unwrap_or(false).then_some(event),
            Event::Html(raw) | Event::InlineHtml(raw) => Event::Text(raw),
            other => other,
        })
    });
    let boxed = events.flat_map(|event| match event {
        Event::Start(Tag::Table(_)) => {
            [Some(Event::Html(CowStr::from(scroll_box("Table")))), Some(event)].into_iter().flatten()
        }
        Event::End(TagEnd::Table) => {
            [Some(event), Some(Event::Html(CowStr::from("</div>\n")))].into_iter().flatten()
        }
        other => [Some(other), None].into_iter().flatten(),
    });
    let mut out = String::new();
    html::push_html(&mut out, boxed);
    out.replace("<p></p>\n", "")
}

fn lower(level: HeadingLevel, down: usize) -> HeadingLevel {
    HeadingLevel::try_from((level as usize + down).min(6)).unwrap_or(HeadingLevel::H6)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markdown_becomes_a_part_of_a_page() {
        let html = html(
            "# Title\n\n![alt](a.png)\n\n[here](layouts.md) [there](https://x.org)\n\n| a | b |\n|---|---|\n| `c` | <i> |\n",
            2,
        );
        assert!(html.contains("<h3>Title</h3>"));
        assert!(!html.contains("img") && !html.contains("alt") && !html.contains("<p></p>"));
        assert!(html.contains("here <a href=\"https://x.org\">there</a>"));
        assert!(html.contains("<div class=\"scroll\"") && html.contains("<code>c</code>"));
        assert!(html.contains("&lt;i&gt;") && html.ends_with("</table>\n</div>\n"));
    }
}
