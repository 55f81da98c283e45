// Pages and bundles: how a quadtree is cut into parts, and in which order they are stored. A page is a square
// of 512 × 512 columns, and the shapes below its root. A bundle is 4 × 4 pages. Counterpart of
// `crates/adumbra/src/layout/depths/page.rs`; `spec/adumbra-file.md` has the curve.

import type { Vec3 } from '../grid/vec3.js';
import { UNIFORM } from './leaf.js';

/** A page spans 2^9 columns along each side. */
export const PAGE_LEVEL = 9;
/** Number of pages along each side of a bundle. */
export const BUNDLE_SIDE = 4;
/** Number of pages of a bundle. */
export const BUNDLE_PAGES = 16;
/** Bit of a page's root: the address counts half-words from the page's beginning. */
export const IN_PAGE = 2 ** 31;

/** A page of a level. */
export interface Page {
  /** Address of its root in the common section, with {@link IN_PAGE} in the page, or {@link UNIFORM}. */
  readonly root: number;
  /** Base of the root. */
  readonly base: number;
  /** Index of its first word in the code. */
  readonly firstWord: number;
  /** Number of its words. */
  readonly words: number;
}

/** Numbers along x and y. */
export type Dims = readonly [x: number, y: number];

/** Returns the number of blocks of 2^level columns a side along x and y that cover `size` voxels. */
export function blockDims([x, y]: Vec3, level: number): Dims {
  return [Math.ceil(x / 2 ** level), Math.ceil(y / 2 ** level)];
}

/** Returns the number of bundles along x and y that cover `size` voxels. */
export function bundleDims(size: Vec3): Dims {
  return blockDims(size, PAGE_LEVEL + 2);
}

/** Returns the places of bundles along x and y in the order of a Hilbert curve. */
export function bundleOrder([across, down]: Dims): Dims[] {
  const order: Dims[] = [];
  /** Follows the curve through the square at corner o with the edges u and v, which may point backwards. */
  const curve = (ox: number, oy: number, ux: number, uy: number, vx: number, vy: number): void => {
    const x = ox + Math.min(ux, 0) + Math.min(vx, 0);
    const y = oy + Math.min(uy, 0) + Math.min(vy, 0);
    if (x >= across || y >= down) return;
    if (Math.abs(ux + uy) === 1) {
      order.push([x, y]);
      return;
    }
    const [hux, huy, hvx, hvy] = [ux / 2, uy / 2, vx / 2, vy / 2];
    curve(ox, oy, hvx, hvy, hux, huy);
    curve(ox + hux, oy + huy, hux, huy, hvx, hvy);
    curve(ox + hux + hvx, oy + huy + hvy, hux, huy, hvx, hvy);
    curve(ox + hux + vx, oy + huy + vy, -hvx, -hvy, -hux, -huy);
  };
  let side = 1;
  while (side < across || side < down) side *= 2;
  curve(0, 0, side, 0, 0, side);
  return order;
}

/** Whether all columns of a page switch at `base`, and it is stored as such. */
export function isUniform(page: Page, base: number): boolean {
  return page.root === UNIFORM && page.base === base && page.words === 0;
}
