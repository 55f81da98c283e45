// The rank of each column of a leaf. Counterpart of `crates/adumbra/src/coder/columns.rs`.

import { lowestBit } from '../quadtree/bits.js';
import { LEAF_LEVEL } from '../quadtree/quadtree.js';
import { classOfFacing } from './edges.js';
import type { Edges } from './edges.js';
import { NEVER, ROW, ROWS_OF_KIND, STILL, VALUE, VALUES_OF_KIND } from './model.js';
import type { ModelReader } from './model.js';
import { UNKNOWN } from './outline.js';

/** A leaf as numbers. */
export class Leaf {
  /** The last rank: the number of depths minus 1. */
  last = 0;
  /** Whether the last depth is never. */
  never = false;
  /** The gradient, or 0. */
  slant = 0;
  /** Differences of the depths, without the difference to never. */
  readonly differences = new Int32Array(64);
  /**
   * Ranks of the row above the leaf, then of the leaf's columns. `rows` has the same ranks as words, two per
   * row.
   */
  readonly ranks = new Uint8Array(72);
  readonly rows = new Int32Array(this.ranks.buffer);
  /** Ranks of the column to the left. */
  readonly west = new Uint8Array(8);

  /** Number of differences. */
  get stored(): number {
    return this.last - (this.never ? 1 : 0);
  }
}

/** Reads the ranks of a leaf's columns. The leaf's cells must have been found. */
export function readColumns(reader: ModelReader, edges: Edges, x: number, y: number, base: number, leaf: Leaf): void {
  const { last, ranks, west } = leaf;
  if (last === 0) {
    ranks.fill(0);
    return;
  }
  const isSure = faceColumns(edges.cells, base, leaf);
  const isAboveKnown = classOfFacing(edges.above[x >> LEAF_LEVEL]) !== UNKNOWN;
  const isLeftKnown = classOfFacing(edges.left[y >> LEAF_LEVEL]) !== UNKNOWN;
  if (!isAboveKnown) ranks.fill(isLeftKnown ? west[0] : ranks[0], 0, 8);
  else if (!isLeftKnown) west.fill(ranks[0]);
  readRows(reader, leaf, isAboveKnown ? isSure : 0);
}

/**
 * Finds the ranks whose depths are nearest to those above and to the left. Returns which columns above are
 * within 2, one bit each.
 */
function faceColumns(cells: Int32Array, base: number, leaf: Leaf): number {
  const { last, never, stored, differences, ranks, west } = leaf;
  let sure = 0;
  for (let i = 0; i < 16; i++) {
    let rank = last;
    let isSure = never;
    if (cells[i] !== NEVER) {
      const ahead = (cells[i] - base) | 0;
      let off = ahead;
      let depth = 0;
      rank = 0;
      for (let d = 0; d < stored; d++) {
        const middle = (depth + (differences[d] >>> 1)) | 0;
        depth = (depth + differences[d]) | 0;
        if (ahead > middle) {
          rank++;
          off = ahead - depth;
        }
      }
      isSure = (off + 2) >>> 0 <= 4;
    }
    if (i < 8) {
      ranks[i] = rank;
      if (isSure) sure |= 1 << i;
    } else west[i - 8] = rank;
  }
  return sure;
}

/**
 * Reads rows of ranks, each as its changes from the row above.
 *
 * A row below a flat row begins with a bit: whether the two rows are equal. Otherwise, a symbol for each half
 * of a row says which of its four columns changed. If a changed column may have several ranks, another symbol
 * gives its new rank.
 */
function readRows(reader: ModelReader, { last, ranks, rows, west: column }: Leaf, sure: number): void {
  const kind = (last > 1 ? 1 : 0) + (last > 4 ? 1 : 0);
  const row = ROW + ROWS_OF_KIND * kind;
  const still = STILL + 16 * kind;
  const value = VALUE + VALUES_OF_KIND * (Math.min(Math.max(last, 2) - 2, 2) + (last > 7 ? 1 : 0));
  let corner = ranks[0];
  let changedAbove = 0;
  for (let y = 0; y < 8; y++) {
    const west = column[y];
    const low = rows[2 * y];
    const high = rows[2 * y + 1];
    // Bit x: columns x − 1 and x of the row above differ.
    const steps = differing(low, (low << 8) | corner) | (differing(high, (high << 8) | (low >>> 24)) << 4);
    const isFlat = steps === 0 && west === corner;
    let changed = 0;
    rows[2 * y + 2] = low;
    rows[2 * y + 3] = high;
    if (!isFlat || reader.bit(still + 2 * y + (changedAbove !== 0 ? 1 : 0)) === 0) {
      let before = west;
      for (let half = 0; half < 2; half++) {
        const first = 4 * half;
        const above = 8 * y + first;
        let history = (changedAbove >>> first) & 15;
        // Below a flat row, from which this one differs.
        if (isFlat && changed === 0) history = 18 + half;
        else if (y === 0) history = 16 + Number(((sure >>> first) & 15) === 15);
        const same = (before === ranks[above] ? 1 : 0);
        const columns = reader.symbol(row + ((steps >>> first) & 15) + 16 * same + 32 * history);
        changed |= columns << first;
        if (last === 1) rows[2 * y + 2 + half] ^= (columns * 0x00204081) & 0x01010101;
        else if (columns !== 0) readRanks(reader, ranks, above, columns, west, last, value);
        before = ranks[above + 11];
      }
    }
    changedAbove = changed;
    corner = west;
  }
}

/**
 * Reads the ranks of the columns that changed among four. In the row above, the four columns begin at
 * `above`.
 */
function readRanks(reader: ModelReader, ranks: Uint8Array, above: number, columns: number, west: number, last: number, value: number): void {
  for (let left = columns; left !== 0; left &= left - 1) {
    const at = above + lowestBit(left);
    let rank;
    if (last < 16) {
      const n = ranks[at];
      const w = (at & 7) === 0 ? west : ranks[at + 7];
      const ne = (at & 7) === 7 ? n : ranks[at + 1];
      const about = ne === w ? 0 : ne === n ? 16 : 32;
      rank = (n + reader.symbol(value + ((w - n) & 15) + about)) & 15;
    } else rank = reader.plain(6);
    ranks[at + 8] = rank < last ? rank : last;
  }
}

/** Returns which of four bytes differ. No byte is above 127. */
function differing(a: number, b: number): number {
  return Math.imul((((a ^ b) + 0x7f7f7f7f) >>> 7) & 0x01010101, 0x01020408) >>> 24;
}
