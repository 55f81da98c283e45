// The words of a level's voxels: a quadtree of the depths at which columns switch from lit to shadowed.

import type { Dims } from './pages.js';

/** Level of the leaves, which span 8 × 8 columns. */
export const LEAF_LEVEL = 3;
/** Number of levels from a node to its children. */
export const NODE_LEVELS = 2;

/** A quadtree of switch depths, as look-ups read it. */
export interface Quadtree {
  /** The blocks at which look-ups begin span 2^rootLevel columns along each side; 5, 7 or 9. */
  readonly rootLevel: number;
  /** Number of these blocks along x and y. */
  readonly topDims: Dims;
  /** Two words per block, x fastest: the address of its node in the code, or 0xFFFFFFFF, and its base. */
  readonly top: Uint32Array;
  /** The code, two half-words per word: the common section, then the pages. */
  readonly code: Uint32Array;
}
