// The outline of a leaf, which its neighbours see. Counterpart of `crates/adumbra/src/coder/contour.rs`.

import { depthOf, leafHead, rankOf, rise } from '../quadtree/leaf.js';

/** Number of depths of a leaf's outline: those of row 7, then of column 7. */
export const OUTLINE = 16;
/** Stands for "never" among depths that are relative to a base. */
export const NEVER_CELL = -(2 ** 31);

/** Classes of an edge of eight columns that faces a block: nothing is known, … */
export const UNKNOWN = 0;
/** … no column switches, … */
export const NEVER_CLASS = 1;
/** … all switch at one depth, … */
export const FLAT = 2;
/** … all switch, at depths that differ by up to 16, … */
export const SMOOTH = 3;
/** … or anything else. */
export const MIXED = 4;

/** Returns the class of eight depths that are relative to a base. */
export function classOf(cells: Int32Array, from: number): number {
  let never = 0;
  let least = cells[from];
  let most = least;
  for (let i = from; i < from + 8; i++) {
    const cell = cells[i];
    if (cell === NEVER_CELL) never++;
    if (cell < least) least = cell;
    if (cell > most) most = cell;
  }
  if (never > 0) return never === 8 ? NEVER_CLASS : MIXED;
  if (least === most) return FLAT;
  return (most - least) >>> 0 <= 16 ? SMOOTH : MIXED;
}

/** Finds the outline of the valid leaf whose half-words begin at `from`, relative to its base. */
export function readOutline(halves: Uint16Array, from: number, outline: Int32Array): void {
  const head = leafHead(halves[from]);
  const [, differences, , isSlanted] = head;
  const cell = (x: number, y: number): number => {
    const rank = rankOf(halves, from, head, x, y);
    return rank > differences ? NEVER_CELL : depthOf(halves, from, head, rank) - (isSlanted ? rise(halves[from + 1], x, y) : 0);
  };
  for (let i = 0; i < 8; i++) {
    outline[i] = cell(i, 7);
    outline[8 + i] = cell(7, i);
  }
}
