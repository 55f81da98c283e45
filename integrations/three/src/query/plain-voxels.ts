// Look-ups in the plain layout: a graph of 32-bit headers and pointers. `spec/adumbra-file.md`, "Look-up of a point".

import type { BakedShadowFile } from '../file/shadow-file.js';
import { popCount } from '../layout/bits.js';
import { GraphVoxels, LIT, SHADOWED } from './graph-voxels.js';

/** Look-ups in a file of the plain layout. */
export class PlainVoxels extends GraphVoxels {
  readonly #file: BakedShadowFile;

  constructor(file: BakedShadowFile) {
    super();
    this.#file = file;
  }

  protected findNode(x: number, y: number, z: number): number {
    const { top, nodes, rootLevel, topDims } = this.#file;
    let node = top[((z >>> rootLevel) * topDims[1] + (y >>> rootLevel)) * topDims[0] + (x >>> rootLevel)];
    if (node === 0xffffffff) return LIT;
    if (node === 0xfffffffe) return SHADOWED;
    for (let bit = rootLevel - 1; bit >= 3; bit--) {
      const child = (((x >>> bit) & 1) << 2) | (((y >>> bit) & 1) << 1) | ((z >>> bit) & 1);
      const header = nodes[node];
      const state = (header >>> (2 * child)) & 3;
      if (state < 2) return state === 1 ? LIT : SHADOWED;
      node = nodes[node + 1 + mixedBefore(header, child)];
    }
    return node;
  }

  protected readLeafMask(node: number, layer: number): void {
    const { nodes, leafMasks } = this.#file;
    const header = nodes[node];
    const state = (header >>> (2 * layer)) & 3;
    if (state < 2) {
      this.low = this.high = -state;
      return;
    }
    const leafMask = 2 * nodes[node + 1 + mixedBefore(header, layer)];
    this.low = leafMasks[leafMask];
    this.high = leafMasks[leafMask + 1];
  }
}

/** Returns the number of mixed children before `child`. */
function mixedBefore(header: number, child: number): number {
  return popCount(header & ((1 << (2 * child)) - 1) & 0xaaaa);
}
