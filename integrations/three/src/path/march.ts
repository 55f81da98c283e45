// The march: follows the ray to another sun through the depths of one sun's file. `spec/sun-path.md`,
// "Look-ups", has the rules. Counterpart of `crates/adumbra/src/query/march.rs`, with the same answer for
// every start.

import { FIXED_ONE } from '../grid/fixed.js';
import type { Vec3 } from '../grid/vec3.js';
import { NEVER } from '../quadtree/leaf.js';
import type { Columns } from './columns.js';
import { aside, riseToBorder } from './slope.js';
import type { MarchSlope } from './slope.js';

/** The ray passes through a surface. */
export const BLOCKED = -2;
/** The ray meets nothing. */
export const CLEAR = -1;

/**
 * Follows the ray from a start in a grid of `size` voxels. Returns {@link BLOCKED}, {@link CLEAR}, or a rise
 * in 2^-12 voxels. A rise means that the ray meets no surface in the file, but has been in shadow from its
 * start up to that rise, where a surface may be hidden.
 */
export function march(columns: Columns, size: Vec3, slope: MarchSlope, start: Vec3): number {
  /** A ray that comes out of a column's shadow so close to its surface has passed through the surface's edge. */
  const EDGE = 2 * FIXED_ONE;
  const depth = Math.min(start[2], size[2] * FIXED_ONE - 1);
  let hasBeenDark = false;
  /** The rise at which the ray was first in light, and at most the ray's last rise. */
  let litFrom = depth;
  /** The surface of the column that the ray was in before; it is far away if it was not in shadow there. */
  let behind = -Infinity;
  for (let rise = 0; ; ) {
    const z = depth - rise;
    const x = start[0] + aside(slope[0], rise);
    const y = start[1] + aside(slope[1], rise);
    const i = Math.floor(x / FIXED_ONE);
    const j = Math.floor(y / FIXED_ONE);
    const isOutside = z < 0 || i < 0 || i >= size[0] || j < 0 || j >= size[1];
    if (isOutside) return hasBeenDark ? Math.min(litFrom, rise) : CLEAR;
    const { level, isLeaf, nearest, farthest } = columns.blockAt(i, j);
    let toBorder = riseToBorder(slope, x, y, level);
    let surface = nearest;
    if (isLeaf && !isInFront(z, nearest)) {
      const isBehindAll = farthest !== NEVER && z - toBorder >= farthest * FIXED_ONE + EDGE;
      surface = isBehindAll ? farthest : columns.depthAt(i, j);
      if (!isBehindAll) toBorder = riseToBorder(slope, x, y, 0);
    }
    if (isInFront(z, surface)) {
      if (z - behind < EDGE) return BLOCKED;
      behind = -Infinity;
      litFrom = Math.min(litFrom, rise);
    } else {
      if (z - toBorder < surface * FIXED_ONE) return BLOCKED;
      hasBeenDark = true;
      behind = surface * FIXED_ONE;
    }
    rise += toBorder;
  }
}

/** Whether a position is in front of a surface. */
function isInFront(z: number, surface: number): boolean {
  return surface === NEVER || z < surface * FIXED_ONE;
}
