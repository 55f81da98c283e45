//! Range asymmetric numeral systems with two interleaved states, and adaptive probabilities.
//!
//! A state has 32 bits and is at least 2^16 between two steps. A symbol has an interval of the numbers
//! below 2^scale, which begins at `start` and is as long as its `frequency`. To decode, the state's lowest
//! `scale` bits select the symbol whose interval contains them. The state then becomes
//! `frequency · (state >> scale) + low bits − start`. If it is below 2^16, the next half-word is appended to
//! it as its lower half. Then the states change places.
//!
//! The bytes are the two initial states, followed by half-words, all little-endian. Both states are 2^16 at
//! the end. Thus a decoder can tell whether it read what an encoder wrote.

use super::Fault;

/// Logarithm of the sum of a bit's two frequencies.
const BIT_SCALE: u32 = 12;
/// Logarithm of the sum of a symbol's frequencies.
const SYMBOL_SCALE: u32 = 15;
/// Shift by which the probability of a bit moves towards the coded bit.
const BIT_SHIFT: u32 = 4;
/// States are at least this between two steps.
const LEAST_STATE: u32 = 1 << 16;

/// Adaptive probability that a bit is 1, in 65536ths.
#[derive(Clone, Copy)]
pub(super) struct Bit(u16);

impl Bit {
    /// Both values are equally likely.
    pub(super) const NEW: Self = Self(1 << 15);

    /// Returns the frequency of 1, which is from 1 to 4095. Its interval begins at 0.
    #[inline(always)]
    fn frequency(self) -> u32 {
        u32::from(self.0) >> (16 - BIT_SCALE) | 1
    }

    #[inline(always)]
    fn adapt(&mut self, bit: u32) {
        let target = (bit * 0xffff) as i32;
        let probability = i32::from(self.0);
        self.0 = (probability + ((target - probability) >> BIT_SHIFT)) as u16;
    }
}

/// Adaptive probabilities of sixteen symbols.
#[derive(Clone, Copy)]
pub(super) struct Symbol {
    /// Where the interval of each symbol begins.
    starts: [i16; 16],
    /// Number of symbols that were coded, at most 31.
    count: u16,
}

/// Shifts by which intervals move towards the coded symbol, by the number of symbols coded before.
const SHIFTS: [u8; 32] = {
    let mut shifts = [4; 32];
    let mut count = 0;
    while count < 6 {
        shifts[count] = if count < 2 { 2 } else { 3 };
        count += 1;
    }
    shifts[31] = 5;
    shifts
};

/// The frequency that symbols 0 to 14 approach if they are not coded.
const LEAST_FREQUENCY: i16 = 48;

/// The starts that intervals approach if only one symbol is coded, by that symbol.
const TARGETS: [[i16; 16]; 16] = {
    let mut targets = [[0; 16]; 16];
    let mut at = 0;
    while at < 256 {
        let [symbol, i] = [at / 16, at % 16];
        let beyond = if i > symbol { i16::MAX - 15 * LEAST_FREQUENCY } else { 0 };
        targets[symbol][i] = LEAST_FREQUENCY * i as i16 + beyond;
        at += 1;
    }
    targets
};

impl Symbol {
    /// All symbols are equally likely.
    pub(super) const NEW: Self = {
        let mut starts = [0; 16];
        let mut i = 0;
        while i < 16 {
            starts[i] = (i as i16) << (SYMBOL_SCALE - 4);
            i += 1;
        }
        Self { starts, count: 0 }
    };

    /// Intervals stay in order and are never empty: targets are [`LEAST_FREQUENCY`] apart, so a shorter
    /// interval grows.
    #[inline(never)]
    pub(super) fn adapt(&mut self, symbol: u32) {
        let shift = SHIFTS[self.count as usize & 31] & 15;
        self.count += u16::from(self.count < 31);
        for (start, target) in self.starts.iter_mut().zip(TARGETS[symbol as usize & 15]) {
            *start += (target - *start) >> shift;
        }
    }

    /// Returns the start of a symbol's interval, and its frequency.
    #[inline(always)]
    pub(super) fn interval(&self, symbol: u32) -> [u32; 2] {
        let start = self.starts[symbol as usize & 15] as u32;
        let next = self.starts[(symbol as usize + 1) & 15] as u32;
        [start, if symbol == 15 { 1 << SYMBOL_SCALE } else { next } - start]
    }

    /// Returns the symbol whose interval contains a value.
    #[inline(always)]
    fn find(&self, value: u32) -> u32 {
        let reached = |i: usize| usize::from(i32::from(self.starts[i]) <= value as i32);
        if reached(1) == 0 {
            return 0;
        }
        let four = 4 * (reached(4) + reached(8) + reached(12));
        (four + reached(four + 1) + reached(four + 2) + reached(four + 3)) as u32
    }
}

/// Codes in either direction, so that one description of the contents serves both. A decoder ignores the last
/// argument of each method and returns what it reads. An encoder returns that argument.
pub(super) trait Coder: Default {
    /// Whether this is a decoder.
    const DECODES: bool;

    /// Codes a bit.
    fn bit(&mut self, model: &mut Bit, bit: u32) -> u32;

    /// Codes a symbol below 16.
    fn symbol(&mut self, model: &mut Symbol, symbol: u32) -> u32;

    /// Codes a number of `count` bits, all of which are equally likely. The highest 16 bits come first.
    fn plain(&mut self, count: u32, number: u32) -> u32;
}

/// Reads coded bytes.
#[derive(Default)]
pub(super) struct Decoder<'b> {
    bytes: &'b [u8],
    at: usize,
    /// The state of the next step, and the other.
    states: [u32; 2],
}

impl<'b> Decoder<'b> {
    /// Begins to read.
    pub(super) fn new(bytes: &'b [u8]) -> Self {
        let mut decoder = Self { bytes, at: 0, states: [0; 2] };
        let mut half = || {
            let half = decoder.peek();
            decoder.at += 2;
            half
        };
        decoder.states = [0, 1].map(|_| half() | half() << 16);
        decoder
    }

    /// Checks that the bytes end here, or after the zeros that pad them to `least_bytes`.
    pub(super) fn finish(self, least_bytes: usize) -> Result<(), Fault> {
        let rest = self.bytes.get(self.at..).ok_or(Fault)?;
        let is_end = self.bytes.len() == self.at.max(least_bytes) && rest.iter().all(|&byte| byte == 0);
        if is_end && self.states == [LEAST_STATE; 2] { Ok(()) } else { Err(Fault) }
    }

    /// Returns the next half-word, or 0 after the last.
    #[inline(always)]
    fn peek(&self) -> u32 {
        match self.bytes.get(self.at..self.at + 2) {
            Some(two) => u32::from(two[0]) | u32::from(two[1]) << 8,
            None => 0,
        }
    }

    /// Sets the state after a step. It has no branch, because a branch would often be mispredicted.
    #[inline(always)]
    fn advance(&mut self, state: u32) {
        let half = self.peek();
        let is_small = state < LEAST_STATE;
        self.at += 2 * usize::from(is_small);
        self.states = [self.states[1], if is_small { state << 16 | half } else { state }];
    }
}

impl Coder for Decoder<'_> {
    const DECODES: bool = true;

    #[inline(always)]
    fn bit(&mut self, model: &mut Bit, _: u32) -> u32 {
        let (state, ones) = (self.states[0], model.frequency());
        let value = state & ((1 << BIT_SCALE) - 1);
        let (bit, frequency, rest) =
            if value < ones { (1, ones, value) } else { (0, (1 << BIT_SCALE) - ones, value - ones) };
        model.adapt(bit);
        self.advance(frequency * (state >> BIT_SCALE) + rest);
        bit
    }

    #[inline(always)]
    fn symbol(&mut self, model: &mut Symbol, _: u32) -> u32 {
        let state = self.states[0];
        let value = state & ((1 << SYMBOL_SCALE) - 1);
        let symbol = model.find(value);
        let [start, frequency] = model.interval(symbol);
        model.adapt(symbol);
        self.advance(frequency * (state >> SYMBOL_SCALE) + (value - start));
        symbol
    }

    #[inline]
    fn plain(&mut self, count: u32, _: u32) -> u32 {
        let (mut number, mut left) = (0, count);
        while left > 0 {
            let bits = left.min(16);
            let state = self.states[0];
            number = number << bits | state & ((1 << bits) - 1);
            self.advance(state >> bits);
            left -= bits;
        }
        number
    }
}

/// One step of an encoder.
///
/// | bits | a bit or a symbol | plain bits |
/// |---|---|---|
/// | 0 to 1 | 0: a bit; 1: a symbol | 2 |
/// | 2 to 16 | start of the interval | number of bits, from 1 to 16 |
/// | 17 to 31 | length of the interval | |
/// | 16 to 31 | | the bits |
///
/// The symbol with the interval from 0x123 of length 0x456 is 0x08ac048d.
#[derive(Clone, Copy)]
struct CodingStep(u32);

impl CodingStep {
    fn bit([start, frequency]: [u32; 2]) -> Self {
        Self(start << 2 | frequency << 17)
    }

    fn symbol([start, frequency]: [u32; 2]) -> Self {
        Self(1 | start << 2 | frequency << 17)
    }

    fn plain(count: u32, bits: u32) -> Self {
        Self(2 | count << 2 | bits << 16)
    }

    /// Returns the start and the length of the interval, and the scale: the base-2 logarithm of the sum of
    /// frequencies.
    fn interval(self) -> (u32, u32, u32) {
        let Self(step) = self;
        match step & 3 {
            0 => (step >> 2 & 0x7fff, step >> 17, BIT_SCALE),
            1 => (step >> 2 & 0x7fff, step >> 17, SYMBOL_SCALE),
            _ => (step >> 16, 1, step >> 2 & 0x1f),
        }
    }
}

/// Writes coded bytes. Encoding runs through the steps in reverse order, so all steps are kept until the end.
#[derive(Default)]
pub(super) struct Encoder {
    steps: Vec<CodingStep>,
}

impl Encoder {
    /// Returns the coded bytes, padded with zeros to `least_bytes`.
    pub(super) fn finish(self, least_bytes: usize) -> Vec<u8> {
        let mut halves: Vec<u16> = Vec::new();
        let mut states = [LEAST_STATE; 2];
        for (i, step) in self.steps.iter().enumerate().rev() {
            let (start, frequency, scale) = step.interval();
            let state = &mut states[i & 1];
            if u64::from(*state) >= u64::from(frequency) << (32 - scale) {
                halves.push(*state as u16);
                *state >>= 16;
            }
            *state = ((*state / frequency) << scale) + *state % frequency + start;
        }
        let initial = states.map(|state| [state as u16, (state >> 16) as u16]);
        let halves = initial.iter().flatten().chain(halves.iter().rev());
        let mut bytes: Vec<u8> = halves.flat_map(|half| half.to_le_bytes()).collect();
        bytes.resize(bytes.len().max(least_bytes), 0);
        bytes
    }
}

impl Coder for Encoder {
    const DECODES: bool = false;

    fn bit(&mut self, model: &mut Bit, bit: u32) -> u32 {
        let ones = model.frequency();
        let interval = if bit == 1 { [0, ones] } else { [ones, (1 << BIT_SCALE) - ones] };
        self.steps.push(CodingStep::bit(interval));
        model.adapt(bit);
        bit
    }

    fn symbol(&mut self, model: &mut Symbol, symbol: u32) -> u32 {
        self.steps.push(CodingStep::symbol(model.interval(symbol)));
        model.adapt(symbol);
        symbol
    }

    fn plain(&mut self, count: u32, number: u32) -> u32 {
        let mut left = count;
        while left > 0 {
            let bits = left.min(16);
            left -= bits;
            self.steps.push(CodingStep::plain(bits, number >> left & ((1 << bits) - 1)));
        }
        number
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_of_an_encoder_are_packed_as_described() {
        assert_eq!(CodingStep::symbol([0x123, 0x456]).0, 0x08ac_048d);
        assert_eq!(CodingStep::symbol([0x123, 0x456]).interval(), (0x123, 0x456, SYMBOL_SCALE));
        assert_eq!(CodingStep::bit([0xfff, 0x7fff]).interval(), (0xfff, 0x7fff, BIT_SCALE));
        assert_eq!(CodingStep::plain(16, 0xffff).interval(), (0xffff, 1, 16));
        assert_eq!(CodingStep::plain(1, 1).interval(), (1, 1, 1));
    }
}
