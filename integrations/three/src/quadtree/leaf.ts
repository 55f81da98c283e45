// The first half-word of a leaf, which says where its parts are. `spec/adumbra-file.md` has the bits.

import { digits } from './bits.js';

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
