//! The inside of a leaf: its head, its slant and the differences of its depths.

use super::Fault;
use super::contour::{Leaf, class};
use super::edges::Facing;
use super::rans::Coder;
use super::walk::{RECENT_SLANTS, Walk, to_front};

/// Symbols of a leaf's head. 0 is a single depth, which is slanted. Then each last rank from 1 to 3 has four,
/// by whether the last depth is never and whether the leaf is slanted.
const FROM_4: u32 = 13;
const FROM_8: u32 = 14;
/// Symbol of a gradient that is coded by its change. 0 and 1 are those above and to the left, the others
/// recent ones.
const OTHER_SLANT: u32 = 15;

impl<C: Coder> Walk<'_, C> {
    /// Codes the number of depths, whether the last is never, and the gradient.
    pub(super) fn head(&mut self, [x, y]: [usize; 2], leaf: &mut Leaf) -> Result<(), Fault> {
        let facing = [self.edges.above[x / 8], self.edges.left[y / 8]];
        let look = |f: Facing| match (f.kind, usize::from(f.slant != 0)) {
            (0, _) => usize::from(f.class == class::NEVER),
            (1..=3, slanted) => 2 + slanted,
            (_, slanted) => 4 + slanted,
        };
        let flags = u32::from(leaf.never) + 2 * u32::from(leaf.slant != 0);
        let head = match leaf.last {
            0 => 0,
            last @ 1..4 => 4 * last - 3 + flags,
            4..8 => FROM_4,
            _ => FROM_8,
        };
        let (coder, model) = (&mut self.coder, &mut *self.model);
        let head = coder.symbol(&mut model.head[look(facing[0]) * 6 + look(facing[1])], head);
        let (last, flags) = match head {
            0 => (0, 2),
            1..FROM_4 => (head.div_ceil(4), (head - 1) & 3),
            _ => {
                let (many, first) = if head == FROM_4 { (0, 4) } else { (1, 8) };
                let more = coder.symbol(&mut model.last[many], leaf.last.wrapping_sub(first).min(15));
                let rest =
                    if more == 15 { coder.plain(6, leaf.last.wrapping_sub(first + 15) & 63) } else { 0 };
                let never = coder.bit(&mut model.never[many], flags & 1);
                let slanted = coder.bit(&mut model.slanted[many][never as usize], flags >> 1);
                ((first + more + rest).min(63), never + 2 * slanted)
            }
        };
        leaf.last = last;
        leaf.never = flags & 1 == 1;
        if flags & 2 != 0 {
            leaf.slant = self.slant(leaf.slant, facing.map(|f| f.slant.into()));
        }
        // A single depth without a gradient is not a leaf.
        if last == 0 && leaf.slant == 0 { Err(Fault) } else { Ok(()) }
    }

    /// Codes a gradient. `guesses` are those above and to the left, or 0.
    fn slant(&mut self, slant: u32, guesses: [u32; 2]) -> u32 {
        let (coder, model) = (&mut self.coder, &mut *self.model);
        let context = if guesses[0] != guesses[1] { 2 } else { usize::from(guesses[0] != 0) };
        let way = match guesses.iter().position(|&guess| guess == slant) {
            Some(guess) => guess as u32,
            None if C::DECODES => 0,
            None => {
                let place = self.recent_slants.iter().position(|&s| u32::from(s) == slant);
                place.map_or(OTHER_SLANT, |place| 2 + place as u32)
            }
        };
        let slant = match coder.symbol(&mut model.slant[context], way) {
            way @ 0..2 => guesses[way as usize],
            way @ 2..OTHER_SLANT => self.recent_slants[way as usize - 2].into(),
            _ => {
                let known = guesses.into_iter().find(|&guess| guess != 0);
                let guess = known.unwrap_or(self.recent_slants[0].into());
                let mut byte = |number: usize| {
                    let [from, to] = [guess, slant].map(|s| s >> (8 * number));
                    let step = model.gradient[number].signed(coder, to.wrapping_sub(from) as i8 as u32);
                    (from.wrapping_add(step) & 0xff) << (8 * number)
                };
                byte(0) | byte(1)
            }
        };
        to_front::<_, RECENT_SLANTS>(&mut self.recent_slants, slant as u16);
        slant
    }

    /// Codes the differences of a leaf's depths. `depth` is its base.
    pub(super) fn differences(&mut self, at: [usize; 2], mut depth: u32, leaf: &mut Leaf) {
        let stored = leaf.stored();
        if stored == 0 {
            return;
        }
        let cells = self.edges.facing_cells(at, leaf.slant);
        let kind = (leaf.last as usize - 1).min(3) * 2 + usize::from(leaf.slant != 0);
        for (i, difference) in leaf.differences[..stored].iter_mut().enumerate() {
            // Distance less 1 to the next facing depth.
            let next =
                cells.iter().fold(u32::MAX, |next, cell| next.min(cell.wrapping_sub(depth).wrapping_sub(1)));
            let context = i.min(2) * 8 + kind;
            let mut hit = 0;
            if next < 1 << 15 {
                let length = (32 - (next + 1).leading_zeros()).min(7) as usize;
                let bit = &mut self.model.difference_hit[context][length];
                hit = self.coder.bit(bit, u32::from(*difference == next + 1));
            }
            *difference = if hit == 1 {
                next + 1
            } else {
                let number = &mut self.model.difference[context];
                number.code(&mut self.coder, difference.wrapping_sub(1)).saturating_add(1)
            };
            depth = depth.wrapping_add(*difference);
        }
    }
}
