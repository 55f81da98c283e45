// Look-ups of voxels in the quadtree. `spec/adumbra-file.md`, "Look-up of a point", has the steps and their
// names.

import { halvesOf } from './bits.js';
import { NEVER, UNIFORM, depthOf, leafHead, rankOf, rise } from './leaf.js';
import { childrenOf, descend } from './node.js';
import { LEAF_LEVEL } from './quadtree.js';
import type { Quadtree } from './quadtree.js';

/**
 * Returns whether voxel (x, y, z), which must be in the grid, is lit. It remembers the block of its last
 * look-up, so that look-ups close to each other cost less.
 */
export type Voxels = (x: number, y: number, z: number) => boolean;

/** Returns the look-up of voxels in a quadtree. */
export function voxelsOf({ top, code: words, rootLevel, topDims }: Quadtree): Voxels {
  const code = halvesOf(words);
  const children = childrenOf(code);
  let lastX = -1;
  let lastY = -1;
  /** Address of the last leaf, or {@link UNIFORM}. */
  let at = UNIFORM;
  let base = NEVER;
  let head = leafHead(0);

  /** Descends to the block or leaf that contains a column. */
  const findBlock = (x: number, y: number): void => {
    const root = 2 * ((y >>> rootLevel) * topDims[0] + (x >>> rootLevel));
    [at, base] = descend(children, [top[root], top[root + 1]], rootLevel, LEAF_LEVEL, x, y);
    if (at !== UNIFORM) head = leafHead(code[at]);
  };

  /** Returns the depth at which a column of the leaf switches; `x` and `y` are 0 to 7. */
  const depthAt = (x: number, y: number): number => {
    const [, differences, , isSlanted] = head;
    const rank = rankOf(code, at, head, x, y);
    if (rank > differences) return NEVER;
    const depth = Math.min(base + depthOf(code, at, head, rank), NEVER);
    return isSlanted ? Math.max(depth - rise(code[at + 1], x, y), 0) : depth;
  };

  return (x, y, z) => {
    const blockX = x >>> 3;
    const blockY = y >>> 3;
    if (blockX !== lastX || blockY !== lastY) {
      lastX = blockX;
      lastY = blockY;
      findBlock(x, y);
    }
    return z < (at === UNIFORM ? base : depthAt(x & 7, y & 7));
  };
}
