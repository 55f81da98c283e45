// Look-ups in the layout depths: a quadtree of the depths at which columns switch from lit to shadowed.
// `spec/adumbra-file.md`, "Look-up of a point", has the steps and their names.

import type { BakedShadowFile } from '../file/shadow-file.js';
import { popCount } from '../layout/bits.js';
import { NEVER, UNIFORM, leafHead } from '../layout/depths-leaf.js';
import type { LeafHead } from '../layout/depths-leaf.js';
import type { Voxels } from './voxels.js';

/** Look-ups in a file of the layout depths. */
export class DepthsVoxels implements Voxels {
  readonly #file: BakedShadowFile;
  readonly #code: Uint16Array;
  #x = -1;
  #y = -1;
  /** Address of the last leaf, or {@link UNIFORM}. */
  #at = UNIFORM;
  #base = NEVER;
  #head: LeafHead = leafHead(0);

  constructor(file: BakedShadowFile) {
    this.#file = file;
    this.#code = new Uint16Array(file.nodes.buffer, file.nodes.byteOffset, 2 * file.nodes.length);
  }

  isLit(x: number, y: number, z: number): boolean {
    const blockX = x >>> 3;
    const blockY = y >>> 3;
    if (blockX !== this.#x || blockY !== this.#y) {
      this.#x = blockX;
      this.#y = blockY;
      this.#findBlock(x, y);
    }
    return z < (this.#at === UNIFORM ? this.#base : this.#depth(x & 7, y & 7));
  }

  /** Descends to the block or leaf that contains a column. */
  #findBlock(x: number, y: number): void {
    const { top, leafMasks: wide, rootLevel, topDims } = this.#file;
    const code = this.#code;
    const root = 2 * ((y >>> rootLevel) * topDims[0] + (x >>> rootLevel));
    let at = top[root];
    let base = top[root + 1];
    let delta = 0;
    for (let level = rootLevel - 2; at !== UNIFORM && level >= 3; level -= 2) {
      const child = (((y >>> level) & 3) << 2) | ((x >>> level) & 3);
      const below = (1 << child) - 1;
      const low = code[at];
      const high = code[at + 1];
      const field = at + 3 + popCount(low & below) + 2 * popCount(high & below);
      const size = ((low >>> child) & 1) | (((high >>> child) & 1) << 1);
      const isKind = ((code[at + 2] >>> child) & 1) === 1;
      delta = 0;
      if (size === 0) {
        at = UNIFORM;
        if (isKind) base = NEVER;
      } else if (size === 3 && isKind) {
        const entry = 2 * this.#two(field);
        delta = wide[entry];
        at = wide[entry + 1];
      } else if (isKind) {
        // A signed half-word.
        delta = (code[field] << 16) >> 16;
        at = size === 1 ? UNIFORM : this.#near(at, field + 1);
      } else if (size === 3) {
        delta = (code[field] << 16) >> 16;
        at = this.#two(field + 1);
      } else {
        at = size === 1 ? this.#near(at, field) : this.#two(field);
      }
      base = (base + delta) >>> 0;
    }
    this.#at = at;
    this.#base = base;
    if (at !== UNIFORM) this.#head = leafHead(code[at]);
  }

  /** Returns the depth at which a column of the leaf switches; `x` and `y` are 0 to 7. */
  #depth(x: number, y: number): number {
    const code = this.#code;
    const at = this.#at;
    const { differences, width, isSlanted, differencesAt, planesAt, planes } = this.#head;
    const column = 8 * y + x;
    const plane = at + planesAt + (column >>> 4);
    let rank = 0;
    for (let p = 0; p < planes; p++) rank |= ((code[plane + 4 * p] >>> (column & 15)) & 1) << p;
    if (rank > differences) return NEVER;

    const first = at + differencesAt;
    let depth = this.#base;
    for (let i = 0; i < rank; i++) {
      if (width === 0) depth += (code[first + (i >>> 1)] >>> (8 * (i & 1))) & 0xff;
      else depth += width === 1 ? code[first + i] : this.#two(first + 2 * i);
    }
    depth = Math.min(depth, NEVER);
    return isSlanted ? Math.max(depth - rise(code[at + 1], x, y), 0) : depth;
  }

  #near(at: number, field: number): number {
    const half = this.#code[field];
    return half < 32768 ? half : at - (half - 32768);
  }

  #two(at: number): number {
    return (this.#code[at] | (this.#code[at + 1] << 16)) >>> 0;
  }
}

/** Returns by how much a column switches nearer to the sun than the deepest corner of its plane, voxels. */
function rise(gradient: number, x: number, y: number): number {
  const gx = (gradient << 24) >> 24;
  const gy = (gradient << 16) >> 24;
  const along = (g: number, c: number): number => Math.abs(g) * (g > 0 ? 7 - c : c);
  return (along(gx, x) + along(gy, y) + 3) >> 2;
}
