// Where the parts of a file are in a pool: `spec/streaming.md`, "The pool".

import { ShadowFileError } from '../error.js';
import type { GridEntry } from '../file/directory.js';
import type { BundleEntry } from '../file/table.js';
import { PAGE_LEVEL, blockDims } from '../quadtree/pages.js';
import type { Dims } from '../quadtree/pages.js';
import { rootLevelOf } from '../quadtree/top.js';
import { inGranules } from './allocator.js';

/** Where the permanent parts of a level are. */
export interface LevelPlace {
  /** Number of the level in the file. */
  readonly level: number;
  /** First word of its table of blocks. */
  readonly tableAt: number;
  /** First word of the weights of its pages, row by row; `undefined` if they do not fade. */
  readonly weightsAt: number | undefined;
  /** Number of pages along x and y. */
  readonly pageDims: Dims;
  /** First word of its common section. Addresses of its blocks count from here. */
  readonly commonAt: number;
  /** Its blocks span 2^rootLevel columns along each side. */
  readonly rootLevel: number;
  /** Number of blocks along x and y. */
  readonly topDims: Dims;
}

/** A pool's parts. */
export interface PoolLayout {
  /** The levels in use, the finest first. */
  readonly levels: readonly LevelPlace[];
  /** First word of the pages. */
  readonly pagesAt: number;
  /** Texels per row of the pool as a texture, a power of two. */
  readonly width: number;
  /** Number of rows. */
  readonly height: number;
}

/** Returns the size of a nearly square texture of at most `words` words, whose width is a power of two. */
export function poolSize(words: number): [width: number, height: number] {
  let width = 1;
  while (width * width < words) width *= 2;
  return [width, Math.floor(words / width)];
}

/**
 * Lays out a pool of at most `budget` bytes. If levels fade, all but the coarsest have a weight for each
 * page.
 *
 * @throws ShadowFileError of the kind `TooLarge`, if the coarsest level does not fit.
 */
export function poolLayout(
  budget: number,
  entries: readonly GridEntry[],
  tables: readonly (readonly BundleEntry[])[],
  fades = false,
): PoolLayout {
  const [width, height] = poolSize(Math.floor(budget / 4));
  const words = width * height;
  const coarsest = entries.length - 1;
  const sizes = entries.map(({ grid: { size }, commonRawBytes }, level) => {
    const rootLevel = rootLevelOf(size);
    const [topDims, pageDims] = [blockDims(size, rootLevel), blockDims(size, PAGE_LEVEL)];
    const blocks = 2 * topDims[0] * topDims[1];
    const weights = fades && level < coarsest ? pageDims[0] * pageDims[1] : 0;
    return { rootLevel, topDims, pageDims, blocks, weights, table: blocks + weights, common: commonRawBytes / 4 };
  });
  const ofPages = tables[coarsest]!.reduce((sum, { pageWords }) => sum + pageWords, 0);
  /** The words of a level and of all coarser levels. */
  const needed = (level: number): number => sizes.slice(level).reduce((sum, { table, common }) => sum + table + common, ofPages);
  if (needed(coarsest) > words) throw tooSmall(budget, 4 * needed(coarsest));
  let finest = coarsest;
  while (finest > 0 && needed(finest - 1) <= words / 2) finest--;

  const used = sizes.slice(finest);
  let tableAt = 0;
  let commonAt = used.reduce((sum, { table }) => sum + table, 0);
  const levels = used.map(({ rootLevel, topDims, pageDims, blocks, weights, table, common }, i) => {
    const weightsAt = weights === 0 ? undefined : tableAt + blocks;
    const place = { level: finest + i, tableAt, weightsAt, pageDims, commonAt, rootLevel, topDims };
    tableAt += table;
    commonAt += common;
    return place;
  });
  return { levels, pagesAt: inGranules(commonAt), width, height };
}

/** Returns the error of a budget that does not hold the coarsest level. */
export function tooSmall(budget: number, needed: number): ShadowFileError {
  return new ShadowFileError('TooLarge', `the coarsest level needs ${needed} bytes, but the budget is ${budget}; raise it, or bake with more levels`, {
    needed,
    budget,
  });
}
