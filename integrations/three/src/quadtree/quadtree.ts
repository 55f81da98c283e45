// The words of a file's voxels: a quadtree of the depths at which columns switch from lit to shadowed.

import type { Vec3 } from '../grid/vec3.js';

/** Level of the leaves, which span 8 × 8 columns. */
export const LEAF_LEVEL = 3;

/** A quadtree of switch depths, as the sections of a file hold it. */
export interface Quadtree {
  /** A root spans 2^rootLevel columns along each side. */
  readonly rootLevel: number;
  /** Number of roots along x, y, z. Only x and y count. */
  readonly topDims: Vec3;
  /** The section `top`: two words per root, an address and a base. */
  readonly top: Uint32Array;
  /** The section `nodes`: the code, two half-words per word. */
  readonly nodes: Uint32Array;
  /** The section `leaf_masks`: two words per wide entry, a difference and an address. */
  readonly leafMasks: Uint32Array;
}
