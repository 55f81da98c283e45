// The numbers of all probabilities, and the codes of numbers and depths. Counterpart of
// `crates/adumbra/src/coder/model.rs`, which says what each probability depends on.

import { RansReader } from './rans.js';

/** Depth of a column that never switches, as a number with a sign. */
export const NEVER = -1;

// Numbers.
export const COUNT = 0;
export const INDEX = 1;
export const GRADIENT = INDEX + 4 * 2;
export const DIFFERENCE = GRADIENT + 2;
const NUMBERS = DIFFERENCE + 24;

// Depths.
export const UNIFORM_DEPTH = 0;
export const NODE_DEPTH = 4;
export const LEAF_DEPTH = 8;
const DEPTHS = 12;

// Symbols. First are the lengths of numbers and the ways of depths.
const WAYS = NUMBERS;
const WAYS_OF_ONE = 64;
export const LEVEL = WAYS + WAYS_OF_ONE * DEPTHS;
export const STATE = LEVEL + 1;
export const REFERENCE = STATE + 4 * 4 * 25;
export const HEAD = REFERENCE + 4;
export const LAST = HEAD + 36;
export const SLANT = LAST + 2;
export const ROW = SLANT + 3;
export const ROWS_OF_KIND = 640;
export const VALUE = ROW + 3 * ROWS_OF_KIND;
export const VALUES_OF_KIND = 48;
const SYMBOLS = VALUE + 4 * VALUES_OF_KIND;

// Bits. First are those of numbers and depths.
const BITS_OF_NUMBER = 52;
const SECOND = 0;
const THIRD = 16;
const SIGN = 48;
const BITS_OF_DEPTH = 32;
const DEPTH_SIGN = BITS_OF_NUMBER * NUMBERS;
const DEPTH_SECOND = DEPTH_SIGN + 16;
export const LAST_IS_NEVER = DEPTH_SIGN + BITS_OF_DEPTH * DEPTHS;
export const IS_SLANTED = LAST_IS_NEVER + 2;
export const HIT = IS_SLANTED + 4;
export const STILL = HIT + 24 * 8;
const BITS = STILL + 3 * 8 * 2;

/** Reads numbers and depths in addition to bits and symbols. Numbers of 32 bits are returned with a sign. */
export class ModelReader extends RansReader {
  /** The depths that {@link ModelReader.depth} may give. The last is the base of the parent. */
  readonly known = new Int32Array(6);

  constructor() {
    super(BITS, SYMBOLS);
  }

  /** Reads a number: its length in bits, its second and third highest bit, and the remaining bits. */
  number(model: number): number {
    const length = this.symbol(model);
    if (length < 2) return length;
    let left = length - 2;
    if (length === 15) left += Math.min(this.plain(5), 17);
    const bits = BITS_OF_NUMBER * model;
    let value = 2 | this.bit(bits + SECOND + length);
    if (left > 0) {
      left -= 1;
      value = (value << 1) | this.bit(bits + THIRD + 2 * length + (value & 1));
      value = (value << left) | this.plain(left);
    }
    return value;
  }

  /** Reads a number that may be negative: its size, then its sign. */
  signed(model: number): number {
    const size = this.number(model);
    if (size === 0) return 0;
    const place = size < 0 || size > 4 ? 3 : size - 1;
    return this.bit(BITS_OF_NUMBER * model + SIGN + place) === 1 ? -size | 0 : size;
  }

  /** Reads a depth: one of those that are {@link ModelReader.known}, or its distance from the first. */
  depth(model: number): number {
    const { known } = this;
    const a = known[0];
    const b = known[1];
    const base = known[5];
    const context =
      (a === b ? 1 : 0) |
      ((a === known[2] ? 1 : 0) << 1) |
      ((b === known[3] ? 1 : 0) << 2) |
      ((a === base ? 1 : 0) << 3) |
      ((a === NEVER ? 1 : 0) << 4) |
      ((b === NEVER ? 1 : 0) << 5);
    const way = this.symbol(WAYS + WAYS_OF_ONE * model + context);
    if (way < 6) return known[way];
    // A distance of 1 to 9 bits, or of 10 and more.
    const length = way - 5;
    const bits = BITS_OF_DEPTH * model + length;
    const isLess = this.bit(DEPTH_SIGN + bits) === 1;
    let left = length - 1;
    if (length === 10) left += Math.min(this.plain(5), 22);
    let distance = 1;
    if (left > 0) {
      left -= 1;
      distance = 2 | this.bit(DEPTH_SECOND + bits);
      distance = (distance << left) | this.plain(left);
    }
    const origin = a !== NEVER ? a : b !== NEVER ? b : base;
    return (isLess ? origin - distance : origin + distance) | 0;
  }
}
