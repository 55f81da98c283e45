// The slope towards a sun in the grid of a file that was baked for another sun, in fixed point. Counterpart
// of `MarchSlope` in `crates/adumbra/src/query/march.rs`.
//
// Whole numbers here are below 2^53, so doubles hold them exactly.

import { FIXED_ONE, GRADIENT_ONE, MAX_PLANE_SLOPE } from '../grid/fixed.js';
import { toGrid } from '../grid/light-grid.js';
import type { LightGrid } from '../grid/light-grid.js';
import { dot, map3 } from '../grid/vec3.js';
import type { Vec3 } from '../grid/vec3.js';
import { receiverAt } from '../sampler/receiver.js';
import type { Bias, FilterWidth } from '../settings.js';

/** Texels along x and y per voxel of depth, sunward, in units of 2^-16. */
export type MarchSlope = readonly [x: number, y: number];

/** Units of a slope per texel. */
const SLOPE_ONE = 65_536;

/**
 * Returns the slope towards a sun, given as a unit vector. `undefined` if the sun is too far from the file's
 * own: behind its plane, or more than 256 texels sideways per voxel of depth.
 */
export function marchSlope({ axes }: LightGrid, towardsSun: Vec3): MarchSlope | undefined {
  const MAX_SLOPE = 256 * SLOPE_ONE - 1;
  const [x, y, z] = map3(axes, (axis) => dot(axis, towardsSun));
  if (!(z < 0)) return undefined;
  const slope = [x, y].map((c) => Math.floor((c / -z) * SLOPE_ONE + 0.5)) as [number, number];
  return slope.every((c) => Math.abs(c) <= MAX_SLOPE) ? slope : undefined;
}

/**
 * Returns where the rays of a filter begin in a grid: one at the point itself, or 3 × 3 on the receiver's
 * plane.
 */
export function marchStarts(grid: LightGrid, slope: MarchSlope, bias: Bias, filter: FilterWidth, p: Vec3, normal: Vec3 | undefined): Vec3[] {
  const [x, y, z] = middleStart(grid, slope, bias, p, normal);
  const apart = filter >> 1;
  if (apart === 0) return [[x, y, z]];
  const { dx, dy } = receiverAt(grid, bias, p, normal);
  const starts: Vec3[] = [];
  for (const tapY of [-apart, 0, apart]) {
    for (const tapX of [-apart, 0, apart]) {
      starts.push([x + FIXED_ONE * tapX, y + FIXED_ONE * tapY, z + (FIXED_ONE / GRADIENT_ONE) * (dx * tapX + dy * tapY)]);
    }
  }
  return starts;
}

/** Returns a point in the grid, moved by the bias along the ray and the normal. Points far outside are moved to the margin. */
function middleStart(grid: LightGrid, slope: MarchSlope, bias: Bias, p: Vec3, normal: Vec3 | undefined): Vec3 {
  /** The largest slope that the bias uses. */
  const MAX_SLOPE = 9.95;
  /** Points are kept within this many voxels around the grid. */
  const MARGIN_VOXELS = 4096;
  const [vx, vy] = [slope[0] / SLOPE_ONE, slope[1] / SLOPE_ONE];
  let [x, y, z] = toGrid(grid, p);
  let steep = 0;
  if (normal?.every(isFinite)) {
    const [nx, ny, nz] = map3(grid.edges, (edge) => dot(edge, normal));
    const tangent = Math.sqrt(nx * nx + ny * ny);
    const along = Math.max(Math.abs(nx * vx + ny * vy - nz), tangent / MAX_PLANE_SLOPE);
    if (along > 0 && along < Infinity) steep = tangent / along;
    x += dot(grid.axes[0], normal) * bias.normalOffsetTexels;
    y += dot(grid.axes[1], normal) * bias.normalOffsetTexels;
    z += dot(grid.axes[2], normal) * bias.normalOffsetTexels;
  }
  const rise = bias.constantTexels + bias.slopeTexels * Math.min(steep, MAX_SLOPE);
  const start: Vec3 = [x + vx * rise, y + vy * rise, z - rise];
  const low = -MARGIN_VOXELS * FIXED_ONE;
  const isSomewhere = start.every(isFinite);
  return map3(start, (c, a) => {
    if (!isSomewhere) return low;
    return Math.min(Math.max(Math.floor(c * FIXED_ONE), low), (grid.size[a] + MARGIN_VOXELS) * FIXED_ONE);
  });
}

/** Returns the distance along an axis after a rise. */
export function aside(slope: number, rise: number): number {
  const steep = Math.abs(slope);
  // In two parts, since the product may have more bits than a double.
  const low = rise % SLOPE_ONE;
  return Math.sign(slope) * (steep * ((rise - low) / SLOPE_ONE) + Math.floor((steep * low) / SLOPE_ONE));
}

/**
 * Returns the rise from a position in the grid to the border of the block of 2^level columns a side that
 * contains it. Where that is farther than 16 texels, it is up to one 16th of a voxel less.
 */
export function riseToBorder(slope: MarchSlope, x: number, y: number, level: number): number {
  const side = FIXED_ONE * 2 ** level;
  return Math.min(riseAlong(slope[0], x % side, side), riseAlong(slope[1], y % side, side));
}

function riseAlong(slope: number, within: number, side: number): number {
  if (slope === 0) return Number.MAX_SAFE_INTEGER;
  const steep = Math.abs(slope);
  const left = slope > 0 ? side - within : within + 1;
  return left < 65_536 ? Math.floor((left * 65_536) / steep) + 1 : 256 * Math.floor((left * 256) / steep);
}
