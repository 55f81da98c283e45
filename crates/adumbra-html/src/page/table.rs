//! Tables.

use std::fmt::Write as _;

use super::escape;

/// Cells with more characters than this hold running text, and get a minimum width.
const LONG: usize = 40;

/// A table of plain texts. Text between backquotes is shown as code.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Caption; empty if the text before the table describes it.
    pub caption: String,
    /// Column headers.
    pub head: Vec<String>,
    /// Rows. The first cell of each is the row header.
    pub rows: Vec<Vec<String>>,
}

/// A column of a table: its header, and its cell in the row of an item.
pub(crate) type Column<'a, R> = (&'a str, fn(&R) -> String);

impl Table {
    /// Creates a table with one row per item.
    pub fn of<'r, R: 'r>(
        caption: &str,
        items: impl IntoIterator<Item = &'r R>,
        columns: &[Column<'_, R>],
    ) -> Self {
        let head: Vec<&str> = columns.iter().map(|(head, _)| *head).collect();
        let mut table = Self::new(caption, &head);
        for item in items {
            table.row(columns.iter().map(|(_, cell)| cell(item)));
        }
        table
    }

    /// Creates an empty table with these columns.
    pub fn new(caption: &str, head: &[&str]) -> Self {
        Self {
            caption: caption.to_owned(),
            head: head.iter().map(|&h| h.to_owned()).collect(),
            rows: Vec::new(),
        }
    }

    /// Adds a row.
    pub fn row<T: Into<String>>(&mut self, cells: impl IntoIterator<Item = T>) {
        self.rows.push(cells.into_iter().map(Into::into).collect());
    }

    /// Returns the table as Markdown, without its caption.
    pub fn markdown(&self) -> String {
        let line = |cells: &[String]| {
            let cells =
                cells.iter().map(|cell| if cell.is_empty() { "| ".to_owned() } else { format!("| {cell} ") });
            cells.collect::<String>() + "|\n"
        };
        let rows: String = self.rows.iter().map(|row| line(row)).collect();
        format!("{}{}|\n{rows}", line(&self.head), "|---".repeat(self.head.len()))
    }

    /// Returns the table as HTML, in a box that scrolls horizontally on its own.
    pub(super) fn html(&self) -> String {
        let name = if self.caption.is_empty() { "Table" } else { &self.caption };
        let mut text = format!("{}<table>\n", scroll_box(name));
        // Writing to a String does not fail.
        if !self.caption.is_empty() {
            let _ = writeln!(text, "<caption>{}</caption>", words(&self.caption));
        }
        // Without column names there is no header row.
        let named = self.head.iter().any(|h| !h.is_empty());
        if named {
            text.push_str("<thead><tr>");
            for (i, head) in self.head.iter().enumerate() {
                let class = if i > 0 && self.is_numeric(i) { " class=\"number\"" } else { "" };
                let _ = write!(text, "<th scope=\"col\"{class}>{}</th>", words(head));
            }
            text.push_str("</tr></thead>\n");
        }
        text.push_str("<tbody>\n");
        for row in &self.rows {
            text.push_str("<tr>");
            for (i, cell) in row.iter().enumerate() {
                let class = match i {
                    _ if cell.chars().count() > LONG => " class=\"long\"",
                    1.. if named && looks_numeric(cell) => " class=\"number\"",
                    _ => "",
                };
                let _ = match i {
                    0 => write!(text, "<th scope=\"row\"{class}>{}</th>", words(cell)),
                    _ => write!(text, "<td{class}>{}</td>", words(cell)),
                };
            }
            text.push_str("</tr>\n");
        }
        text + "</tbody>\n</table>\n</div>\n"
    }

    fn is_numeric(&self, column: usize) -> bool {
        let mut cells = self.rows.iter().filter_map(|r| r.get(column)).filter(|c| !c.is_empty()).peekable();
        cells.peek().is_some() && cells.all(|c| looks_numeric(c))
    }
}

/// Returns the opening tag of a box that scrolls. It takes the keyboard focus, so that the arrow keys scroll
/// it.
pub(super) fn scroll_box(name: &str) -> String {
    format!("<div class=\"scroll\" role=\"group\" tabindex=\"0\" aria-label=\"{}\">\n", escape(name))
}

/// Escapes a text, and marks text between backquotes as code.
pub(super) fn words(text: &str) -> String {
    let mut parts = text.split('`');
    let mut html = escape(parts.next().unwrap_or_default());
    let rest: Vec<&str> = parts.collect();
    for (i, part) in rest.iter().enumerate() {
        // An unpaired last backquote is a literal backquote.
        let closed = i % 2 == 1 || i + 1 < rest.len();
        let code = i % 2 == 0 && closed;
        if code {
            html += &format!("<code>{}</code>", escape(part));
        } else {
            html += &format!("{}{}", if closed { "" } else { "`" }, escape(part));
        }
    }
    html
}

/// Whether a cell consists of numbers, possibly with signs, unit symbols and brackets.
fn looks_numeric(cell: &str) -> bool {
    let mark = |c: char| c.is_ascii_digit() || " .,+-−–×%()/eE²³°".contains(c);
    // Two hyphens indicate a date.
    !cell.is_empty() && cell.chars().all(mark) && cell.matches('-').count() < 2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_has_a_row_per_item() {
        let table =
            Table::of("", &[1.25, 0.5], &[("ms", f64::to_string), ("%", |ms| format!("{:.0}", 100.0 * ms))]);
        assert_eq!(table.markdown(), "| ms | % |\n|---|---|\n| 1.25 | 125 |\n| 0.5 | 50 |\n");
    }

    #[test]
    fn table_has_heads_for_columns_and_rows() {
        let mut table = Table::new("Times", &["scene", "ms"]);
        table.row(["`city`", "1.25 (0.9)"]);
        let html = table.html();
        assert!(html.contains("<caption>Times</caption>"));
        assert!(html.contains("<th scope=\"col\" class=\"number\">ms</th>"));
        assert!(
            html.contains("<th scope=\"row\"><code>city</code></th><td class=\"number\">1.25 (0.9)</td>")
        );
    }

    #[test]
    fn table_keeps_an_unpaired_backquote() {
        assert_eq!(words("a `b` c"), "a <code>b</code> c");
        assert_eq!(words("a ` b"), "a ` b");
        assert_eq!(words("`<` and `>`"), "<code>&lt;</code> and <code>&gt;</code>");
    }
}
