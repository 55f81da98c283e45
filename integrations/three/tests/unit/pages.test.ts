// The order of bundles, and the table of blocks at which look-ups begin.

import { describe, expect, it } from 'vitest';

import { toWorld } from '../../src/grid/light-grid.js';
import { BakedShadowFile, Sampler } from '../../src/index.js';
import type { Vec3 } from '../../src/index.js';
import { halvesOf } from '../../src/quadtree/bits.js';
import { NEVER, UNIFORM } from '../../src/quadtree/leaf.js';
import { childrenOf, descend } from '../../src/quadtree/node.js';
import { IN_PAGE, PAGE_LEVEL, bundleOrder } from '../../src/quadtree/pages.js';
import type { Dims, Page } from '../../src/quadtree/pages.js';
import { quadtreeOf } from '../../src/quadtree/top.js';
import { rangeOf } from '../../src/quadtree/validate.js';
import { validBytes } from './vectors.js';

describe('bundles', () => {
  it('have the order of the worked value', () => {
    expect(bundleOrder([2, 2])).toEqual([[0, 0], [1, 0], [1, 1], [0, 1]]);
  });

  it('of a square follow each other side by side', () => {
    const order = bundleOrder([16, 16]);
    order.slice(1).forEach(([x, y], i) => expect(Math.abs(x - order[i]![0]) + Math.abs(y - order[i]![1])).toBe(1));
  });

  it.each<Dims>([[1, 1], [2, 1], [1, 100], [16, 16], [16, 5], [3, 7]])('of a grid of %i × %i are each visited once', (across, down) => {
    const order = bundleOrder([across, down]);
    expect(order.length).toBe(across * down);
    expect(new Set(order.map((place) => place.join())).size).toBe(across * down);
    expect(order.every(([x, y]) => x >= 0 && x < across && y >= 0 && y < down)).toBe(true);
  });

  it('of a narrow grid are found without visiting the square around', () => {
    expect(bundleOrder([2 ** 20, 1]).length).toBe(2 ** 20);
  });
});

describe('the table of blocks', () => {
  /** Pages that each switch at their own number. */
  const numbered = (count: number): Page[] => Array.from({ length: count }, (_, base) => ({ root: UNIFORM, base, firstWord: 0, words: 0 }));

  it.each<[Vec3, number, Dims]>([
    [[1, 1, 1], 5, [1, 1]],
    [[1024, 8192, 9], 5, [32, 256]],
    [[1025, 8192, 9], 7, [9, 64]],
    [[16384, 8192, 9], 7, [128, 64]],
    [[16385, 8192, 9], 9, [33, 16]],
    [[65536, 65536, 9], 9, [128, 128]],
  ])('of %j has the level %i and %j blocks', (size, rootLevel, topDims) => {
    const pagesAcross = Math.ceil(size[0] / 512);
    const tree = quadtreeOf(size, new Uint32Array(0), numbered(pagesAcross * Math.ceil(size[1] / 512)));
    expect(tree).toMatchObject({ rootLevel, topDims });
    expect(tree.top.length).toBe(2 * topDims[0] * topDims[1]);
    // Each block has the depth of its page.
    const blocksPerPage = 2 ** (PAGE_LEVEL - rootLevel);
    for (let block = 0; block < topDims[0] * topDims[1]; block++) {
      const x = Math.floor((block % topDims[0]) / blocksPerPage);
      const y = Math.floor(Math.floor(block / topDims[0]) / blocksPerPage);
      expect([...tree.top.subarray(2 * block, 2 * block + 2)]).toEqual([UNIFORM, y * pagesAcross + x]);
    }
  });

  it('counts roots within a page from the beginning of the code', () => {
    const pages: Page[] = [
      { root: IN_PAGE + 3, base: 7, firstWord: 5, words: 4 },
      { root: 3, base: 8, firstWord: 9, words: 0 },
    ];
    // So large that blocks are pages.
    const { top } = quadtreeOf([1024, 2 ** 23, 9], new Uint32Array(20), [...pages, ...numbered(2 ** 15 - 2)]);
    expect([...top.subarray(0, 4)]).toEqual([13, 7, 3, 8]);
  });

  it.each(['levels_depths', 'many_pages_depths', 'slopes_depths'])('changes no answer of %s', (name) => {
    const file = new BakedShadowFile(validBytes(name));
    expect(file.rootLevel).toBe(5);
    const children = childrenOf(halvesOf(file.code));
    for (let at = 0; at < file.top.length; at += 2) {
      const block = at / 2;
      const [x, y] = [32 * (block % file.topDims[0]), 32 * Math.floor(block / file.topDims[0])];
      const [leaf, base] = descend(children, [file.top[at]!, file.top[at + 1]!], 5, 3, x, y);
      if (leaf !== UNIFORM) continue;
      const isLit = (k: number): number => {
        const [worldX, worldY, worldZ] = toWorld(file.grid, [x + 0.5, y + 0.5, k + 0.5]);
        return new Sampler(file, { filter: 1 }).pointVisibility({ x: worldX, y: worldY, z: worldZ });
      };
      if (x < file.grid.size[0] && y < file.grid.size[1]) {
        for (const k of [base - 1, base].filter((depth) => depth >= 0 && depth < file.grid.size[2])) {
          expect(isLit(k)).toBe(Number(k < base));
        }
      }
    }
  });
});

it('pages that never switch do not count for the farthest depth', () => {
  expect(rangeOf([[NEVER, NEVER, true], [3, 9, false]])).toEqual([3, 9, true]);
  expect(rangeOf([[5, 5, false], [0, 0, false]])).toEqual([0, 5, false]);
  expect(rangeOf([[NEVER, NEVER, true]])).toEqual([NEVER, NEVER, true]);
});
