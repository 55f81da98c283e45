// The bundles of the levels in use, and the state of each.

import type { GridEntry } from '../file/directory.js';
import type { BundleEntry } from '../file/table.js';
import { BUNDLE_SIDE, PAGE_LEVEL, blockDims, bundleDims, bundleOrder } from '../quadtree/pages.js';
import { GRANULE_WORDS } from './allocator.js';
import { boxOf } from './box.js';
import type { Box } from './box.js';
import type { LevelPlace } from './layout.js';
import type { Waiting } from './retry.js';

/**
 * The state of a bundle: not loaded; requested; arrived, and waiting until its words are in the pool; or read
 * by look-ups.
 */
export type BundleState = 'absent' | 'requested' | 'arrived' | 'resident';

/** A page of a bundle that has words, or leads to some. */
export interface PlacedPage {
  /** Its first word in the pool. */
  readonly at: number;
  /** Number of its words. */
  readonly words: number;
}

/** A bundle of a level in use. */
export interface Bundle extends Waiting {
  /** Number of its level among those in use, 0 for the finest. */
  readonly rank: number;
  /** Its number in the order of the file, in its level. */
  readonly index: number;
  readonly entry: BundleEntry;
  /** Where it begins in the file. */
  readonly offset: number;
  /** Its place in the grid, bundles along x and y. */
  readonly x: number;
  readonly y: number;
  readonly box: Box;
  state: BundleState;
  /** Words that it takes in the pool; before they are known, the most that it may take. */
  words: number;
  /** Where its pages are while they are in the pool. */
  pages: readonly PlacedPage[];
  /**
   * How many times coarser than wanted the picture is without it, as of the last choice. The bundle is wanted
   * if this is above 1.
   */
  need: number;
  /** Number of the last choice that it was part of. */
  chosenAt: number;
  /** The share of its answers in 1/256, while it fades in or out. */
  weight: number;
  /** Whether it is fading out. */
  isLeaving: boolean;
  /**
   * How many bundles had been given up when it found no room. It is requested again once more have been given
   * up.
   */
  blockedAt: number;
}

/** Returns the bundles of a level in the order of the file. */
export function bundlesOf(rank: number, { level }: LevelPlace, entries: readonly GridEntry[], table: readonly BundleEntry[]): Bundle[] {
  const { grid, bundles } = entries[level]!;
  let { offset } = bundles;
  const [across, down] = blockDims(grid.size, PAGE_LEVEL);
  return bundleOrder(bundleDims(grid.size)).map(([x, y], index) => {
    const entry = table[index]!;
    const pages = Math.min(across - BUNDLE_SIDE * x, BUNDLE_SIDE) * Math.min(down - BUNDLE_SIDE * y, BUNDLE_SIDE);
    const bundle: Bundle = {
      rank,
      index,
      entry,
      offset,
      x,
      y,
      box: boxOf(grid, x, y, entry.range[0]),
      state: 'absent',
      words: entry.pageWords + pages * (GRANULE_WORDS - 1),
      pages: [],
      need: 0,
      chosenAt: -1,
      failures: 0,
      notBefore: -Infinity,
      blockedAt: -1,
      weight: 0,
      isLeaving: false,
    };
    offset += entry.storedBytes;
    return bundle;
  });
}
