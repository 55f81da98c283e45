// Look-ups on the CPU for a sun between two that files were baked for. Counterpart of
// `crates/adumbra/src/path/sampler.rs`, with bit-identical answers.

import type { BakedShadowFile } from '../file/shadow-file.js';
import { FIXED_ONE } from '../grid/fixed.js';
import type { LightGrid } from '../grid/light-grid.js';
import { placedGrid } from '../grid/placement.js';
import type { PointLike, Vec3 } from '../grid/vec3.js';
import { LOOK_UP_DEFAULTS, checkFilter } from '../settings.js';
import type { Bias, FilterWidth, LookUpOptions } from '../settings.js';
import type { Answering } from './answering.js';
import { columnsOf } from './columns.js';
import type { Columns } from './columns.js';
import { CLEAR, march } from './march.js';
import { marchStarts } from './slope.js';
import type { MarchSlope } from './slope.js';

/** A key that is marched through. */
interface Key {
  readonly file: BakedShadowFile;
  readonly columns: Columns;
  readonly slope: MarchSlope;
  /** The grid in the app's world. */
  readonly grid: LightGrid;
}

/** Look-ups of points at a moment of a sun path, in the keys that were in memory when it was made. */
export class PathSampler {
  /** Width of the filter, texels. */
  declare readonly filter: FilterWidth;
  /** The bias that points are moved by, texels. */
  declare readonly bias: Bias;
  /**
   * Whether the keys of the moment answer. Otherwise not all of those were in memory, and others stand in for
   * them.
   */
  declare readonly isExact: boolean;
  /** The keys in the order in which they are looked up; none at night, when every point is in shadow. */
  readonly #keys: readonly Key[];

  /** For {@link SunPathFile.sampler}. `bias` is by default that of the file that is looked up first. */
  constructor(answering: Answering | undefined, { filter = LOOK_UP_DEFAULTS.filter, bias, placement }: LookUpOptions) {
    checkFilter(filter);
    const parts = answering?.parts ?? [];
    this.#keys = parts.map(({ file, slope }) => ({ file, grid: placedGrid(file.grid, placement), slope, columns: columnsOf(file) }));
    const none: Bias = { constantTexels: 0, slopeTexels: 0, normalOffsetTexels: 0 };
    Object.assign(this, { filter, bias: bias ?? parts[0]?.file.settings.bias ?? none, isExact: answering?.isExact ?? true });
  }

  /**
   * Returns the visibility of a point in world space: 1 lit, 0 shadowed, between them the share of rays that
   * meet nothing.
   *
   * `normal` is the unit normal of the surface there, world space; without one the point is in the air.
   */
  visibility(point: PointLike, normal?: PointLike): number {
    return this.#lookUp([point.x, point.y, point.z], normal && [normal.x, normal.y, normal.z]);
  }

  /**
   * Returns the visibilities of points, like {@link PathSampler.visibility}.
   *
   * @param points Three numbers per point, world space. An incomplete last point is ignored.
   * @param normals Three numbers per point: the unit normals of the surfaces there, if they are known.
   */
  visibilities(points: ArrayLike<number>, normals?: ArrayLike<number>): Float32Array {
    const three = (all: ArrayLike<number>, at: number): Vec3 => [all[at], all[at + 1], all[at + 2]] as unknown as Vec3;
    return Float32Array.from({ length: Math.floor(points.length / 3) }, (_, i) => this.#lookUp(three(points, 3 * i), normals && three(normals, 3 * i)));
  }

  #lookUp(p: Vec3, normal: Vec3 | undefined): number {
    if (this.#keys.length === 0) return 0;
    const starts = this.#keys.map(({ grid, slope }) => marchStarts(grid, slope, this.bias, this.filter, p, normal));
    const rays = starts[0]!.length;
    let lit = 0;
    for (let ray = 0; ray < rays; ray++) lit += Number(this.#isLit(starts, ray));
    return Math.fround(lit / rays);
  }

  /**
   * Whether a ray meets nothing. `starts` are the starts of the rays in each grid. The first key with an
   * answer decides. If no key has an answer, it depends on how long the ray is hidden from all of them.
   */
  #isLit(starts: readonly (readonly Vec3[])[], ray: number): boolean {
    let hiddenRise = Infinity;
    for (const [key, { file, columns, slope }] of this.#keys.entries()) {
      const marched = march(columns, file.grid.size, slope, starts[key]![ray]!);
      if (marched < 0) return marched === CLEAR;
      hiddenRise = Math.min(hiddenRise, marched);
    }
    const darkAfter = this.#keys[0]!.file.settings.darkAfterVoxels;
    return darkAfter === 0 || Math.floor(hiddenRise / FIXED_ONE) < darkAfter;
  }
}
