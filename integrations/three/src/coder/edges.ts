// Depths along the border of what was decoded: the last row and the last column of the blocks above and to the left.
// Counterpart of `crates/adumbra/src/coder/edges.rs`.
//
// What a block of 8 × 8 columns sees of the one above it or to its left is a *facing*: bits 2..0: its class, bits 5..3: its
// kind, 0 where it is uniform, bits 21..6: its gradient, or 0.

import { BUNDLE_SIDE, PAGE_LEVEL } from '../quadtree/pages.js';
import { LEAF_LEVEL, NODE_LEVELS } from '../quadtree/quadtree.js';
import { NEVER } from './model.js';
import { FLAT, NEVER_CELL, NEVER_CLASS, UNKNOWN, gradientX, gradientY } from './outline.js';
import { LEVELS, NEVER_CHILD, NODE, OUTLINE, UNIFORM_CHILD } from './shapes.js';
import type { Shapes } from './shapes.js';

/** Number of columns along each side of a bundle. */
const SIDE = BUNDLE_SIDE << PAGE_LEVEL;
/** The children of a node in its last row and its last column. */
const LAST_CHILDREN = [3, 7, 11, 12, 13, 14, 15];

/** Returns the class of a facing. */
export const classOfFacing = (facing: number): number => facing & 7;
/** Returns the kind of a facing: 1 for one depth, 2 for one and never, 3 for two, 4 for three or four, 5 for more. */
export const kindOfFacing = (facing: number): number => (facing >>> 3) & 7;
/** Returns the gradient of a facing. */
export const slantOfFacing = (facing: number): number => facing >>> 6;

/** The border of what was decoded. */
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

  /** Begins where nothing was decoded. */
  clear(): void {
    this.bottom.fill(NEVER);
    this.right.fill(NEVER);
    for (const facings of [this.above, this.left]) facings.fill(UNKNOWN);
    for (const shapes of [this.shapeAbove, this.shapeLeft]) shapes.fill(UNIFORM_CHILD);
  }

  /** Forgets what is next to the first square of a level. */
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

  /** Notes a leaf. `facing` is as in `Shapes`, and its outline begins at `from`. */
  leaf(x: number, y: number, base: number, shape: number, facing: number, outlines: Int32Array, from: number): void {
    const { bottom, right } = this;
    for (let i = 0; i < 8; i++) {
      const below = outlines[from + i];
      const beside = outlines[from + 8 + i];
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
    const entry = list.entries[shape < before ? shape : shape - before];
    const rank = entry & (LEVELS - 1);
    const number = entry >> 2;
    if (rank === 0) {
      this.leaf(x, y, base, shape, list.facings[number], list.outlines, OUTLINE * number);
      return;
    }
    const level = LEAF_LEVEL + NODE_LEVELS * (rank - 1);
    for (const c of LAST_CHILDREN) {
      const childX = x + ((c & 3) << level);
      const childY = y + ((c >> 2) << level);
      const child = list.nodes[NODE * number + 2 * c];
      const depth = (base + list.nodes[NODE * number + 2 * c + 1]) | 0;
      if (child === NEVER_CHILD) this.uniform(childX, childY, level, NEVER);
      else if (child === UNIFORM_CHILD) this.uniform(childX, childY, level, depth);
      else this.shape(childX, childY, depth, child, lists);
    }
  }

  /**
   * Finds the depths of the columns above and to the left of a leaf, deeper by what the leaf's slant would rise there.
   * "Never" stays as it is.
   */
  faceLeaf(x: number, y: number, slant: number): void {
    const { bottom, right, cells } = this;
    for (let i = 0; i < 8; i++) {
      cells[i] = bottom[x + i];
      cells[8 + i] = right[y + i];
    }
    if (slant === 0) return;
    const gx = gradientX(slant);
    const gy = gradientY(slant);
    // Quarters of the rise at (0, −1) and (−1, 0), with 3 more to round up.
    let along = 3 + (gx > 0 ? 7 * gx : 0) + (gy > 0 ? 8 * gy : gy);
    let down = 3 + (gx > 0 ? 8 * gx : gx) + (gy > 0 ? 7 * gy : 0);
    for (let i = 0; i < 8; i++) {
      if (cells[i] !== NEVER) cells[i] += along >> 2;
      if (cells[8 + i] !== NEVER) cells[8 + i] += down >> 2;
      along -= gx;
      down -= gy;
    }
  }
}
