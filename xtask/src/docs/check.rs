//! Checks of a block's commands, as specified in the comment after the block.
//!
//! `<!-- check: CLAUSE; CLAUSE; … -->`, where a clause is one of
//!
//! | clause | check |
//! |---|---|
//! | `exit N` | the last command ends with this code (0 without the clause); all others end with 0 |
//! | `exists PATH [MIN..[MAX]]` | the file exists, with a length in bytes in this range, or of at least 1 |
//! | `picture PATH [WxH]` | the picture has this size and more than one colour |
//! | `equal PATH PATH` | the files have the same bytes |
//! | `alike PATH PATH` | the pictures have the same size, and differ by at most [`ALIKE`] |
//! | `stdout "TEXT"`, `stderr "TEXT"` | the block's commands print this text |
//! | `quick "A" => "B"` | no check: a quick run replaces A with B |
//! | `long` | no check: a quick run only has the commands' arguments parsed |
//! | `parse` | no check: every run only has the commands' arguments parsed, for commands that open a window and wait |

use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;

/// How much two pictures may differ and still be alike. It allows for another adapter, or another number of
/// milliseconds on a sheet.
const ALIKE: Difference = Difference { mean: 3.0, percent: 0.5 };

/// Channels differ visibly if they differ by more than this, of 255.
const VISIBLE: u8 = 24;

/// The difference of two pictures of the same size.
#[derive(Clone, Copy)]
struct Difference {
    /// Mean of all channels' differences, of 255.
    mean: f64,
    /// Percentage of the pixels that differ visibly. The mean alone would not notice that a thin shadow is
    /// missing.
    percent: f64,
}

impl Difference {
    fn is_within(self, most: Self) -> bool {
        self.mean <= most.mean && self.percent <= most.percent
    }

    /// The pictures must have the same size and channels.
    fn of(a: &Picture, b: &Picture) -> Self {
        let differences: Vec<u8> = a.bytes.iter().zip(&b.bytes).map(|(l, r)| l.abs_diff(*r)).collect();
        let sum: u64 = differences.iter().copied().map(u64::from).sum();
        let pixels = differences.chunks_exact(a.channels);
        let count = pixels.len();
        let visible = pixels.filter(|pixel| pixel.iter().any(|channel| *channel > VISIBLE)).count();
        Self { mean: sum as f64 / differences.len() as f64, percent: 100.0 * visible as f64 / count as f64 }
    }
}

/// The checks of a block.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Check {
    pub(crate) exit: i32,
    pub(crate) long: bool,
    pub(crate) parse: bool,
    /// Replacements of a quick run: from, to.
    pub(crate) quick: Vec<(String, String)>,
    expected: Vec<Expected>,
}

#[derive(Debug, PartialEq)]
enum Expected {
    Exists { path: String, least: u64, most: u64 },
    Picture { path: String, size: Option<[u32; 2]> },
    Equal { paths: [String; 2] },
    Alike { paths: [String; 2] },
    Stdout(String),
    Stderr(String),
}

/// The output of a block's commands.
#[derive(Debug, Default)]
pub(crate) struct Printed {
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Check {
    /// Parses the comment's text.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let mut check = Self::default();
        for clause in clauses(text)? {
            let words: Vec<&str> = clause.iter().map(String::as_str).collect();
            match words.as_slice() {
                ["long"] => check.long = true,
                ["parse"] => check.parse = true,
                ["exit", code] => {
                    check.exit = code.parse().map_err(|_| format!("exit {code}: not an exit code"))?;
                }
                ["quick", from, "=>", to] => check.quick.push(((*from).to_owned(), (*to).to_owned())),
                _ => check.expected.push(Expected::parse(&words)?),
            }
        }
        Ok(check)
    }

    /// Returns every expectation that fails in `folder` after the commands have run.
    pub(crate) fn faults(&self, folder: &Path, printed: &Printed) -> Vec<String> {
        self.expected.iter().filter_map(|e| e.hold(folder, printed).err()).collect()
    }
}

impl Expected {
    fn parse(words: &[&str]) -> Result<Self, String> {
        let of = |path: &str| path.to_owned();
        Ok(match words {
            ["exists", path] => Self::Exists { path: of(path), least: 1, most: u64::MAX },
            ["exists", path, range] => {
                let wrong = || format!("exists {path} {range}: give MIN..MAX or MIN..");
                let (least, most) = range.split_once("..").ok_or_else(wrong)?;
                let most = if most.is_empty() { u64::MAX } else { most.parse().map_err(|_| wrong())? };
                Self::Exists { path: of(path), least: least.parse().map_err(|_| wrong())?, most }
            }
            ["picture", path] => Self::Picture { path: of(path), size: None },
            ["picture", path, size] => {
                let wrong = || format!("picture {path} {size}: give WIDTHxHEIGHT");
                let (width, height) = size.split_once('x').ok_or_else(wrong)?;
                let side = |s: &str| s.parse::<u32>().map_err(|_| wrong());
                Self::Picture { path: of(path), size: Some([side(width)?, side(height)?]) }
            }
            ["equal", a, b] => Self::Equal { paths: [of(a), of(b)] },
            ["alike", a, b] => Self::Alike { paths: [of(a), of(b)] },
            ["stdout", text] => Self::Stdout(of(text)),
            ["stderr", text] => Self::Stderr(of(text)),
            _ => return Err(format!("{:?} is not a clause of a check", words.join(" "))),
        })
    }

    fn hold(&self, folder: &Path, printed: &Printed) -> Result<(), String> {
        match self {
            Self::Exists { path, least, most } => {
                let bytes = fs::metadata(folder.join(path)).map_err(|e| format!("{path}: {e}"))?.len();
                let fits = (*least..=*most).contains(&bytes);
                fits.then_some(()).ok_or_else(|| format!("{path}: {bytes} bytes, not {least} to {most}"))
            }
            Self::Picture { path, size } => {
                let picture = picture(&folder.join(path))?;
                let found = picture.size;
                match size {
                    Some(size) if *size != found => Err(format!("{path}: {found:?} pixels, not {size:?}")),
                    _ if is_one_colour(&picture) => Err(format!("{path}: the picture has a single colour")),
                    _ => Ok(()),
                }
            }
            Self::Equal { paths: [a, b] } => {
                let bytes = |path: &str| fs::read(folder.join(path)).map_err(|e| format!("{path}: {e}"));
                if bytes(a)? == bytes(b)? { Ok(()) } else { Err(format!("{a} and {b} differ")) }
            }
            Self::Alike { paths: [a, b] } => {
                let (left, right) = (picture(&folder.join(a))?, picture(&folder.join(b))?);
                let [of_left, of_right] = [&left, &right].map(|p| (p.size, p.channels));
                if of_left != of_right {
                    return Err(format!(
                        "{a} and {b} have different sizes and channels: {of_left:?} and {of_right:?}"
                    ));
                }
                let found = Difference::of(&left, &right);
                if found.is_within(ALIKE) {
                    Ok(())
                } else {
                    let Difference { mean, percent } = found;
                    Err(format!(
                        "{a} and {b} differ by {mean:.2} of 255 on average, and visibly in {percent:.2} % of the pixels"
                    ))
                }
            }
            Self::Stdout(text) => contains("stdout", &printed.stdout, text),
            Self::Stderr(text) => contains("stderr", &printed.stderr, text),
        }
    }
}

fn contains(what: &str, all: &str, text: &str) -> Result<(), String> {
    if all.contains(text) { Ok(()) } else { Err(format!("{text:?} is not on {what}:\n{all}")) }
}

/// A PNG picture with 8 bits per channel.
pub(crate) struct Picture {
    size: [u32; 2],
    channels: usize,
    /// Row by row.
    bytes: Vec<u8>,
}

pub(crate) fn picture(path: &Path) -> Result<Picture, String> {
    let read = || -> Result<Picture, png::DecodingError> {
        let mut decoder = png::Decoder::new(BufReader::new(File::open(path)?));
        decoder.set_transformations(png::Transformations::normalize_to_color8());
        let mut reader = decoder.read_info()?;
        let mut bytes = vec![0; reader.output_buffer_size().unwrap_or_default()];
        let frame = reader.next_frame(&mut bytes)?;
        bytes.truncate(frame.buffer_size());
        Ok(Picture { size: [frame.width, frame.height], channels: frame.color_type.samples(), bytes })
    };
    read().map_err(|e| format!("{}: {e}", path.display()))
}

pub(crate) fn is_one_colour(picture: &Picture) -> bool {
    let mut pixels = picture.bytes.chunks_exact(picture.channels);
    let first = pixels.next();
    pixels.all(|p| Some(p) == first)
}

/// Writes an RGB picture with 8 bits per channel.
#[cfg(test)]
pub(crate) fn write_picture(path: &Path, [width, height]: [u32; 2], rgb: &[u8]) {
    let mut encoder = png::Encoder::new(File::create(path).unwrap(), width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(rgb).unwrap();
}

/// Returns the lines of a `text` block that the commands did not print. Every run of digits, points, hyphens
/// and spaces matches any other, because times and sizes differ.
pub(crate) fn not_printed(shown: &[String], stdout: &str) -> Vec<String> {
    let printed: Vec<String> = stdout.lines().map(without_numbers).collect();
    let missing = |line: &&String| !line.trim().is_empty() && !printed.contains(&without_numbers(line));
    shown
        .iter()
        .filter(missing)
        .map(|line| format!("{line:?} is shown but was not printed:\n{stdout}"))
        .collect()
}

fn without_numbers(line: &str) -> String {
    let (mut text, mut blank) = (String::new(), false);
    for c in line.trim().chars() {
        let any = c.is_ascii_digit() || matches!(c, '.' | ' ' | '-');
        if !any {
            text.push(c);
        } else if !blank {
            text.push(' ');
        }
        blank = any;
    }
    text.trim().to_owned()
}

/// Splits the text into clauses, and each clause into words. Quotes hold a word together, with \" and \\
/// inside.
fn clauses(text: &str) -> Result<Vec<Vec<String>>, String> {
    let (mut all, mut words, mut word) = (Vec::new(), Vec::new(), None::<String>);
    let mut characters = text.chars();
    while let Some(c) = characters.next() {
        match c {
            '"' => {
                let open = word.get_or_insert_default();
                loop {
                    match characters.next() {
                        Some('"') => break,
                        Some('\\') => open.extend(characters.next()),
                        Some(other) => open.push(other),
                        None => return Err(format!("unterminated quote: {text}")),
                    }
                }
            }
            ';' | ' ' => {
                words.extend(word.take());
                if c == ';' {
                    all.push(std::mem::take(&mut words));
                }
            }
            other => word.get_or_insert_default().push(other),
        }
    }
    words.extend(word);
    all.push(words);
    all.retain(|clause| !clause.is_empty());
    if all.is_empty() { Err("empty check: give at least `exit 0`".to_owned()) } else { Ok(all) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn check_reads_every_clause() {
        let text = r#"exit 3; long; parse; exists a b; quick "x; y" => "z \"q\""; stdout "so; so""#;
        assert_eq!(Check::parse(text).unwrap_err(), "exists a b: give MIN..MAX or MIN..");
        let check = Check::parse(&text.replace("a b", "a 2..30")).unwrap();
        assert_eq!((check.exit, check.long, check.parse), (3, true, true));
        assert_eq!(check.quick, [("x; y".to_owned(), "z \"q\"".to_owned())]);
        assert_eq!(
            check.expected,
            [
                Expected::Exists { path: "a".to_owned(), least: 2, most: 30 },
                Expected::Stdout("so; so".to_owned())
            ]
        );
        for wrong in ["", " ; ", "exits 3", "exit x", "picture a 3", "stdout \"open"] {
            assert!(Check::parse(wrong).is_err(), "{wrong:?}");
        }
    }

    #[test]
    fn check_reports_clauses_that_fail() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("five"), "five!").unwrap();
        write_picture(&at("flat.png"), [2, 3], &[7; 18]);
        write_picture(&at("two.png"), [2, 3], &[0, 0, 0, 200, 200, 200].repeat(3));
        let printed = Printed { stdout: "all is well".to_owned(), stderr: String::new() };
        let faults = |text: &str| Check::parse(text).unwrap().faults(folder.path(), &printed).len();
        assert_eq!(faults("exists five 5..5; picture two.png 2x3; alike two.png two.png; stdout well"), 0);
        assert_eq!(faults("equal five five; exists five; picture two.png"), 0);
        for wrong in [
            "exists five 6..",
            "exists six",
            "picture flat.png",
            "picture two.png 3x2",
            "picture five",
            "alike flat.png two.png",
            "equal five two.png",
            "stderr well",
            "stdout bad",
        ] {
            assert_eq!(faults(wrong), 1, "{wrong}");
        }
    }

    #[test]
    fn alike_pictures_differ_little_and_in_few_pixels() {
        let folder = tempfile::tempdir().unwrap();
        let faults = |name: &str, pixels: usize, by: u8| {
            let mut rgb = vec![200; 3 * 100 * 100];
            rgb[..3 * pixels].fill(200 - by);
            write_picture(&folder.path().join(name), [100, 100], &rgb);
            Check::parse(&format!("alike plain.png {name}"))
                .unwrap()
                .faults(folder.path(), &Printed::default())
        };
        assert!(faults("plain.png", 0, 0).is_empty());
        for (pixels, by) in [(50, 200), (51, VISIBLE), (10_000, 3)] {
            assert!(faults("alike.png", pixels, by).is_empty(), "{pixels} by {by}");
        }
        assert_eq!(
            faults("line.png", 51, VISIBLE + 1),
            ["plain.png and line.png differ by 0.13 of 255 on average, and visibly in 0.51 % of the pixels"]
        );
        assert_eq!(faults("darker.png", 10_000, 4).len(), 1);
    }

    #[test]
    fn shown_output_matches_with_other_numbers() {
        let shown = ["a   12.5 s of 3".to_owned(), String::new(), "b ok".to_owned()];
        assert!(not_printed(&shown, "x\na 1 s of 44\nb ok\n").is_empty());
        assert_eq!(not_printed(&shown, "a 1 ms of 44\nb ok\n").len(), 1);
    }
}
