// The grid of a file and its mapping to and from world space. Counterpart of
// `crates/adumbra/src/grid/light_grid.rs` and `frame.rs`; `spec/adumbra-file.md` has the formulas.

import { dot, map3 } from './vec3.js';
import type { Mat3, Vec3 } from './vec3.js';

/** An axis-aligned box, world space. */
export interface Bounds {
  /** Corner with the smallest coordinates, world units. */
  readonly min: Vec3;
  /** Corner with the largest coordinates, world units. */
  readonly max: Vec3;
}

/**
 * The grid of a file: an affine map between the world and voxels.
 *
 * In grid space, x and y count texels across the light, and z counts voxels along the light, away from the
 * sun. All points of a sun ray have the same x and y. World space is right-handed, Y up.
 */
export interface LightGrid {
  /** Unit vector towards the sun, world space; y above 0. */
  readonly sun: Vec3;
  /**
   * Orientation of the grid in the world: perpendicular to the light, or upright and sheared along the light.
   */
  readonly frame: 'light' | 'oblique';
  /** Angle from the world's +X to the grid's x axis, towards +Z, radians, −π to π; 0 in the frame of the light. */
  readonly yawRadians: number;
  /** Edge of a voxel, world units; in the oblique frame that of its horizontal edges, and its height. */
  readonly voxelSize: number;
  /** Grid position of the corner (0, 0, 0), in voxels from the world's origin. */
  readonly corner: Vec3;
  /** Rows of the linear map from world to grid, for voxels of size 1. */
  readonly axes: Mat3;
  /** Edges of a voxel in the world, in units of `voxelSize`. */
  readonly edges: Mat3;
  /** Number of voxels along x, y, z. */
  readonly size: Vec3;
}

/** Returns the rows of the linear map from world to grid in the oblique frame. */
export function obliqueAxes(sun: Vec3, yawRadians: number): Mat3 {
  const cos = Math.cos(yawRadians);
  const sin = Math.sin(yawRadians);
  const row = (x: number, z: number): Vec3 => [x, -(x * sun[0] + z * sun[2]) / sun[1], z];
  return [row(cos, sin), row(-sin, cos), [0, -1, 0]];
}

/**
 * Returns the edges of a voxel in the oblique frame.
 *
 * The cosine and sine of yaw are taken from the axes, because the last bit of `Math.cos` differs between
 * browsers.
 */
export function obliqueEdges(sun: Vec3, axes: Mat3): Mat3 {
  const [x, y] = axes;
  return [
    [x[0], 0, x[2]],
    [y[0], 0, y[2]],
    [-sun[0] / sun[1], -1, -sun[2] / sun[1]],
  ];
}

/** Converts a world point to grid coordinates, voxels. */
export function toGrid(grid: LightGrid, pWorld: Vec3): Vec3 {
  return map3(grid.corner, (corner, a) => dot(grid.axes[a], pWorld) / grid.voxelSize - corner);
}

/** Converts a grid point to world coordinates, world units. */
export function toWorld(grid: LightGrid, pGrid: Vec3): Vec3 {
  const along = map3(pGrid, (c, a) => (c + grid.corner[a]) * grid.voxelSize);
  const [x, y, z] = grid.edges;
  // The sum begins at 0, so that it is never −0.
  return map3(along, (_, w) => 0 + x[w] * along[0] + y[w] * along[1] + z[w] * along[2]);
}

/** Returns the middle of the grid, world units, each coordinate rounded to 32-bit floating point. */
export function middle(grid: LightGrid): Vec3 {
  return map3(toWorld(grid, map3(grid.size, (n) => 0.5 * n)), Math.fround);
}

/**
 * Returns the rows of the map from the unit circle across the light to the ellipse, in grid x and y, whose
 * points are on the same sun rays: two rows of two numbers. It is the identity in the frame of the light.
 */
export function circleAcrossLight(grid: LightGrid): [number, number, number, number] {
  const [sx, sy, sz] = grid.sun;
  const flat = Math.sqrt(sx * sx + sz * sz);
  if (grid.frame === 'light' || flat === 0) return [1, 0, 0, 1];
  // The sun's compass direction in the grid: horizontal vectors have the same length in both.
  const compass: Vec3 = [sx / flat, 0, sz / flat];
  const hx = dot(grid.axes[0], compass);
  const hy = dot(grid.axes[1], compass);
  const longer = 1 / sy - 1;
  return [1 + longer * hx * hx, longer * hx * hy, longer * hx * hy, 1 + longer * hy * hy];
}

/** Returns by how many texels the radius of the cone of a sun with this full angle grows per voxel of depth. */
export function coneTexelsPerVoxel(grid: LightGrid, sunDegrees: number): number {
  const edge = grid.edges[2];
  const voxelAlongLight = Math.sqrt(dot(edge, edge)) * grid.voxelSize;
  return (Math.tan(0.5 * sunDegrees * (Math.PI / 180)) * voxelAlongLight) / grid.voxelSize;
}
