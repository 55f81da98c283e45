//! The texture statements of MTL files: `map_d -s 2 2 1 -clamp on leaf.png` (Wavefront's MTL text, "Options
//! for texture map statements").
//!
//! `-s`, `-o`, `-clamp`, `-imfchan` and `-mm` are applied. `-blendu`, `-blendv`, `-boost`, `-texres`, `-cc`,
//! `-bm` and `-type` do not affect masks. `-t` moves coordinates by a noise that the format does not define,
//! so it is reported.

use crate::obj::text::{Name, number, shown, trim, unquoted, words};

/// The image channel that is used as a scalar texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Channel {
    Red,
    Green,
    Blue,
    /// `m`: the alpha of the supported formats.
    Matte,
    Luminance,
    /// `z`, which no supported format has.
    Depth,
}

/// Maps texture coordinates of the file to those of a texture: multiplies by `scale`, then adds `offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placing {
    scale: [f32; 2],
    offset: [f32; 2],
}

/// A texture statement.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Map {
    /// The words that may be the file's name, best first, without quotes.
    names: [Vec<u8>; 3],
    pub(super) placing: Placing,
    /// Whether the texture ends at its edges instead of repeating.
    pub(super) clamps: bool,
    /// The channel that the statement asks for.
    pub(super) channel: Option<Channel>,
    /// A value becomes `base + gain * value`.
    pub(super) base_and_gain: [f32; 2],
    /// Whether the statement asks for turbulence.
    pub(super) turbulent: bool,
}

impl Default for Placing {
    fn default() -> Self {
        Self { scale: [1.0; 2], offset: [0.0; 2] }
    }
}

impl Placing {
    /// The coordinates in glTF's convention, from the top left corner; OBJ's are from the bottom left. A
    /// result that is not finite becomes 0.
    pub(super) fn apply(&self, uv: [f32; 2]) -> [f32; 2] {
        let [u, v] = [0, 1].map(|a| uv[a] * self.scale[a] + self.offset[a]);
        [u, 1.0 - v].map(|c| if c.is_finite() { c } else { 0.0 })
    }
}

impl Map {
    /// Parses the statement after its keyword; `None` if there is no file name.
    pub(super) fn of(statement: &Name) -> Option<Self> {
        let mut map = Self {
            names: Default::default(),
            placing: Placing::default(),
            clamps: false,
            channel: None,
            base_and_gain: [0.0, 1.0],
            turbulent: false,
        };
        let name = map.read_options(&statement.short);
        if name.is_empty() {
            return None;
        }
        // The long form differs only by the comment at its end.
        let long = statement.long.get(statement.short.len() - name.len()..).unwrap_or_default();
        let last = words(name).next_back().unwrap_or_default();
        map.names = [name, long, last].map(|name| unquoted(trim(name)).to_owned());
        Some(map)
    }

    /// The names that the file may have, best first.
    pub(super) fn file_names(&self) -> Vec<&[u8]> {
        let mut names: Vec<&[u8]> = Vec::new();
        for name in &self.names {
            if !name.is_empty() && !names.contains(&name.as_slice()) {
                names.push(name);
            }
        }
        names
    }

    /// The file's name for messages.
    pub(super) fn shown(&self) -> String {
        shown(&self.names[0]).into_owned()
    }

    /// Whether two statements name the same file.
    pub(super) fn is_file_of(&self, other: &Self) -> bool {
        self.names[0].eq_ignore_ascii_case(&other.names[0])
    }

    /// Reads the options, and returns the text after them, which includes the last word.
    fn read_options<'t>(&mut self, text: &'t [u8]) -> &'t [u8] {
        let mut text = trim(text);
        while text.starts_with(b"-")
            && let Some((option, mut rest)) = next_word(text)
        {
            let mut values = Values { text: &mut rest };
            match option.to_ascii_lowercase().as_slice() {
                b"-s" => values.up_to_two(&mut self.placing.scale),
                b"-o" => values.up_to_two(&mut self.placing.offset),
                b"-t" => {
                    let mut by = [0.0; 2];
                    values.up_to_two(&mut by);
                    self.turbulent = by != [0.0; 2];
                }
                b"-mm" => {
                    if let Some([base, gain]) = values.two() {
                        self.base_and_gain = [base, gain];
                    }
                }
                b"-clamp" => self.clamps = values.word().eq_ignore_ascii_case(b"on"),
                b"-imfchan" => {
                    self.channel = match values.word().to_ascii_lowercase().as_slice() {
                        b"r" => Some(Channel::Red),
                        b"g" => Some(Channel::Green),
                        b"b" => Some(Channel::Blue),
                        b"m" | b"a" => Some(Channel::Matte),
                        b"l" => Some(Channel::Luminance),
                        b"z" => Some(Channel::Depth),
                        _ => None,
                    }
                }
                b"-blendu" | b"-blendv" | b"-boost" | b"-texres" | b"-cc" | b"-bm" | b"-type" => {
                    values.word();
                }
                // A file's name may begin with a dash.
                _ => return text,
            }
            text = rest;
        }
        text
    }
}

/// Reads the values of an option. The last word of a statement is never a value, because it is the file's
/// name.
struct Values<'v, 't> {
    text: &'v mut &'t [u8],
}

impl<'t> Values<'_, 't> {
    fn word(&mut self) -> &'t [u8] {
        match next_word(self.text) {
            Some((word, rest)) => {
                *self.text = rest;
                word
            }
            None => &[],
        }
    }

    fn number(&mut self) -> Option<f32> {
        let (word, rest) = next_word(self.text)?;
        let value = number(word)? as f32;
        *self.text = rest;
        Some(if value.is_finite() { value } else { 0.0 })
    }

    /// One to three numbers, of which the third is for solid textures.
    fn up_to_two(&mut self, out: &mut [f32; 2]) {
        for i in 0..3 {
            let Some(value) = self.number() else { return };
            if let Some(out) = out.get_mut(i) {
                *out = value;
            }
        }
    }

    fn two(&mut self) -> Option<[f32; 2]> {
        Some([self.number()?, self.number()?])
    }
}

/// The first word and the text after it; `None` if nothing follows.
fn next_word(text: &[u8]) -> Option<(&[u8], &[u8])> {
    let word = words(text).next()?;
    let rest = trim(text.get(word.len()..)?);
    if rest.is_empty() { None } else { Some((word, rest)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(text: &str) -> Map {
        let text = text.as_bytes().to_vec();
        Map::of(&Name { short: text.clone(), long: text }).expect("names a file")
    }

    #[test]
    fn parses_options_of_texture_statements() {
        let m =
            map("-s 2 3 1 -o 0.5 -clamp on -imfchan M -mm 1 -1 -bm 2 -texres 64 -type sphere my leaf.png");
        assert_eq!(m.names[0], b"my leaf.png");
        assert_eq!(m.placing, Placing { scale: [2.0, 3.0], offset: [0.5, 0.0] });
        assert_eq!((m.clamps, m.channel, m.base_and_gain), (true, Some(Channel::Matte), [1.0, -1.0]));
        assert_eq!(m.placing.apply([0.25, 0.25]), [1.0, 0.25]);
        assert!(map("-t 0.1 a.png").turbulent && !map("-t 0 0 0 a.png").turbulent);
        // A file may be named by a number, or begin with a dash.
        for (text, name) in
            [("-s 1 1 1 7", "7"), ("-s 1 2", "2"), ("-leaf.png", "-leaf.png"), ("-s -", "-"), ("-o", "-o")]
        {
            assert_eq!(map(text).names[0], name.as_bytes(), "{text}");
        }
        assert_eq!(map("-new 1 a.png").file_names(), [&b"-new 1 a.png"[..], b"a.png"]);
        assert_eq!(Map::of(&Name::default()), None);
        assert_eq!(map("-s nan 1 a.png").placing.scale, [0.0, 1.0]);
    }

    #[test]
    fn comments_may_be_part_of_the_file_name() {
        let name = Name { short: b"-o 1 leaf".to_vec(), long: b"-o 1 leaf #2.png".to_vec() };
        let map = Map::of(&name).expect("names a file");
        assert_eq!(map.file_names(), [&b"leaf"[..], b"leaf #2.png"]);
    }
}
