// Depths along the border of the decoded blocks: the last row and the last column of the blocks above and to
// the left. Counterpart of `crates/adumbra/src/coder/edges.rs`.
//
// A *facing* describes the block above or to the left, as seen from a block of 8 × 8 columns. Bits 2..0: its
// class, bits 5..3: its kind, 0 if it is uniform, bits 21..6: its gradient, or 0.

import { rise } from '../quadtree/leaf.js';
import { BUNDLE_SIDE, PAGE_LEVEL } from '../quadtree/pages.js';
import { LEAF_LEVEL, NODE_LEVELS } from '../quadtree/quadtree.js';
import { NEVER } from './model.js';
import { FLAT, NEVER_CELL, NEVER_CLASS, OUTLINE, UNKNOWN, readOutline } from './outline.js';
import { UNIFORM_CHILD } from './shapes.js';
import type { Shapes } from './shapes.js';

/** Number of columns along each side of a bundle. */
const SIDE = BUNDLE_SIDE << PAGE_LEVEL;
/** The children of a node in its last row and its last column, one bit each. */
const LAST_CHILDREN = 0xf888;

/** Returns the class of a facing. */
export const classOfFacing = (facing: number): number => facing & 7;
/** Returns the kind of a facing: 1 for one depth, 2 for one and never, 3 for two, 4 for three or four, 5 for more. */
export const kindOfFacing = (facing: number): number => (facing >>> 3) & 7;
/** Returns the gradient of a facing. */
export const slantOfFacing = (facing: number): number => facing >>> 6;

/** The border of the decoded blocks. */
export class Edges {
  /** Depth of the last decoded column of each x. */
  readonly bottom = new Int32Array(SIDE);
  /** Depth of the last decoded column of each y. */
  readonly right = new Int32Array(SIDE);
  /** The last decoded block of each x. */
  readonly above = new Int32Array(SIDE >> LEAF_LEVEL);
  /** The last decoded block of each y. */
  readonly left = new Int32Array(SIDE >> LEAF_LEVEL);
  /** Index of the shape of each of these blocks, if it is a leaf. */
  readonly shapeAbove = new Int32Array(SIDE >> LEAF_LEVEL);
  readonly shapeLeft = new Int32Array(SIDE >> LEAF_LEVEL);
  /** The depths that {@link Edges.faceLeaf} found: those above, then those to the left. */
  readonly cells = new Int32Array(16);
  /** The outline of the leaf that is noted next, relative to its base. */
  readonly outline = new Int32Array(OUTLINE);

  /** Resets the border: nothing has been decoded. */
  clear(): void {
    this.bottom.fill(NEVER);
    this.right.fill(NEVER);
    for (const facings of [this.above, this.left]) facings.fill(UNKNOWN);
    for (const shapes of [this.shapeAbove, this.shapeLeft]) shapes.fill(UNIFORM_CHILD);
  }

  /** Forgets the neighbours of the first square of a level. */
  forget(level: number): void {
    this.#set(0, 0, level, NEVER, UNKNOWN);
  }

  #set(x: number, y: number, level: number, depth: number, facing: number): void {
    const side = 1 << level;
    for (let i = 0; i < side; i++) {
      this.bottom[x + i] = depth;
      this.right[y + i] = depth;
    }
    const blockX = x >> LEAF_LEVEL;
    const blockY = y >> LEAF_LEVEL;
    for (let i = 0; i < side >> LEAF_LEVEL; i++) {
      this.above[blockX + i] = facing;
      this.left[blockY + i] = facing;
      this.shapeAbove[blockX + i] = UNIFORM_CHILD;
      this.shapeLeft[blockY + i] = UNIFORM_CHILD;
    }
  }

  /** Notes a square that switches at one depth. */
  uniform(x: number, y: number, level: number, depth: number): void {
    this.#set(x, y, level, depth, depth === NEVER ? NEVER_CLASS : FLAT);
  }

  /** Notes the leaf that has the outline. `facing` is as in `Shapes`. */
  leaf(x: number, y: number, base: number, shape: number, facing: number): void {
    const { bottom, right, outline } = this;
    for (let i = 0; i < 8; i++) {
      const below = outline[i];
      const beside = outline[8 + i];
      bottom[x + i] = below === NEVER_CELL ? NEVER : base + below;
      right[y + i] = beside === NEVER_CELL ? NEVER : base + beside;
    }
    const rest = (facing >>> 6) << 3;
    this.above[x >> LEAF_LEVEL] = (facing & 7) | rest;
    this.left[y >> LEAF_LEVEL] = ((facing >>> 3) & 7) | rest;
    this.shapeAbove[x >> LEAF_LEVEL] = shape;
    this.shapeLeft[y >> LEAF_LEVEL] = shape;
  }

  /** Notes a shape that was decoded before. */
  shape(x: number, y: number, base: number, shape: number, lists: readonly [common: Shapes, own: Shapes]): void {
    const before = lists[0].length;
    const list = lists[shape < before ? 0 : 1];
    const entry = 3 * (shape < before ? shape : shape - before);
    const rank = list.entries[entry];
    let at = list.entries[entry + 1];
    const head = list.entries[entry + 2];
    if (rank === 0) {
      readOutline(list.halves, at, this.outline);
      this.leaf(x, y, base, shape, head);
      return;
    }
    const level = LEAF_LEVEL + NODE_LEVELS * (rank - 1);
    for (let c = 0; c < 16; c++) {
      let child = UNIFORM_CHILD;
      let depth = (head >>> (16 + c)) & 1 ? NEVER : base;
      if ((head >>> c) & 1) {
        child = list.children[at++];
        depth = (base + list.children[at++]) | 0;
      }
      if (!((LAST_CHILDREN >>> c) & 1)) continue;
      const childX = x + ((c & 3) << level);
      const childY = y + ((c >> 2) << level);
      if (child === UNIFORM_CHILD) this.uniform(childX, childY, level, depth);
      else this.shape(childX, childY, depth, child, lists);
    }
  }

  /**
   * Finds the depths of the columns above and to the left of a leaf, each increased by the rise of the leaf's
   * slant there.
   */
  faceLeaf(x: number, y: number, slant: number): void {
    const { bottom, right, cells } = this;
    for (let i = 0; i < 8; i++) {
      cells[i] = risen(bottom[x + i], slant, i, -1);
      cells[8 + i] = risen(right[y + i], slant, -1, i);
    }
  }
}

/** Returns a column's depth, increased by the rise of a slant there. "Never" stays as it is. */
export function risen(depth: number, slant: number, x: number, y: number): number {
  return depth === NEVER || slant === 0 ? depth : depth + rise(slant, x, y);
}
