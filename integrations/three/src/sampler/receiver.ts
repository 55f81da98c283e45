// Receivers: a point on a surface, moved by the bias and rounded to fixed point. From there on a look-up uses
// whole numbers only, so that the CPU, the GPU and every other reader agree on every tap.
// `spec/adumbra-file.md`, "Look-up bias and filters". Counterpart of `crates/adumbra/src/query/fixed.rs` and
// of `receiver` in `mod.rs`.
//
// Whole numbers here are below 2^53, so doubles hold them exactly, in grids of any size.

import { FIXED_ONE, GRADIENT_ONE, MAX_PLANE_SLOPE } from '../grid/fixed.js';
import type { LightGrid } from '../grid/light-grid.js';
import { dot } from '../grid/vec3.js';
import type { Vec3 } from '../grid/vec3.js';
import type { Bias } from '../settings.js';

/** A point of a surface in the grid, in fixed point. */
export interface Receiver {
  readonly x: number;
  readonly y: number;
  readonly z: number;
  /** Slopes of the receiver's plane along x and y. */
  readonly dx: number;
  readonly dy: number;
}

/** Places a receiver at a world point. A point that is not finite is placed before the grid, where all is lit. */
export function receiverAt({ axes, edges, corner, voxelSize, size }: LightGrid, bias: Bias, p: Vec3, normal: Vec3 | undefined): Receiver {
  /** The largest slope that the bias uses. */
  const MAX_SLOPE = 9.95;
  let x = dot(axes[0], p) / voxelSize - corner[0];
  let y = dot(axes[1], p) / voxelSize - corner[1];
  let z = dot(axes[2], p) / voxelSize - corner[2];
  let slope = 0;
  let dx = 0;
  let dy = 0;
  if (normal?.every(isFinite)) {
    const nx = dot(edges[0], normal);
    const ny = dot(edges[1], normal);
    const nz = dot(edges[2], normal);
    const tangent = Math.sqrt(nx * nx + ny * ny);
    const steepness = Math.max(Math.abs(nz), tangent / MAX_PLANE_SLOPE);
    if (steepness > 0 && steepness < Infinity) {
      const towardsSun = nz > 0 ? -steepness : steepness;
      dx = gradient(nx / towardsSun);
      dy = gradient(ny / towardsSun);
      slope = tangent / steepness;
    }
    x += dot(axes[0], normal) * bias.normalOffsetTexels;
    y += dot(axes[1], normal) * bias.normalOffsetTexels;
    z += dot(axes[2], normal) * bias.normalOffsetTexels;
  }
  z -= bias.constantTexels + bias.slopeTexels * Math.min(slope, MAX_SLOPE);
  if (!isFinite(x) || !isFinite(y) || !isFinite(z)) x = y = z = -Infinity;
  return { x: fixed(x, size[0]), y: fixed(y, size[1]), z: fixed(z, size[2]), dx, dy };
}

/** Returns the layer in which a receiver's plane passes the centre of a texel. It may be outside the grid. */
export function layerAt({ x, y, z, dx, dy }: Receiver, texelX: number, texelY: number): number {
  const alongX = dx * (texelX * FIXED_ONE + FIXED_ONE / 2 - x);
  const alongY = dy * (texelY * FIXED_ONE + FIXED_ONE / 2 - y);
  return Math.floor((z * GRADIENT_ONE + alongX + alongY) / (FIXED_ONE * GRADIENT_ONE));
}

/** Rounds a grid coordinate down to fixed point, near a grid of `side` voxels. */
function fixed(voxels: number, side: number): number {
  /** Points are kept within this many voxels around the grid. */
  const MARGIN_VOXELS = 4096;
  return Math.min(Math.max(Math.floor(voxels * FIXED_ONE), -MARGIN_VOXELS * FIXED_ONE), (side + MARGIN_VOXELS) * FIXED_ONE);
}

/** Rounds a slope to the nearest in fixed point. */
function gradient(slope: number): number {
  const most = MAX_PLANE_SLOPE * GRADIENT_ONE;
  return Math.min(Math.max(Math.floor(slope * GRADIENT_ONE + 0.5), -most), most);
}
