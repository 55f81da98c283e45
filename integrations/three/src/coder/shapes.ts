// Shapes as a list. Those of the common section come first, in the order in which they are stored, then those of a bundle.
// Counterpart of `crates/adumbra/src/coder/shapes.rs`.

import { LEAF_LEVEL } from '../quadtree/quadtree.js';
import { grown } from './growing.js';

/** Stands for a shape: all columns switch at the base. */
export const UNIFORM_CHILD = -1;
/** Stands for a shape: no column switches. */
export const NEVER_CHILD = -2;
/** Number of levels that shapes can have. */
export const LEVELS = 4;
/** Number of depths of a leaf's outline: those of row 7, then of column 7. */
export const OUTLINE = 16;
/** Numbers of a node: index and difference of the base of sixteen children. */
export const NODE = 32;

/** A list of shapes. Each comes after those that it leads to. */
export class Shapes {
  /** Number of shapes. */
  length = 0;
  /** Four times the number of a shape among the leaves or the nodes, plus its rank: (level − 3) / 2. */
  entries = new Int32Array(64);
  /** Half-words of all leaves. */
  halves = new Uint16Array(256);
  /** Where each leaf ends among them. */
  ends = new Int32Array(64);
  /** Outline of each leaf, relative to its base. */
  outlines = new Int32Array(64 * OUTLINE);
  /** Of each leaf: bits 2..0: class of row 7, bits 5..3: that of column 7, bits 8..6: kind, from bit 9 on: gradient. */
  facings = new Int32Array(64);
  /** Children of each node. */
  nodes = new Int32Array(64 * NODE);
  /** Indices of the shapes of each level, by rank. */
  readonly levels = Array.from({ length: LEVELS }, () => new Int32Array(64));
  /** Number of shapes of each level. */
  readonly counts = new Int32Array(LEVELS);
  #leaves = 0;
  #nodes = 0;

  /** Removes all shapes. */
  clear(): void {
    this.length = this.#leaves = this.#nodes = 0;
    this.counts.fill(0);
  }

  /** Returns where the half-words of a leaf begin. */
  beginOf(leaf: number): number {
    return leaf === 0 ? 0 : this.ends[leaf - 1];
  }

  /**
   * Makes room for one more leaf, and returns its number among the leaves. Its outline and half-words are to be filled
   * before {@link Shapes.pushLeaf}.
   */
  nextLeaf(): number {
    /** Largest number of half-words of a leaf. */
    const MOST_HALVES = 152;
    const leaf = this.#leaves;
    this.halves = grown(this.halves, this.beginOf(leaf) + MOST_HALVES);
    this.ends = grown(this.ends, leaf + 1);
    this.outlines = grown(this.outlines, OUTLINE * (leaf + 1));
    this.facings = grown(this.facings, leaf + 1);
    return leaf;
  }

  /** Adds the leaf that was filled, and returns its index. `before` is the number of shapes in lists before this one. */
  pushLeaf(before: number): number {
    return this.#push(0, this.#leaves++, before);
  }

  /** Adds a node with these children, and returns its index. `before` is the number of shapes in lists before this one. */
  pushNode(level: number, children: Int32Array, from: number, before: number): number {
    const node = this.#nodes++;
    this.nodes = grown(this.nodes, NODE * (node + 1));
    const { nodes } = this;
    for (let i = 0; i < NODE; i++) nodes[NODE * node + i] = children[from + i];
    return this.#push(rankOf(level), node, before);
  }

  #push(rank: number, number: number, before: number): number {
    this.entries = grown(this.entries, this.length + 1);
    this.entries[this.length] = LEVELS * number + rank;
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
