// The headers of the levels in use, as shaders read them: `spec/look-up-texture.md`, "Levels".

import { PARAMETERS_AT, lookUpHeader } from '../gpu/look-up-header.js';
import type { GpuLookUpOptions, LookUpHeader } from '../gpu/look-up-header.js';
import type { LightGrid } from '../grid/light-grid.js';
import type { FileSettings } from '../settings.js';
import type { PoolLayout } from './layout.js';

/**
 * Returns the headers of a pool's levels, the finest first. All have the anchor of the finest.
 *
 * @throws ShadowFileError of the kind `TooLarge` if a grid is too large for GPUs.
 * @throws RangeError if an option is out of its range.
 */
export function poolHeaders({ levels, width, height }: PoolLayout, grids: readonly LightGrid[], settings: FileSettings, options: GpuLookUpOptions): LookUpHeader[] {
  /** Header word: number of words after the header. */
  const WORD_COUNT = 3;
  /** Header word: number of coarser levels. */
  const COARSER_COUNT = 7;
  /** Header word: the row of the next coarser level, 0 if there is none. */
  const COARSER_ROW = 106;
  const nothing = new Uint32Array();
  const count = width * height;
  return levels.map(({ rootLevel, topDims, tableAt, weightsAt, commonAt }, rank) => {
    const coarser = levels.length - 1 - rank;
    const header = lookUpHeader({ grid: grids[rank]!, settings, top: nothing, code: nothing, topDims, rootLevel }, options, undefined, grids[0]);
    const { words } = header;
    words[WORD_COUNT] = count;
    words[COARSER_COUNT] = coarser;
    words[COARSER_ROW] = coarser === 0 ? 0 : rank + 1;
    // The table, the number of coarser levels, 1 if pages may be absent or 2 if they fade, and the code.
    words.set([tableAt, coarser, weightsAt === undefined ? 1 : 2, commonAt], PARAMETERS_AT + 76);
    return Object.assign(header, { count });
  });
}
