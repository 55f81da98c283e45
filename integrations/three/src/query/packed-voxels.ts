// Look-ups in the packed layout: a graph in units of 16 bits. `spec/adumbra-file.md`, "Look-up of a point", has the steps
// and their names.

import type { BakedShadowFile } from '../file/shadow-file.js';
import { bitsBelow, digits, halvesOf, popCount, twoHalves } from '../layout/bits.js';
import {
  LEAF_NODE_LEVEL,
  NEAR_UNITS,
  NO_FOLLOWER,
  POOL_WORDS,
  highBits,
  highPart,
  inlineMasks,
  pointersIn,
  rootsWord,
  stringUnits,
  withPlane,
} from '../layout/packed-node.js';
import { LIT, SHADOWED, graphVoxels } from './graph-voxels.js';
import type { Voxels } from './voxels.js';

/** Returns the look-up of a file of the packed layout. */
export function packedVoxels({ top, nodes, leafMasks, rootLevel, topDims }: BakedShadowFile): Voxels {
  const units = halvesOf(nodes);
  const rootsAt = rootsWord(topDims);
  return graphVoxels(
    (x, y, z) => {
      const column = POOL_WORDS + 2 * ((y >>> rootLevel) * topDims[0] + (x >>> rootLevel));
      const z0 = top[column + 1];
      const rootZ = z >>> rootLevel;
      if (rootZ < z0) return LIT;
      const root = top[column] + rootZ - z0;
      if (root >= top[column + 2]) return SHADOWED;
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
          wide = units[slotsAt] & 0xff;
          high = highPart(units, at, Math.max(width, 8) + width * popCount(wide & bitsBelow(pointer)), width);
          slotsAt += stringUnits(wide, width);
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
    },
    (node, layer, set) => {
      const header = units[node];
      const changes = popCount(header & 0xff);
      const isDark = (header >>> 8) & 1;
      const change = popCount(header & bitsBelow(layer + 1) & 0xff);
      let at = node + 1;
      if (change === 0) set(-1, -1);
      else if (change === changes && isDark === 1) set(0, 0);
      else if (header >>> 15 === 1) {
        // The voxels that are lit in at least `change` masks.
        let low = -1;
        let high = -1;
        for (let bit = 0, planes = digits(changes - isDark); bit < planes; bit++, at += 4) {
          low = withPlane(low, twoHalves(units, at), change >>> bit);
          high = withPlane(high, twoHalves(units, at + 2), change >>> bit);
        }
        set(low, high);
      } else {
        const mask = change - 1;
        const here = inlineMasks(header);
        at += mask + 3 * popCount(here & bitsBelow(mask));
        const place = 2 * units[at];
        if (((here >>> mask) & 1) === 1) set(twoHalves(units, at), twoHalves(units, at + 2));
        else set(leafMasks[place], leafMasks[place + 1]);
      }
    },
  );
}
