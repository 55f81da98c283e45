// Look-ups in the packed layout: a graph in units of 16 bits. `spec/adumbra-file.md`, "Look-up of a point", has the steps
// and their names.

import type { BakedShadowFile } from '../file/shadow-file.js';
import { bitsBelow, digits, popCount } from '../layout/bits.js';
import {
  LEAF_NODE_LEVEL,
  NEAR_UNITS,
  NO_FOLLOWER,
  POOL_WORDS,
  highBits,
  inlineMasks,
  pointersIn,
  stringUnits,
} from '../layout/packed-node.js';
import { GraphVoxels, LIT, SHADOWED } from './graph-voxels.js';

/** Look-ups in a file of the packed layout. */
export class PackedVoxels extends GraphVoxels {
  readonly #file: BakedShadowFile;
  readonly #units: Uint16Array;

  constructor(file: BakedShadowFile) {
    super();
    this.#file = file;
    this.#units = new Uint16Array(file.nodes.buffer, file.nodes.byteOffset, 2 * file.nodes.length);
  }

  protected findNode(x: number, y: number, z: number): number {
    const { top, rootLevel, topDims } = this.#file;
    const units = this.#units;
    const column = POOL_WORDS + 2 * ((y >>> rootLevel) * topDims[0] + (x >>> rootLevel));
    const z0 = top[column + 1];
    const rootZ = z >>> rootLevel;
    if (rootZ < z0) return LIT;
    const root = top[column] + rootZ - z0;
    if (root >= top[column + 2]) return SHADOWED;
    const rootsAt = POOL_WORDS + 2 * topDims[0] * topDims[1] + 1;
    let at = top[rootLevel - LEAF_NODE_LEVEL] + top[rootsAt + root];

    for (let bit = rootLevel - 1; bit >= LEAF_NODE_LEVEL; bit--) {
      const shift = 3 * ((((x >>> bit) & 1) << 1) | ((y >>> bit) & 1));
      const isFar = ((z >>> bit) & 1) === 1;
      const header = units[at];
      const code = (header >>> shift) & 7;
      if (code === 0 || (isFar && (code === 2 || code === 5))) return SHADOWED;
      if (code === 1 || (!isFar && (code === 2 || code === 4))) return LIT;
      const pointer = pointersIn(header & bitsBelow(shift)) + (code === 3 && isFar ? 1 : 0);

      const pool = top[bit - LEAF_NODE_LEVEL];
      let slotsAt = at + 1;
      let wide = 0;
      let high = 0;
      if (header >>> 15 === 1) {
        const width = highBits(top[bit - LEAF_NODE_LEVEL + 1] - pool);
        wide = units[at + 1] & 0xff;
        slotsAt += stringUnits(wide, width);
        const place = Math.max(width, 8) + width * popCount(wide & bitsBelow(pointer));
        high = (units[at + 1 + (place >>> 4)] >>> (place & 15)) & bitsBelow(width);
      }
      const follower = (header >>> 12) & 7;
      const slotsEnd = slotsAt + pointersIn(header & 0xfff) - (follower === NO_FOLLOWER ? 0 : 1);
      // Pointer 7 is never the follower, because that value of the field means that there is none.
      if (pointer === follower && pointer !== NO_FOLLOWER) {
        at = slotsEnd;
        continue;
      }
      const value = units[slotsAt + pointer - (pointer > follower ? 1 : 0)];
      if (((wide >>> pointer) & 1) === 1) at = pool + high * 65536 + value;
      else at = value < NEAR_UNITS ? slotsEnd + value : pool + value - NEAR_UNITS;
    }
    return at;
  }

  protected readLeafMask(node: number, layer: number): void {
    const header = this.#units[node];
    const changes = popCount(header & 0xff);
    const isDark = (header >>> 8) & 1;
    const change = popCount(header & bitsBelow(layer + 1) & 0xff);
    if (change === 0 || (change === changes && isDark === 1)) {
      this.low = this.high = change === 0 ? -1 : 0;
      return;
    }
    if (header >>> 15 === 1) {
      this.#readPlanes(node + 1, digits(changes - isDark), change);
      return;
    }
    const mask = change - 1;
    const here = inlineMasks(header);
    const at = node + 1 + mask + 3 * popCount(here & bitsBelow(mask));
    if (((here >>> mask) & 1) === 1) {
      this.low = this.#two(at);
      this.high = this.#two(at + 2);
    } else {
      const place = 2 * this.#units[at];
      this.low = this.#file.leafMasks[place];
      this.high = this.#file.leafMasks[place + 1];
    }
  }

  /** Sets the leaf mask to the voxels that are lit in at least `change` masks. */
  #readPlanes(at: number, planes: number, change: number): void {
    this.low = this.high = -1;
    for (let bit = 0; bit < planes; bit++) {
      const low = this.#two(at + 4 * bit);
      const high = this.#two(at + 4 * bit + 2);
      const isSet = ((change >>> bit) & 1) === 1;
      this.low = isSet ? this.low & low : this.low | low;
      this.high = isSet ? this.high & high : this.high | high;
    }
  }

  #two(at: number): number {
    return this.#units[at] | (this.#units[at + 1] << 16);
  }
}
