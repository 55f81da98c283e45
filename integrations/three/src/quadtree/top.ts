// The table of blocks at which look-ups begin. A file has one root per page, 512 × 512 columns. Where the grid is small, a
// table of smaller blocks costs little and saves the steps above them. Counterpart of
// `crates/adumbra/src/layout/depths/top.rs`.

import type { Vec3 } from '../grid/vec3.js';
import { halvesOf } from './bits.js';
import { UNIFORM } from './leaf.js';
import { childrenOf, descend } from './node.js';
import { IN_PAGE, PAGE_LEVEL, blockDims } from './pages.js';
import type { Page } from './pages.js';
import type { Quadtree } from './quadtree.js';

/** Makes the table of blocks for a grid of `size` voxels. `pages` are in rows. */
export function quadtreeOf(size: Vec3, code: Uint32Array, pages: readonly Page[]): Quadtree {
  /** Largest number of blocks of a table that is finer than pages: 64 KiB. */
  const MAX_FINE_BLOCKS = 8192;
  const isSmall = (level: number): boolean => {
    const [across, down] = blockDims(size, level);
    return across * down <= MAX_FINE_BLOCKS;
  };
  const rootLevel = [5, 7].find(isSmall) ?? PAGE_LEVEL;
  const topDims = blockDims(size, rootLevel);
  const [across, down] = topDims;
  const [pagesAcross] = blockDims(size, PAGE_LEVEL);
  const top = new Uint32Array(2 * across * down);
  const children = childrenOf(halvesOf(code));
  const toPage = PAGE_LEVEL - rootLevel;
  for (let y = 0, at = 0; y < down; y++) {
    for (let x = 0; x < across; x++, at += 2) {
      const page = pages[(y >>> toPage) * pagesAcross + (x >>> toPage)];
      top.set(descend(children, [addressOf(page), page.base], PAGE_LEVEL, rootLevel, x << rootLevel, y << rootLevel), at);
    }
  }
  return { rootLevel, topDims, top, code };
}

/** Returns the address in the code of a page's root, or {@link UNIFORM}. */
function addressOf({ root, firstWord }: Page): number {
  return root < IN_PAGE || root === UNIFORM ? root : root - IN_PAGE + 2 * firstWord;
}
