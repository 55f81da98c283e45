// The first half-word of a leaf of the layout depths, which says where its parts are. `spec/adumbra-file.md`, "The
// layout depths", has the bits. Counterpart of `LeafHead` in `crates/adumbra/src/layout/depths/code.rs`.

import { digits } from './bits.js';

/** In place of an address: all columns switch at the base. */
export const UNIFORM = 0xffffffff;
/** Depth of a column that never switches. */
export const NEVER = 0xffffffff;

/** Where the parts of a leaf are. */
export interface LeafHead {
  /** The last rank: the number of depths minus 1. */
  readonly last: number;
  /** Number of depths that are stored as differences: all but the base and "never". */
  readonly differences: number;
  /** Differences take 8 << width bits each. */
  readonly width: number;
  /** Whether a gradient follows the first half-word. */
  readonly isSlanted: boolean;
  /** Half-words before the differences. */
  readonly differencesAt: number;
  /** Half-words before the planes. */
  readonly planesAt: number;
  /** Number of bit planes of the columns' ranks. */
  readonly planes: number;
}

/** Decodes a leaf's first half-word. */
export function leafHead(half: number): LeafHead {
  const last = half & 63;
  const differences = last - ((half >>> 6) & 1);
  const width = (half >>> 7) & 3;
  const isSlanted = ((half >>> 9) & 1) === 1;
  const differencesAt = isSlanted ? 2 : 1;
  const planesAt = differencesAt + (((differences << width) + 1) >>> 1);
  return { last, differences, width, isSlanted, differencesAt, planesAt, planes: digits(last) };
}
