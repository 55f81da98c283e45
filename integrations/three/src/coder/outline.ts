// What neighbours see of a leaf. Counterpart of `crates/adumbra/src/coder/contour.rs`.

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

/** Returns a gradient's quarters of a voxel per column along x. */
export function gradientX(slant: number): number {
  return (slant << 24) >> 24;
}

/** Returns a gradient's quarters of a voxel per column along y. */
export function gradientY(slant: number): number {
  return (slant << 16) >> 24;
}

/** Returns by how much a plane is nearer to the sun than at its deepest corner, in a column that may be a neighbour's. */
export function riseAt(slant: number, x: number, y: number): number {
  const gx = gradientX(slant);
  const gy = gradientY(slant);
  return (3 - gx * (gx > 0 ? x - 7 : x) - gy * (gy > 0 ? y - 7 : y)) >> 2;
}
