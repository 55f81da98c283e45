// Receivers: a point on a surface, moved by the bias and rounded to fixed point. From there on a look-up uses whole
// numbers only, so that the CPU, the GPU and every other reader agree on every tap. `spec/adumbra-file.md`, "Look-up bias
// and filters". Counterpart of `crates/adumbra/src/query/fixed.rs` and of `receiver` in `mod.rs`.
//
// Whole numbers here are below 2^53, so doubles hold them exactly, in grids of any size.

import { FIXED_ONE } from '../grid/fixed.js';
import { toGrid } from '../grid/light-grid.js';
import type { LightGrid } from '../grid/light-grid.js';
import { dot, map3 } from '../grid/vec3.js';
import type { Vec3 } from '../grid/vec3.js';
import type { Bias } from '../settings.js';


/** A point of a surface in the grid. */
export interface Receiver {
  /** Texel that contains the point. It may be outside the grid. */
  readonly texelX: number;
  readonly texelY: number;
  /** Returns the layer in which the receiver's plane passes the centre of a texel. It may be outside the grid. */
  layer(x: number, y: number): number;
}

/** Places a receiver at a world point. A point that is not finite is placed before the grid, where all is lit. */
export function receiverAt(grid: LightGrid, bias: Bias, p: Vec3, normal: Vec3 | undefined): Receiver {
  /** A slope of 1 in fixed point. */
  const GRADIENT_ONE = 256;
  /** Units of a depth of the receiver's plane per voxel. */
  const DEPTH_ONE = FIXED_ONE * GRADIENT_ONE;
  /** Points are held within this many voxels around the grid. */
  const MARGIN_VOXELS = 4096;
  /** The largest slope that the bias uses. */
  const MAX_SLOPE = 9.95;
  /** The steepest plane that look-ups follow from texel to texel. */
  const MAX_PLANE_SLOPE = 120;
  /** The largest gradient in fixed point. */
  const MAX_GRADIENT = MAX_PLANE_SLOPE * GRADIENT_ONE;
  /** Rounds a grid coordinate down to fixed point, near a grid of `side` voxels. */
  const fixed = (voxels: number, side: number): number =>
    clamp(Math.floor(voxels * FIXED_ONE), -MARGIN_VOXELS * FIXED_ONE, (side + MARGIN_VOXELS) * FIXED_ONE);
  /** Rounds a slope to the nearest in fixed point. */
  const gradient = (slope: number): number => clamp(Math.floor(slope * GRADIENT_ONE + 0.5), -MAX_GRADIENT, MAX_GRADIENT);
  const { axes, edges, size } = grid;
  let place = toGrid(grid, p);
  let slope = 0;
  let gradientX = 0;
  let gradientY = 0;
  if (normal?.every(isFinite)) {
    const [nx, ny, nz] = map3(edges, (edge) => dot(edge, normal));
    const tangent = Math.sqrt(nx * nx + ny * ny);
    const steepness = Math.max(Math.abs(nz), tangent / MAX_PLANE_SLOPE);
    if (steepness > 0 && steepness < Infinity) {
      const towardsSun = nz > 0 ? -steepness : steepness;
      gradientX = gradient(nx / towardsSun);
      gradientY = gradient(ny / towardsSun);
      slope = tangent / steepness;
    }
    place = map3(place, (c, a) => c + dot(axes[a], normal) * bias.normalOffsetTexels);
  }
  const lift = bias.constantTexels + bias.slopeTexels * Math.min(slope, MAX_SLOPE);
  place = [place[0], place[1], place[2] - lift];
  const isSomewhere = place.every(isFinite);
  const [fixedX, fixedY, fixedZ] = map3(place, (c, a) => fixed(isSomewhere ? c : -Infinity, size[a]));
  return {
    texelX: Math.floor(fixedX / FIXED_ONE),
    texelY: Math.floor(fixedY / FIXED_ONE),
    layer(x, y) {
      const alongX = gradientX * (x * FIXED_ONE + FIXED_ONE / 2 - fixedX);
      const alongY = gradientY * (y * FIXED_ONE + FIXED_ONE / 2 - fixedY);
      return Math.floor((fixedZ * GRADIENT_ONE + alongX + alongY) / DEPTH_ONE);
    },
  };
}

function clamp(value: number, low: number, high: number): number {
  return Math.min(Math.max(value, low), high);
}
