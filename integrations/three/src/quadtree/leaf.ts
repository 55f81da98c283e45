// The parts of a leaf. `spec/adumbra-file.md` has the bits.

import { digits, twoHalves } from './bits.js';

/** In place of an address: all columns switch at the base. */
export const UNIFORM = 0xffffffff;
/** Depth of a column that never switches. */
export const NEVER = 0xffffffff;

/**
 * Where the parts of a leaf are.
 *
 * `last`: the last rank, the number of depths minus 1. `differences`: how many depths are stored as differences, all but
 * the base and "never". `width`: differences take 8 << width bits each. `isSlanted`: whether a gradient follows the first
 * half-word. `differencesAt`, `planesAt`: half-words before the differences, and before the planes. `planes`: the number
 * of bit planes of the columns' ranks.
 */
export type LeafHead = readonly [
  last: number,
  differences: number,
  width: number,
  isSlanted: boolean,
  differencesAt: number,
  planesAt: number,
  planes: number,
];

/** Decodes a leaf's first half-word. */
export function leafHead(half: number): LeafHead {
  const last = half & 63;
  const differences = last - ((half >>> 6) & 1);
  const width = (half >>> 7) & 3;
  const isSlanted = ((half >>> 9) & 1) === 1;
  const differencesAt = isSlanted ? 2 : 1;
  const planesAt = differencesAt + (((differences << width) + 1) >>> 1);
  return [last, differences, width, isSlanted, differencesAt, planesAt, digits(last)];
}

/** Returns a difference of a leaf, whose differences begin at `first`. */
export function differenceAt(code: Uint16Array, first: number, width: number, index: number): number {
  if (width === 0) return (code[first + (index >>> 1)] >>> (8 * (index & 1))) & 0xff;
  return width === 1 ? code[first + index] : twoHalves(code, first + 2 * index);
}

/** Returns by how much a column switches nearer to the sun than the deepest corner of its plane, voxels. */
export function rise(gradient: number, x: number, y: number): number {
  const along = (g: number, c: number): number => Math.abs(g) * (g > 0 ? 7 - c : c);
  return (along(alongX(gradient), x) + along(alongY(gradient), y) + 3) >> 2;
}

/** Returns the largest rise of all columns, voxels. */
export function largestRise(gradient: number): number {
  return (7 * (Math.abs(alongX(gradient)) + Math.abs(alongY(gradient))) + 3) >> 2;
}

/** Returns the lower byte of a gradient, which has a sign. */
function alongX(gradient: number): number {
  return (gradient << 24) >> 24;
}

/** Returns the upper byte of a gradient, which has a sign. */
function alongY(gradient: number): number {
  return (gradient << 16) >> 24;
}
