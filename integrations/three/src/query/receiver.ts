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

/** A point of a surface in the grid, in fixed point. */
export class Receiver {
  /** Texel that contains the point. It may be outside the grid. */
  texelX = 0;
  texelY = 0;
  #x = 0;
  #y = 0;
  #z = 0;
  #gradientX = 0;
  #gradientY = 0;

  /** Places the receiver at a world point. A point that is not finite is placed before the grid, where all is lit. */
  set(grid: LightGrid, bias: Bias, p: Vec3, normal: Vec3 | undefined): void {
    const { axes, edges, size } = grid;
    let place = toGrid(grid, p);
    let slope = 0;
    this.#gradientX = 0;
    this.#gradientY = 0;
    if (normal?.every(Number.isFinite)) {
      const [nx, ny, nz] = map3(edges, (edge) => dot(edge, normal));
      const tangent = Math.sqrt(nx * nx + ny * ny);
      const steepness = Math.max(Math.abs(nz), tangent / MAX_PLANE_SLOPE);
      if (steepness > 0 && steepness < Infinity) {
        const towardsSun = nz > 0 ? -steepness : steepness;
        this.#gradientX = gradient(nx / towardsSun);
        this.#gradientY = gradient(ny / towardsSun);
        slope = tangent / steepness;
      }
      place = map3(place, (c, a) => c + dot(axes[a], normal) * bias.normalOffsetTexels);
    }
    const lift = bias.constantTexels + bias.slopeTexels * Math.min(slope, MAX_SLOPE);
    const lifted: Vec3 = [place[0], place[1], place[2] - lift];
    const isFinite = lifted.every(Number.isFinite);
    [this.#x, this.#y, this.#z] = map3(lifted, (c, a) => fixed(isFinite ? c : -Infinity, size[a]));
    this.texelX = Math.floor(this.#x / FIXED_ONE);
    this.texelY = Math.floor(this.#y / FIXED_ONE);
  }

  /** Returns the layer in which the receiver's plane passes the centre of a texel. It may be outside the grid. */
  layer(x: number, y: number): number {
    const alongX = this.#gradientX * (x * FIXED_ONE + FIXED_ONE / 2 - this.#x);
    const alongY = this.#gradientY * (y * FIXED_ONE + FIXED_ONE / 2 - this.#y);
    return Math.floor((this.#z * GRADIENT_ONE + alongX + alongY) / DEPTH_ONE);
  }
}

/** Rounds a grid coordinate down to fixed point, near a grid of `side` voxels. */
function fixed(voxels: number, side: number): number {
  const low = -MARGIN_VOXELS * FIXED_ONE;
  const high = (side + MARGIN_VOXELS) * FIXED_ONE;
  return Math.min(Math.max(Math.floor(voxels * FIXED_ONE), low), high);
}

/** Rounds a slope to the nearest in fixed point. */
function gradient(slope: number): number {
  return Math.min(Math.max(Math.floor(slope * GRADIENT_ONE + 0.5), -MAX_GRADIENT), MAX_GRADIENT);
}
