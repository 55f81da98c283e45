// The columns of a quadtree by blocks, as a march reads them. `spec/adumbra-file.md` has the fields.

import { halvesOf } from '../quadtree/bits.js';
import { NEVER, UNIFORM, depthOf, largestRise, leafHead, rankOf, rise } from '../quadtree/leaf.js';
import { childrenOf } from '../quadtree/node.js';
import { LEAF_LEVEL, NODE_LEVELS } from '../quadtree/quadtree.js';
import type { Quadtree } from '../quadtree/quadtree.js';

/** A block of columns. */
export interface Block {
  /** It spans 2^level columns a side. */
  level: number;
  /** Whether it is a leaf. Otherwise all of its columns switch at `nearest`. */
  isLeaf: boolean;
  /** No column switches nearer to the sun. */
  nearest: number;
  /** No column switches farther from it; {@link NEVER} if one may never switch. */
  farthest: number;
}

/** The columns of a quadtree. */
export interface Columns {
  /** Returns the block that contains a column of the grid. It is valid until the next call. */
  blockAt(x: number, y: number): Block;
  /** Returns the depth at which a column of the last block switches, if that is a leaf. */
  depthAt(x: number, y: number): number;
}

/** Returns the reader of a quadtree's columns. */
export function columnsOf({ top, code: words, rootLevel, topDims }: Quadtree): Columns {
  const code = halvesOf(words);
  const children = childrenOf(code);
  const block: Block = { level: 0, isLeaf: false, nearest: 0, farthest: 0 };
  let at = UNIFORM;
  let base = NEVER;

  let head = leafHead(0);

  /** Returns the depth of a rank of the leaf, without its slant. */
  const flatDepth = (rank: number): number => Math.min(base + depthOf(code, at, head, rank), NEVER);

  /** Sets the bounds of the leaf. */
  const setBounds = (): void => {
    head = leafHead(code[at]);
    const [last, differences, , isSlanted] = head;
    if (isSlanted) block.nearest = Math.max(base - largestRise(code[at + 1]), 0);
    block.farthest = differences < last ? NEVER : flatDepth(differences);
  };

  return {
    blockAt(x, y) {
      const root = 2 * ((y >>> rootLevel) * topDims[0] + (x >>> rootLevel));
      at = top[root];
      base = top[root + 1];
      let level = rootLevel;
      while (at !== UNIFORM && level > LEAF_LEVEL) {
        level -= NODE_LEVELS;
        const child = children(at, (((y >>> level) & 3) << 2) | ((x >>> level) & 3));
        at = child.at;
        base = child.isNever ? NEVER : (base + child.delta) >>> 0;
      }
      block.level = level;
      block.isLeaf = at !== UNIFORM;
      block.nearest = block.farthest = base;
      if (block.isLeaf) setBounds();
      return block;
    },
    depthAt(x, y) {
      const rank = rankOf(code, at, head, x & 7, y & 7);
      const [, differences, , isSlanted] = head;
      if (rank > differences) return NEVER;
      return isSlanted ? Math.max(flatDepth(rank) - rise(code[at + 1], x & 7, y & 7), 0) : flatDepth(rank);
    },
  };
}
