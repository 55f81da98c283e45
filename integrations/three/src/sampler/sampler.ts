// Visibility of points on the CPU. All answers equal those of the Rust crate bit for bit. The rules are in
// `spec/adumbra-file.md`, "Look-up of a point" and "Look-up bias and filters". Counterpart of
// `crates/adumbra/src/query/`.

import type { BakedShadowFile } from '../file/shadow-file.js';
import { toGrid } from '../grid/light-grid.js';
import type { LightGrid } from '../grid/light-grid.js';
import { placedGrid } from '../grid/placement.js';
import type { PointLike, Vec3 } from '../grid/vec3.js';
import { voxelsOf } from '../quadtree/voxels.js';
import type { Voxels } from '../quadtree/voxels.js';
import { LOOK_UP_DEFAULTS, checkFilter } from '../settings.js';
import type { Bias, FilterWidth, LookUpOptions } from '../settings.js';
import { filteredVisibility } from './filtered.js';

/**
 * Look-ups of points in a file, for game logic, light probes and tests. It keeps its last block of voxels, so
 * points that follow each other closely cost less.
 */
export class Sampler {
  /** The file that is looked up in. */
  declare readonly file: BakedShadowFile;
  /** Width of the filter, texels. */
  declare readonly filter: FilterWidth;
  /** The bias that points are moved by, texels. */
  declare readonly bias: Bias;
  readonly #voxels: Voxels;
  readonly #grid: LightGrid;

  /**
   * Creates look-ups with a filter of `filter` × `filter` texels, by default 5 × 5.
   *
   * @throws RangeError if the width of the filter is not 1, 3, 5, 9 or 17, or if the placement does anything but move, turn,
   * and scale by one number.
   */
  constructor(file: BakedShadowFile, { filter = LOOK_UP_DEFAULTS.filter, bias = file.settings.bias, placement }: LookUpOptions = {}) {
    checkFilter(filter);
    this.#grid = placedGrid(file.grid, placement);
    Object.assign(this, { file, filter, bias });
    this.#voxels = voxelsOf(file);
  }

  /**
   * Returns the visibility of a point in world space: 1 lit, 0 shadowed, between them the share of lit taps.
   *
   * `normal` is the unit normal of the surface there, world space; without one the point is in the air. A
   * point that is not finite is lit, a normal that is not finite counts as none.
   */
  visibility(point: PointLike, normal?: PointLike): number {
    return this.#filtered([point.x, point.y, point.z], normal && [normal.x, normal.y, normal.z]);
  }

  /**
   * Returns the visibilities of points, like {@link Sampler.visibility}.
   *
   * @param points Three numbers per point, world space. An incomplete last point is ignored.
   * @param normals Three numbers per point: the unit normals of the surfaces there, if they are known.
   */
  visibilities(points: ArrayLike<number>, normals?: ArrayLike<number>): Float32Array {
    const answers = new Float32Array(Math.floor(points.length / 3));
    for (let i = 0, at = 0; i < answers.length; i++, at += 3) {
      const normal: Vec3 | undefined = normals && [normals[at], normals[at + 1], normals[at + 2]];
      answers[i] = this.#filtered([points[at], points[at + 1], points[at + 2]], normal);
    }
    return answers;
  }

  /**
   * Returns whether a point in world space is lit, without filter and bias: 1 lit, 0 shadowed. Points beside
   * the grid and sunward of it are lit.
   */
  pointVisibility(point: PointLike): 0 | 1 {
    const grid = this.#grid;
    const [x, y, z] = toGrid(grid, [point.x, point.y, point.z]);
    const [sizeX, sizeY, sizeZ] = grid.size;
    const isInside = x >= 0 && x < sizeX && y >= 0 && y < sizeY && z >= 0;
    if (!isInside) return 1;
    const layer = Math.min(Math.floor(z), sizeZ - 1);
    return this.#voxels(Math.floor(x), Math.floor(y), layer) ? 1 : 0;
  }

  #filtered(p: Vec3, normal: Vec3 | undefined): number {
    return filteredVisibility(this.#grid, this, this.#voxels, p, normal);
  }
}
