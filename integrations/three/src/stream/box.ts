// The part of space that a bundle answers for: a box, in the oblique frame sheared along the light.

import { toWorld } from '../grid/light-grid.js';
import type { LightGrid } from '../grid/light-grid.js';
import { cross, dot, map3 } from '../grid/vec3.js';
import type { Vec3 } from '../grid/vec3.js';
import { BUNDLE_SIDE, PAGE_LEVEL } from '../quadtree/pages.js';

/** A box in the world. Its edges along x and y are at right angles; the third may lean. */
export interface Box {
  /** The corner from which the edges lead. */
  readonly corner: Vec3;
  /** The edges, world units. */
  readonly edges: readonly [Vec3, Vec3, Vec3];
  /** The middle of a ball that contains the box. */
  readonly middle: Vec3;
  /** The ball's radius. */
  readonly radius: number;
}

/** Returns the box of the bundle (x, y) of a grid, in which no column switches nearer than `nearest`. */
export function boxOf(grid: LightGrid, x: number, y: number, nearest: number): Box {
  /** Texels, or voxels of depth, around a bundle whose look-ups may need it. */
  const MARGIN = 16;
  const side = BUNDLE_SIDE << PAGE_LEVEL;
  const { size, voxelSize } = grid;
  const low: Vec3 = [Math.max(side * x - MARGIN, 0), Math.max(side * y - MARGIN, 0), Math.min(Math.max(nearest - MARGIN, 0), size[2])];
  const high: Vec3 = [Math.min(side * (x + 1) + MARGIN, size[0]), Math.min(side * (y + 1) + MARGIN, size[1]), size[2]];
  const edge = (a: 0 | 1 | 2): Vec3 => map3(grid.edges[a], (c) => c * voxelSize * (high[a] - low[a]));
  const edges = [edge(0), edge(1), edge(2)] as const;
  const corner = toWorld(grid, low);
  const half = map3(corner, (_, a) => (edges[0][a] + edges[1][a] + edges[2][a]) / 2);
  const radius = edges.reduce((sum, each) => sum + length(each), 0) / 2;
  return { corner, edges, middle: map3(corner, (c, a) => c + half[a]), radius };
}

/** Returns the distance of a point from a box, 0 inside. */
export function distanceTo({ corner, edges: [ex, ey, ez], radius }: Box, p: Vec3): number {
  const [lx, ly] = [length(ex), length(ey)];
  const [ux, uy] = [unit(ex, lx), unit(ey, ly)];
  const uz = cross(ux, uy);
  const from = map3(p, (c, a) => c - corner[a]);
  const [fx, fy, fz] = [dot(from, ux), dot(from, uy), dot(from, uz)];
  const [gx, gy, gz] = [dot(ez, ux), dot(ez, uy), dot(ez, uz)];
  /** The square of the distance from the slice at a share of the third edge. */
  const squared = (share: number): number => {
    const [x, y, z] = [outside(fx - share * gx, lx), outside(fy - share * gy, ly), fz - share * gz];
    return x * x + y * y + z * z;
  };
  // The square is convex along the edge, so each step drops a third that cannot have the minimum.
  const STEPS = 40;
  let [low, high] = [0, 1];
  for (let step = 0; step < STEPS; step++) {
    const [a, b] = [low + (high - low) / 3, high - (high - low) / 3];
    if (squared(a) < squared(b)) high = b;
    else low = a;
  }
  // Inside the box, the slice of the point itself is at a distance of 0, up to rounding.
  const own = Math.min(Math.max(fz / gz, 0), 1) || 0;
  const distance = Math.sqrt(Math.min(squared((low + high) / 2), squared(own)));
  return distance < 1e-9 * radius ? 0 : distance;
}

/** How far a number is from 0 … end. */
function outside(x: number, end: number): number {
  return x - Math.min(Math.max(x, 0), end);
}

function length(v: Vec3): number {
  return Math.sqrt(dot(v, v));
}

function unit(v: Vec3, ofLength: number): Vec3 {
  return map3(v, (c) => c / ofLength);
}
