//! Writes shapes as half-words, each after the shapes that it points to, in the shortest form that holds it.
//! Given shapes in a given order are written in only one way.

use crate::layout::depths::child::{Child, Children, ShapeRef};
use crate::layout::depths::code::{FAR, FAR_BITS, FAR_DELTA_BITS, NEAR, SHORT_BITS};

/// A shape or a difference is out of reach of the longest pointer. Limits on bakes prevent this.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "a part of the quadtree is too large: a distance above 2^25 half-words, or a difference of depths above 2^21"
)]
pub struct OutOfReach;

/// Writes the shapes of a page, or of the common section.
#[derive(Debug)]
pub struct Writer {
    is_common: bool,
    halves: Vec<u16>,
}

impl Writer {
    /// Begins a page.
    pub fn page() -> Self {
        Self { is_common: false, halves: Vec::new() }
    }

    /// Begins a common section.
    pub fn common() -> Self {
        Self { is_common: true, halves: Vec::new() }
    }

    /// Writes a leaf and returns its address.
    pub fn leaf(&mut self, halves: &[u16]) -> u32 {
        let at = self.halves.len() as u32;
        self.halves.extend_from_slice(halves);
        at
    }

    /// Writes a node and returns its address. In a common section, the
    /// shapes of its children are [`ShapeRef::Here`].
    ///
    /// # Errors
    /// Returns [`OutOfReach`] if a child needs more bits than a pointer has.
    pub fn node(&mut self, children: &Children<ShapeRef>) -> Result<u32, OutOfReach> {
        let from = self.halves.len() as u32;
        let mut bits = [0_u16; 3];
        self.halves.extend(bits);
        for (c, child) in children.iter().enumerate() {
            let mut put = |[high, low, kind]: [u16; 3], fields: &[u16]| {
                bits[0] |= low << c;
                bits[1] |= high << c;
                bits[2] |= kind << c;
                self.halves.extend_from_slice(fields);
            };
            match *child {
                Child::Never => put([0, 0, 1], &[]),
                Child::Uniform(0) => put([0, 0, 0], &[]),
                Child::Uniform(delta) => match fits(delta, 16) {
                    true => put([0, 1, 1], &[delta as u16]),
                    false => put([1, 1, 0], &far(delta, FAR)?),
                },
                Child::Shape { shape, delta } => {
                    let (address, distance) = match shape {
                        ShapeRef::Common(at) => (Some(at), None),
                        ShapeRef::Here(at) => (self.is_common.then_some(at), Some(from - at)),
                    };
                    let near = match (address, distance) {
                        (Some(at), _) if at < NEAR => Some(at as u16),
                        (_, Some(back)) if back < NEAR => Some((NEAR | back) as u16),
                        _ => None,
                    };
                    let short = distance.filter(|&back| back < 1 << SHORT_BITS && fits(delta, 8));
                    match (near, short) {
                        (Some(near), _) if delta == 0 => put([0, 1, 0], &[near]),
                        (_, Some(back)) => put([1, 0, 0], &[(delta << SHORT_BITS | back) as u16]),
                        (Some(near), _) if fits(delta, 16) => put([1, 0, 1], &[delta as u16, near]),
                        _ => {
                            let pointer = match (address, distance) {
                                (Some(at), _) => at,
                                (None, back) => FAR | back.unwrap_or_default(),
                            };
                            put([1, 1, 0], &far(delta, pointer)?);
                        }
                    }
                }
            }
        }
        self.halves[from as usize..][..3].copy_from_slice(&bits);
        Ok(from)
    }

    /// Returns the number of half-words that have been written.
    pub(crate) fn half_count(&self) -> usize {
        self.halves.len()
    }

    /// Returns what has been written, as words.
    pub fn words(&self) -> Vec<u32> {
        let word = |two: &[u16]| u32::from(two[0]) | two.get(1).map_or(0, |&high| u32::from(high) << 16);
        self.halves.chunks(2).map(word).collect()
    }
}

/// Whether a difference fits `bits` bits in two's complement.
fn fits(delta: u32, bits: u32) -> bool {
    let limit = 1 << (bits - 1);
    (-limit..limit).contains(&(delta as i32))
}

/// Returns the half-words of a far pointer with a difference. `pointer` is an address, or [`FAR`] and a
/// distance.
fn far(delta: u32, pointer: u32) -> Result<[u16; 3], OutOfReach> {
    if !fits(delta, FAR_DELTA_BITS) || (pointer & !FAR) >> FAR_BITS != 0 {
        return Err(OutOfReach);
    }
    let word = pointer | delta >> 16 << FAR_BITS & !FAR;
    Ok([delta as u16, word as u16, (word >> 16) as u16])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::depths::code::Code;

    /// Writes a node after `filler` half-words, and reads its first child back.
    fn there_and_back(mut writer: Writer, filler: usize, child: Child<ShapeRef>) -> (usize, Child<ShapeRef>) {
        writer.leaf(&vec![0; filler]);
        let mut children = [Child::Never; 16];
        children[0] = child;
        let at = writer.node(&children).unwrap();
        let fields = writer.halves.len() - at as usize - 3;
        (fields, Code { words: &writer.words() }.child(at, 0))
    }

    #[test]
    fn child_takes_the_shortest_form() {
        let shape = |delta: i32, shape| Child::Shape { delta: delta as u32, shape };
        for (filler, child, fields) in [
            (300, Child::Never, 0),
            (300, Child::Uniform(0), 0),
            (300, Child::Uniform(-32_768_i32 as u32), 1),
            (300, Child::Uniform(32_768), 3),
            (300, Child::Uniform(-2_097_152_i32 as u32), 3),
            (300, shape(0, ShapeRef::Here(0)), 1),
            (300, shape(0, ShapeRef::Common(32_767)), 1),
            (300, shape(0, ShapeRef::Common(32_768)), 3),
            (300, shape(-128, ShapeRef::Here(45)), 1),
            (300, shape(127, ShapeRef::Here(298)), 1),
            (300, shape(128, ShapeRef::Here(298)), 2),
            (300, shape(1, ShapeRef::Here(44)), 2),
            (300, shape(1, ShapeRef::Common(44)), 2),
            (300, shape(32_768, ShapeRef::Common(44)), 3),
            (40_000, shape(0, ShapeRef::Here(7_233)), 1),
            (40_000, shape(0, ShapeRef::Here(7_232)), 3),
            (40_000, shape(2_097_151, ShapeRef::Here(3)), 3),
            (40_000, shape(-2_097_152, ShapeRef::Common(1 << 24)), 3),
        ] {
            assert_eq!(there_and_back(Writer::page(), filler, child), (fields, child), "{child:?}");
        }
    }

    #[test]
    fn common_section_prefers_addresses() {
        let shape = |shape| Child::Shape { delta: 0, shape };
        use ShapeRef::{Common, Here};
        for (at, read) in [(300, Common(300)), (32_768, Here(32_768)), (39_999, Here(39_999))] {
            assert_eq!(there_and_back(Writer::common(), 40_000, shape(Here(at))), (1, shape(read)));
        }
        let far = there_and_back(Writer::common(), 80_000, shape(Here(33_000)));
        assert_eq!(far, (3, shape(Common(33_000))));
    }

    #[test]
    fn out_of_reach_is_an_error() {
        let mut writer = Writer::page();
        for child in [
            Child::Uniform(2_097_152),
            Child::Shape { delta: 0, shape: ShapeRef::Common(1 << 25) },
            Child::Shape { delta: 1 << 30, shape: ShapeRef::Common(3) },
        ] {
            let mut children = [Child::Never; 16];
            children[5] = child;
            assert_eq!(writer.node(&children), Err(OutOfReach), "{child:?}");
        }
    }
}
