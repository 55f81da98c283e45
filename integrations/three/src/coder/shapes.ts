// Shapes as a list. Those of the common section come first, in the order in which they are stored, then those
// of a bundle. Counterpart of `crates/adumbra/src/layout/depths/shapes.rs`.

import { LEAF_LEVEL } from '../quadtree/quadtree.js';
import { grown } from './growing.js';

/** Stands for a shape: all columns switch at the base. */
export const UNIFORM_CHILD = -1;
/** Stands for a shape: no column switches. */
export const NEVER_CHILD = -2;
/** Number of levels that shapes can have. */
export const LEVELS = 4;
/** Numbers of a node that is being decoded: index and difference of the base of sixteen children. */
export const NODE = 32;

/**
 * A list of shapes. Each comes after its children. Memory is proportional to the half-words of the shapes,
 * because a child is listed only if it takes at least one half-word.
 */
export class Shapes {
  /** Number of shapes. */
  length = 0;
  /**
   * Three numbers for each shape. The rank: (level − 3) / 2. The index at which a leaf's half-words, or a
   * node's listed children, begin. The head:
   *
   * - of a leaf, bits 2..0: class of row 7, bits 5..3: that of column 7, bits 8..6: kind, from bit 9 on:
   *   gradient;
   * - of a node, bits 15..0: the children that are listed, bits 31..16: those that never switch. The others
   *   switch at the base.
   */
  entries = new Int32Array(3 * 64);
  /** Half-words of all leaves. */
  halves = new Uint16Array(256);
  /** Number of these half-words. */
  halvesLength = 0;
  /** Listed children of all nodes: index and difference of the base. */
  children = new Int32Array(256);
  /** Indices of the shapes of each level, by rank. */
  readonly levels = Array.from({ length: LEVELS }, () => new Int32Array(64));
  /** Number of shapes of each level. */
  readonly counts = new Int32Array(LEVELS);
  #childrenLength = 0;

  /** Removes all shapes. */
  clear(): void {
    this.length = this.halvesLength = this.#childrenLength = 0;
    this.counts.fill(0);
  }

  /**
   * Makes room for the half-words of one more leaf. Append them to the others before {@link Shapes.pushLeaf}.
   */
  reserveLeaf(): void {
    /** Largest number of half-words of a leaf. */
    const MOST_HALVES = 152;
    this.halves = grown(this.halves, this.halvesLength + MOST_HALVES);
  }

  /** Adds a leaf whose half-words end at `end`, and returns its index. `before` is the number of shapes in lists before this one. */
  pushLeaf(end: number, facing: number, before: number): number {
    const first = this.halvesLength;
    this.halvesLength = end;
    return this.#push(0, first, facing, before);
  }

  /** Adds a node with these children, and returns its index. `before` is the number of shapes in lists before this one. */
  pushNode(level: number, children: Int32Array, from: number, before: number): number {
    const first = this.#childrenLength;
    this.children = grown(this.children, first + NODE);
    let at = first;
    let head = 0;
    for (let c = 0; c < 16; c++) {
      const shape = children[from++];
      const delta = children[from++];
      if (shape === NEVER_CHILD) head |= 1 << (16 + c);
      else if (shape !== UNIFORM_CHILD || delta !== 0) {
        head |= 1 << c;
        this.children[at++] = shape;
        this.children[at++] = delta;
      }
    }
    this.#childrenLength = at;
    return this.#push(rankOf(level), first, head, before);
  }

  #push(rank: number, first: number, head: number, before: number): number {
    const at = 3 * this.length;
    this.entries = grown(this.entries, at + 3);
    this.entries.set([rank, first, head], at);
    const index = before + this.length++;
    const count = this.counts[rank]++;
    const list = (this.levels[rank] = grown(this.levels[rank], count + 1));
    list[count] = index;
    return index;
  }
}

/** Returns the rank of a level: (level − 3) / 2. */
export function rankOf(level: number): number {
  return (level - LEAF_LEVEL) >> 1;
}
