// Range asymmetric numeral systems with two states that take turns, and adaptive probabilities. Counterpart
// of `crates/adumbra/src/coder/rans.rs`, which has the sources.
//
// A state has 32 bits. Its lowest bits select a symbol by the interval that they are in. The state then
// becomes frequency · (state >> scale) + low bits − start of the interval. If it is below 2^16, the next
// half-word is appended.

/** Logarithm of the sum of a bit's two frequencies, and mask of a number below that sum. */
const BIT_SCALE = 12;
const BIT_MASK = 2 ** BIT_SCALE - 1;
/** The same for symbols. */
const SYMBOL_SCALE = 15;
const SYMBOL_MASK = 2 ** SYMBOL_SCALE - 1;
/** Shift by which the probability of a bit moves towards the bit that was read. */
const BIT_SHIFT = 4;
/**
 * Largest ratio of the bytes of a part's shapes to its coded bytes. If a part would exceed it, zeros are
 * appended to the coded bytes.
 */
export const LARGEST_RATIO = 16;
/** Both states are this at the end. */
const LAST_STATE = 2 ** 16;
/** 2^15 in both halves of a word. */
const HALVES = 0x80008000;

/**
 * Shifts by which intervals move towards the symbol that was read, by the number of earlier symbols, which
 * counts up to 31.
 */
const SHIFTS = /* @__PURE__ */ Uint8Array.from({ length: 32 }, (_, count) => (count < 2 ? 2 : count < 6 ? 3 : count < 31 ? 4 : 5));

/**
 * The starts that are approached if only one symbol is read: 8 words for each such symbol. Each start has an
 * offset of 2^15.
 */
const TARGETS = /* @__PURE__ */ makeTargets();

function makeTargets(): Int32Array {
  /** The frequency that symbols 0 to 14 approach if they are not read. */
  const LEAST_FREQUENCY = 48;
  const targets = Uint16Array.from({ length: 256 }, (_, at) => {
    const beyond = at % 16 > at >> 4 ? SYMBOL_MASK - 15 * LEAST_FREQUENCY : 0;
    return 2 ** 15 + LEAST_FREQUENCY * (at % 16) + beyond;
  });
  return new Int32Array(targets.buffer);
}

/**
 * Reads bits and symbols. A number, the model, selects the probabilities of each. Past the end of the
 * half-words it reads zeros.
 */
export class RansReader {
  /** Probability that a bit is 1, in 65536ths. */
  readonly #bits: Uint16Array;
  /** Where the interval of each of sixteen symbols begins, two in a word. */
  readonly #starts: Int32Array;
  /** The same starts as half-words. */
  readonly #start: Uint16Array;
  /** Number of symbols that were read, at most 31. */
  readonly #counts: Uint8Array;
  /** The state of the next step, and the other. */
  readonly #states = new Int32Array(2);
  #halves = new Uint16Array(0);
  #at = 0;

  /** Creates a reader for `bits` models of bits and `symbols` models of symbols. */
  constructor(bits: number, symbols: number) {
    this.#bits = new Uint16Array(bits);
    // One more, since the end of an interval is the start of the next one.
    this.#starts = new Int32Array(8 * (symbols + 1));
    this.#start = new Uint16Array(this.#starts.buffer);
    this.#counts = new Uint8Array(symbols);
  }

  /** Begins to read half-words. All values are equally likely again. */
  begin(halves: Uint16Array<ArrayBuffer>): void {
    this.#bits.fill(2 ** 15);
    this.#counts.fill(0);
    for (let symbol = 0; symbol < 16; symbol++) this.#start[symbol] = symbol << (SYMBOL_SCALE - 4);
    for (let done = 8; done < this.#starts.length; done *= 2) this.#starts.copyWithin(done, 0, done);
    this.#halves = halves;
    // Missing half-words count as 0.
    this.#states[0] = halves[0] | (halves[1] << 16);
    this.#states[1] = halves[2] | (halves[3] << 16);
    this.#at = 4;
  }

  /** Whether more half-words were read than there are. */
  get isPastEnd(): boolean {
    return this.#at > this.#halves.length;
  }

  /**
   * Whether everything has been read, except for zeros that were appended because the shapes have `words`
   * words.
   */
  isAtEnd(words: number): boolean {
    const halves = this.#halves;
    return (
      halves.length === Math.max(this.#at, Math.ceil(words / (LARGEST_RATIO / 2))) &&
      !halves.subarray(this.#at).some(Boolean) &&
      this.#states.every((state) => state === LAST_STATE)
    );
  }

  /**
   * Sets the state at the end of a step. It has no branches on the state, which would often be mispredicted.
   */
  #advance(state: number): void {
    const at = this.#at;
    const half = at < this.#halves.length ? this.#halves[at] : 0;
    /** 1 if the state is below 2^16. */
    const isSmall = ((state >>> 16) - 1) >>> 31;
    this.#at = at + isSmall;
    this.#states[0] = this.#states[1];
    this.#states[1] = (state << (isSmall << 4)) | (half & -isSmall);
  }

  /** Reads a bit. */
  bit(model: number): number {
    const state = this.#states[0];
    const probability = this.#bits[model];
    const ones = (probability >>> (16 - BIT_SCALE)) | 1;
    const value = state & BIT_MASK;
    /** 1 or 0, and as a mask. */
    const bit = (value - ones) >>> 31;
    const isOne = -bit;
    this.#bits[model] = probability + (((isOne & 0xffff) - probability) >> BIT_SHIFT);
    const frequency = (ones & isOne) | ((BIT_MASK + 1 - ones) & ~isOne);
    this.#advance((Math.imul(frequency, state >>> BIT_SCALE) + value - (ones & ~isOne)) | 0);
    return bit;
  }

  /** Reads a symbol below 16. */
  symbol(model: number): number {
    const start = this.#start;
    const state = this.#states[0];
    const value = state & SYMBOL_MASK;
    // A shift by 31 gives −1 for each start above the value. The first is never above it.
    let at = 16 * model + 12;
    at += 4 * (((value - start[at - 8]) >> 31) + ((value - start[at - 4]) >> 31) + ((value - start[at]) >> 31));
    at += 3 + ((value - start[at + 1]) >> 31) + ((value - start[at + 2]) >> 31) + ((value - start[at + 3]) >> 31);
    const symbol = at & 15;
    const from = start[at];
    // Where the last interval ends there is the 0 of the next model, which stands for 2^15.
    const frequency = ((start[at + 1] - 1) & SYMBOL_MASK) + 1 - from;
    this.#adapt(model, symbol);
    this.#advance((Math.imul(frequency, state >>> SYMBOL_SCALE) + value - from) | 0);
    return symbol;
  }

  /** Moves each start towards its target by (target − start) >> shift, rounded down, two at a time. */
  #adapt(model: number, symbol: number): void {
    const starts = this.#starts;
    const count = this.#counts[model];
    this.#counts[model] = count + ((count - 31) >>> 31);
    const shift = SHIFTS[count];
    // Differences have an offset of 2^15, so that none is negative. After the shift, the offset is `least`.
    const mask = (0xffff >>> shift) * 0x10001;
    const least = (HALVES >>> shift) & mask;
    const first = 8 * model;
    const target = 8 * symbol;
    // Unrolled, because most of the time is spent here.
    const a = starts[first];
    const b = starts[first + 1];
    const c = starts[first + 2];
    const d = starts[first + 3];
    const e = starts[first + 4];
    const f = starts[first + 5];
    const g = starts[first + 6];
    const h = starts[first + 7];
    starts[first] = a + (((TARGETS[target] - a) >>> shift) & mask) - least;
    starts[first + 1] = b + (((TARGETS[target + 1] - b) >>> shift) & mask) - least;
    starts[first + 2] = c + (((TARGETS[target + 2] - c) >>> shift) & mask) - least;
    starts[first + 3] = d + (((TARGETS[target + 3] - d) >>> shift) & mask) - least;
    starts[first + 4] = e + (((TARGETS[target + 4] - e) >>> shift) & mask) - least;
    starts[first + 5] = f + (((TARGETS[target + 5] - f) >>> shift) & mask) - least;
    starts[first + 6] = g + (((TARGETS[target + 6] - g) >>> shift) & mask) - least;
    starts[first + 7] = h + (((TARGETS[target + 7] - h) >>> shift) & mask) - least;
  }

  /** Reads a number of `count` bits, all of which are equally likely. It is returned with a sign. */
  plain(count: number): number {
    let number = 0;
    for (let left = count; left > 0; left -= 16) {
      const bits = left < 16 ? left : 16;
      const state = this.#states[0];
      number = (number << bits) | (state & ((1 << bits) - 1));
      this.#advance(state >>> bits);
    }
    return number;
  }
}
