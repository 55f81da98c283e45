// The parts of a leaf. `spec/adumbra-file.md` has the bits.

import { digits, twoHalves } from './bits.js';

/** In place of an address: all columns switch at the base. */
export const UNIFORM = 0xffffffff;
/** Depth of a column that never switches. */
export const NEVER = 0xffffffff;

/**
 * Where the parts of a leaf are.
 *
 * `last`: the last rank, the number of depths minus 1. `differences`: how many depths are stored as
 * differences, all but the base and "never". `width`: differences take 8 << width bits each. `isSlanted`:
 * whether a gradient follows the first half-word. `differencesAt`, `planesAt`: half-words before the
 * differences, and before the planes. `planes`: the number of bit planes of the columns' ranks.
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

/** Returns the rank of column (x, y), from 0 to 7 each, of the leaf at an address. */
export function rankOf(code: Uint16Array, at: number, head: LeafHead, x: number, y: number): number {
  const plane = at + head[5] + (y >>> 1);
  let rank = 0;
  for (let p = 0; p < head[6]; p++) rank |= ((code[plane + 4 * p] >>> (8 * (y & 1) + x)) & 1) << p;
  return rank;
}

/** Returns by how much the depth of a rank of the leaf at an address is beyond its base: the sum of that many differences. */
export function depthOf(code: Uint16Array, at: number, head: LeafHead, rank: number): number {
  const width = head[2];
  const first = at + head[4];
  let depth = 0;
  for (let i = 0; i < rank; i++) {
    if (width === 0) depth += (code[first + (i >>> 1)] >>> (8 * (i & 1))) & 0xff;
    else depth += width === 1 ? code[first + i] : twoHalves(code, first + 2 * i);
  }
  return depth;
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
