//! Parser of the parts of Markdown that the documents use: blocks of commands with their checks, code spans,
//! links, headings.

/// The contents of a document.
#[derive(Debug, Default)]
pub(crate) struct MarkdownFile {
    /// The `sh` blocks, in order.
    pub(crate) blocks: Vec<Block>,
    /// Code spans outside blocks, with their line numbers.
    pub(crate) spans: Vec<(usize, String)>,
    /// Targets of links and pictures, with their line numbers.
    pub(crate) links: Vec<Link>,
    /// Anchors of the headings.
    pub(crate) anchors: Vec<String>,
}

/// A block of commands.
#[derive(Debug, PartialEq)]
pub(crate) struct Block {
    /// Line number of the fence, from 1.
    pub(crate) line: usize,
    /// The commands, with continued lines joined.
    pub(crate) commands: Vec<String>,
    /// The text after `check:` in the comment that follows the block.
    pub(crate) check: Option<String>,
    /// The `text` block after that comment: what the commands print.
    pub(crate) shown: Option<Vec<String>>,
}

/// A link or a picture.
#[derive(Debug, PartialEq)]
pub(crate) struct Link {
    pub(crate) line: usize,
    pub(crate) target: String,
    pub(crate) picture: bool,
}

impl MarkdownFile {
    pub(crate) fn read(text: &str) -> Self {
        let lines: Vec<&str> = text.lines().collect();
        let mut document = Self::default();
        let mut at = 0;
        while at < lines.len() {
            if let Some(kind) = fence(lines[at]) {
                let (body, end) = fenced(&lines, at);
                if kind == "sh" {
                    let mut block =
                        Block { line: at + 1, commands: commands(&body), check: None, shown: None };
                    at = document.checked(&mut block, &lines, end);
                    document.blocks.push(block);
                } else {
                    at = end;
                }
                continue;
            }
            document.line(at + 1, lines[at]);
            at += 1;
        }
        document
    }

    /// Reads the comment and the `text` block that follow a block ending before line `at`. Returns the line
    /// after them.
    fn checked(&mut self, block: &mut Block, lines: &[&str], at: usize) -> usize {
        let Some(first) = lines.get(at).and_then(|l| l.trim().strip_prefix("<!-- check:")) else { return at };
        let (mut check, mut next) = (first.to_owned(), at + 1);
        while !check.contains("-->") && next < lines.len() {
            check.push(' ');
            check.push_str(lines[next].trim());
            next += 1;
        }
        block.check = Some(check.split("-->").next().unwrap_or_default().trim().to_owned());
        if lines.get(next).and_then(|l| fence(l)) == Some("text") {
            let (body, end) = fenced(lines, next);
            block.shown = Some(body.into_iter().map(str::to_owned).collect());
            next = end;
        }
        next
    }

    fn line(&mut self, number: usize, line: &str) {
        // Parts with odd indices are between backticks.
        let parts: Vec<&str> = line.split('`').collect();
        let closed = parts.len() % 2 == 1;
        let is_code = |i: usize| i % 2 == 1 && (closed || i + 1 < parts.len());
        let mut prose = String::new();
        for (i, part) in parts.iter().enumerate() {
            if is_code(i) {
                self.spans.push((number, (*part).to_owned()));
                prose.push_str("``");
            } else {
                prose.push_str(part);
            }
        }
        let mut rest = prose.as_str();
        while let Some(found) = rest.find("](") {
            let text = &rest[..found];
            let picture = text.rfind('[').is_some_and(|open| text[..open].ends_with('!'));
            rest = &rest[found + 2..];
            let Some(end) = rest.find(')') else { break };
            self.links.push(Link { line: number, target: rest[..end].to_owned(), picture });
            rest = &rest[end + 1..];
        }
        if let Some(heading) = line.strip_prefix('#') {
            let anchor = anchor(heading.trim_start_matches('#'));
            let same = self.anchors.iter().filter(|a| **a == anchor).count();
            self.anchors.push(if same == 0 { anchor } else { format!("{anchor}-{same}") });
        }
    }
}

/// Returns the word after a fence.
fn fence(line: &str) -> Option<&str> {
    line.trim_start().strip_prefix("```").map(str::trim)
}

/// Returns the lines of a fenced block that opens at `at`, and the line after it.
fn fenced<'t>(lines: &[&'t str], at: usize) -> (Vec<&'t str>, usize) {
    let end = (at + 1..lines.len()).find(|&i| fence(lines[i]) == Some("")).unwrap_or(lines.len());
    (lines[at + 1..end].to_vec(), (end + 1).min(lines.len()))
}

fn commands(lines: &[&str]) -> Vec<String> {
    let (mut all, mut open) = (Vec::new(), String::new());
    for line in lines {
        open.push_str(line.trim());
        if let Some(begun) = open.strip_suffix('\\') {
            open = begun.to_owned();
        } else if !open.is_empty() {
            all.push(std::mem::take(&mut open));
        }
    }
    let open = open.trim_end();
    all.extend((!open.is_empty()).then(|| open.to_owned()));
    all
}

/// Makes the anchor of a heading as code hosts do: lower case, spaces become hyphens, and only letters,
/// digits, hyphens and underscores remain.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect::<String>().to_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "# A title: `with` code\n\nSee [here](a.md#b) and ![it](p.png), not `[x](y)`.\n\n\
        ```sh\nfirst --a   # why\nsecond \\\n  --b\n```\n<!-- check: exit 1;\n  stdout \"so\" -->\n```text\nso 3\n```\n\n\
        ```rust\n[no](link)\n```\n## B\n## B\n```sh\nthird\n```\n";

    #[test]
    fn markdown_blocks_include_checks_and_shown_output() {
        let document = MarkdownFile::read(TEXT);
        let [first, second] = &document.blocks[..] else { panic!("{document:?}") };
        assert_eq!(first.line, 5);
        assert_eq!(first.commands, ["first --a   # why", "second --b"]);
        assert_eq!(first.check.as_deref(), Some("exit 1; stdout \"so\""));
        assert_eq!(first.shown.as_deref(), Some(&["so 3".to_owned()][..]));
        assert_eq!(second, &Block { line: 21, commands: vec!["third".to_owned()], check: None, shown: None });
    }

    #[test]
    fn markdown_links_in_code_are_ignored() {
        let document = MarkdownFile::read(TEXT);
        let links: Vec<(&str, bool)> =
            document.links.iter().map(|l| (l.target.as_str(), l.picture)).collect();
        assert_eq!(links, [("a.md#b", false), ("p.png", true)]);
        let spans: Vec<&str> = document.spans.iter().map(|s| s.1.as_str()).collect();
        assert_eq!(spans, ["with", "[x](y)"]);
    }

    #[test]
    fn markdown_anchors_match_code_hosts() {
        assert_eq!(MarkdownFile::read(TEXT).anchors, ["a-title-with-code", "b", "b-1"]);
        assert_eq!(anchor(" The paper's tree, section by section"), "the-papers-tree-section-by-section");
        assert_eq!(anchor("What `a_b` is (2)"), "what-a_b-is-2");
    }

    #[test]
    fn unclosed_markdown_is_read_to_end() {
        let document = MarkdownFile::read("a ` b [c](d)\n```sh\nx \\\n");
        assert_eq!((document.links.len(), document.spans.len()), (1, 0));
        assert_eq!(document.blocks[0].commands, ["x"]);
    }
}
