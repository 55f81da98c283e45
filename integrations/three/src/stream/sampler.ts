// Look-ups on the CPU in the resident parts of a streamed file.

import type { LightGrid } from '../grid/light-grid.js';
import { placedGrid } from '../grid/placement.js';
import type { PointLike } from '../grid/vec3.js';
import { voxelsOf } from '../quadtree/voxels.js';
import type { Voxels } from '../quadtree/voxels.js';
import { filteredVisibility } from '../sampler/filtered.js';
import { LOOK_UP_DEFAULTS, checkFilter } from '../settings.js';
import type { Bias, FilterWidth, LookUpOptions } from '../settings.js';
import { PAGE_LEVEL } from '../quadtree/pages.js';
import { ABSENT, WHOLE } from './pool.js';
import type { Pool } from './pool.js';

/** The parts of a streamed file that look-ups need. */
export interface SampledFile {
  readonly pool: Pool;
  /** Placement of the levels in use, the finest first. */
  readonly grids: readonly LightGrid[];
  readonly bias: Bias;
}

/**
 * Look-ups of points in a streamed file, like those of `Sampler` in a whole file. The finest level with all
 * pages under the filter resident answers; while these pages fade, the next coarser level has a share.
 */
export class StreamedSampler {
  /** Width of the filter, texels. */
  declare readonly filter: FilterWidth;
  /** The bias that points are moved by, texels of the level that answers. */
  declare readonly bias: Bias;
  readonly #file: SampledFile;
  #levels: readonly Voxels[] = [];
  #revision = 0;
  #isAbsent = false;
  /** The least weight of the pages that a filter has read. */
  #weight = WHOLE;

  /** For {@link StreamedShadowFile.sampler}. */
  constructor(file: SampledFile, { filter = LOOK_UP_DEFAULTS.filter, bias = file.bias, placement }: LookUpOptions) {
    checkFilter(filter);
    Object.assign(this, { filter, bias });
    this.#file = { ...file, grids: file.grids.map((grid) => placedGrid(grid, placement)) };
  }

  /**
   * Returns the visibility of a point in world space: 1 lit, 0 shadowed, between them the share of lit taps.
   *
   * `normal` is the unit normal of the surface there, world space; without one the point is in the air.
   */
  visibility(point: PointLike, normal?: PointLike): number {
    return this.#lookUp(point, normal).visibility;
  }

  /** Returns the number of the finest level in the file that answers at a point, 0 for the finest of all. */
  levelAt(point: PointLike, normal?: PointLike): number {
    return this.#file.pool.layout.levels[this.#lookUp(point, normal).rank]!.level;
  }

  #lookUp({ x, y, z }: PointLike, normal: PointLike | undefined): { rank: number; visibility: number } {
    const { pool, grids } = this.#file;
    if (this.#revision !== pool.revision) {
      this.#levels = grids.map((_, rank) => this.#voxelsOf(rank));
      this.#revision = pool.revision;
    }
    const n = normal && ([normal.x, normal.y, normal.z] as const);
    const sum = { rank: -1, visibility: 0 };
    let left = 1;
    // The coarsest level is always resident.
    for (let rank = 0; left > 0 && rank < grids.length; rank++) {
      this.#isAbsent = false;
      this.#weight = WHOLE;
      const visibility = filteredVisibility(grids[rank]!, this, this.#levels[rank]!, [x, y, z], n);
      if (this.#isAbsent || this.#weight === 0) continue;
      const share = left * (this.#weight / WHOLE);
      if (sum.rank < 0) sum.rank = rank;
      sum.visibility += share * visibility;
      left -= share;
    }
    return sum;
  }

  /**
   * Returns the look-up of voxels in a level. It notes the weights of their pages, and whether a page is not
   * resident.
   */
  #voxelsOf(rank: number): Voxels {
    const { words, layout } = this.#file.pool;
    const { tableAt, weightsAt, pageDims, commonAt, rootLevel, topDims } = layout.levels[rank]!;
    const top = words.subarray(tableAt, tableAt + 2 * topDims[0] * topDims[1]);
    const voxels = voxelsOf({ top, code: words.subarray(commonAt), rootLevel, topDims });
    return (x, y, z) => {
      if (top[2 * ((y >>> rootLevel) * topDims[0] + (x >>> rootLevel))] === ABSENT) {
        this.#isAbsent = true;
        return true;
      }
      if (weightsAt !== undefined) {
        const page = (y >>> PAGE_LEVEL) * pageDims[0] + (x >>> PAGE_LEVEL);
        this.#weight = Math.min(this.#weight, words[weightsAt + page]!);
      }
      return voxels(x, y, z);
    };
  }
}
