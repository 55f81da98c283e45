// Look-ups of voxels in the quadtree. `spec/adumbra-file.md`, "Look-up of a point", has the steps and their names.

import { bitsBelow, halvesOf, popCount, twoHalves } from './bits.js';
import { NEVER, UNIFORM, leafHead } from './leaf.js';
import type { Quadtree } from './quadtree.js';

/**
 * Returns whether voxel (x, y, z), which must be in the grid, is lit. It remembers the block of its last look-up, so that
 * look-ups close to each other cost less.
 */
export type Voxels = (x: number, y: number, z: number) => boolean;

/** Returns the look-up of voxels in a quadtree. */
export function voxelsOf({ top, nodes, leafMasks: wide, rootLevel, topDims }: Quadtree): Voxels {
  const code = halvesOf(nodes);
  let lastX = -1;
  let lastY = -1;
  /** Address of the last leaf, or {@link UNIFORM}. */
  let at = UNIFORM;
  let base = NEVER;
  let head = leafHead(0);

  /** Returns the address in a half-word, which may be a distance from the node at `at`. */
  const near = (field: number): number => {
    const half = code[field];
    return half < 32768 ? half : at - (half - 32768);
  };

  /** Descends to the block or leaf that contains a column. */
  const findBlock = (x: number, y: number): void => {
    const root = 2 * ((y >>> rootLevel) * topDims[0] + (x >>> rootLevel));
    at = top[root];
    base = top[root + 1];
    for (let level = rootLevel - 2; at !== UNIFORM && level >= 3; level -= 2) {
      const child = (((y >>> level) & 3) << 2) | ((x >>> level) & 3);
      const below = bitsBelow(child);
      const low = code[at];
      const high = code[at + 1];
      const field = at + 3 + popCount(low & below) + 2 * popCount(high & below);
      const size = ((low >>> child) & 1) | (((high >>> child) & 1) << 1);
      const isKind = ((code[at + 2] >>> child) & 1) === 1;
      // A signed half-word.
      let delta = (code[field] << 16) >> 16;
      if (size === 0) {
        at = UNIFORM;
        delta = 0;
        if (isKind) base = NEVER;
      } else if (size === 3 && isKind) {
        const entry = 2 * twoHalves(code, field);
        delta = wide[entry];
        at = wide[entry + 1];
      } else if (isKind) {
        at = size === 1 ? UNIFORM : near(field + 1);
      } else if (size === 3) {
        at = twoHalves(code, field + 1);
      } else {
        delta = 0;
        at = size === 1 ? near(field) : twoHalves(code, field);
      }
      base = (base + delta) >>> 0;
    }
    if (at !== UNIFORM) head = leafHead(code[at]);
  };

  /** Returns the depth at which a column of the leaf switches; `x` and `y` are 0 to 7. */
  const depthOf = (x: number, y: number): number => {
    const [, differences, width, isSlanted, differencesAt, planesAt, planes] = head;
    const column = 8 * y + x;
    const plane = at + planesAt + (column >>> 4);
    let rank = 0;
    for (let p = 0; p < planes; p++) rank |= ((code[plane + 4 * p] >>> (column & 15)) & 1) << p;
    if (rank > differences) return NEVER;

    const first = at + differencesAt;
    let depth = base;
    for (let i = 0; i < rank; i++) {
      if (width === 0) depth += (code[first + (i >>> 1)] >>> (8 * (i & 1))) & 0xff;
      else depth += width === 1 ? code[first + i] : twoHalves(code, first + 2 * i);
    }
    depth = Math.min(depth, NEVER);
    return isSlanted ? Math.max(depth - rise(code[at + 1], x, y), 0) : depth;
  };

  return (x, y, z) => {
    const blockX = x >>> 3;
    const blockY = y >>> 3;
    if (blockX !== lastX || blockY !== lastY) {
      lastX = blockX;
      lastY = blockY;
      findBlock(x, y);
    }
    return z < (at === UNIFORM ? base : depthOf(x & 7, y & 7));
  };
}

/** Returns by how much a column switches nearer to the sun than the deepest corner of its plane, voxels. */
function rise(gradient: number, x: number, y: number): number {
  const along = (g: number, c: number): number => Math.abs(g) * (g > 0 ? 7 - c : c);
  return (along((gradient << 24) >> 24, x) + along((gradient << 16) >> 24, y) + 3) >> 2;
}
