// The table of blocks at which look-ups begin. A file has one root per page, 512 × 512 columns. Where the
// grid is small, a table of smaller blocks costs little and saves the steps above them. Counterpart of
// `crates/adumbra/src/layout/depths/top.rs`.

import type { Vec3 } from '../grid/vec3.js';
import { halvesOf } from './bits.js';
import { UNIFORM } from './leaf.js';
import { childrenOf, descend } from './node.js';
import { IN_PAGE, PAGE_LEVEL, blockDims } from './pages.js';
import type { Dims, Page } from './pages.js';
import type { Quadtree } from './quadtree.js';

/** Returns the level of the blocks at which look-ups in a grid of `size` voxels begin: 5, 7 or 9. */
export function rootLevelOf(size: Vec3): number {
  /** Largest number of blocks of a table that is finer than pages: 64 KiB. */
  const MAX_FINE_BLOCKS = 8192;
  const isSmall = (level: number): boolean => {
    const [across, down] = blockDims(size, level);
    return across * down <= MAX_FINE_BLOCKS;
  };
  return [5, 7].find(isSmall) ?? PAGE_LEVEL;
}

/** Visits the blocks of page (pageX, pageY) that are in a table, with the column at which each begins and its first word there. */
export function forEachBlock(rootLevel: number, [across, down]: Dims, pageX: number, pageY: number, visit: (x: number, y: number, at: number) => void): void {
  const side = 1 << (PAGE_LEVEL - rootLevel);
  for (let y = side * pageY; y < Math.min(side * (pageY + 1), down); y++) {
    for (let x = side * pageX; x < Math.min(side * (pageX + 1), across); x++) visit(x << rootLevel, y << rootLevel, 2 * (y * across + x));
  }
}

/** Makes the table of blocks for a grid of `size` voxels. `pages` are in rows. */
export function quadtreeOf(size: Vec3, code: Uint32Array, pages: readonly Page[]): Quadtree {
  const rootLevel = rootLevelOf(size);
  const topDims = blockDims(size, rootLevel);
  const [pagesAcross] = blockDims(size, PAGE_LEVEL);
  const top = new Uint32Array(2 * topDims[0] * topDims[1]);
  const children = childrenOf(halvesOf(code));
  pages.forEach((page, i) => {
    forEachBlock(rootLevel, topDims, i % pagesAcross, Math.floor(i / pagesAcross), (x, y, at) => {
      top.set(descend(children, [addressOf(page), page.base], PAGE_LEVEL, rootLevel, x, y), at);
    });
  });
  return { rootLevel, topDims, top, code };
}

/** Returns the address in the code of a page's root, or {@link UNIFORM}. */
export function addressOf({ root, firstWord }: Pick<Page, 'root' | 'firstWord'>): number {
  return root < IN_PAGE || root === UNIFORM ? root : root - IN_PAGE + 2 * firstWord;
}
