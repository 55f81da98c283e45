// Look-ups in the plain layout: a graph of 32-bit headers and pointers. `spec/adumbra-file.md`, "Look-up of a point".

import type { BakedShadowFile } from '../file/shadow-file.js';
import { bitsBelow, popCount } from '../layout/bits.js';
import { LIT, SHADOWED, graphVoxels } from './graph-voxels.js';
import type { Voxels } from './voxels.js';

/** Returns the look-up of a file of the plain layout. */
export function plainVoxels({ top, nodes, leafMasks, rootLevel, topDims }: BakedShadowFile): Voxels {
  return graphVoxels(
    (x, y, z) => {
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
    },
    (node, layer, set) => {
      const header = nodes[node];
      const state = (header >>> (2 * layer)) & 3;
      const leafMask = 2 * nodes[node + 1 + mixedBefore(header, layer)];
      if (state < 2) set(-state, -state);
      else set(leafMasks[leafMask], leafMasks[leafMask + 1]);
    },
  );
}

/** Returns the number of mixed children before `child`. */
function mixedBefore(header: number, child: number): number {
  return popCount(header & bitsBelow(2 * child) & 0xaaaa);
}
