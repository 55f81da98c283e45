// Validates the nodes of level 3 of a packed graph: 8 × 8 × 8 voxels as the masks at which their layers change.
// Counterpart of `Cube::read` in `crates/adumbra/src/layout/packed/node.rs`.

import { digits, popCount, twoHalves } from './bits.js';
import { badBits, cutOff, packedFault } from './packed-fault.js';
import { inlineMasks, withPlane } from './packed-node.js';

/** Checks nodes of level 3: `check` returns the unit at which the one at `unit`, in a pool that ends at `end`, ends. */
export interface CubeChecks {
  readonly check: (unit: number, end: number) => number;
  /** For each leaf mask, 1 if a node has named it. */
  readonly isReached: Uint8Array;
}

/** Returns the checks of nodes of level 3 in `units`. */
export function cubeChecks(units: Uint16Array, leafMasks: Uint32Array): CubeChecks {
  const isReached = new Uint8Array(leafMasks.length >>> 1);
  /** Low and high halves of the voxels that are lit in at least 1, 2, … masks, for nodes of bit planes. */
  const low = new Uint32Array(9);
  const high = new Uint32Array(9);

  const check = (unit: number, end: number): number => {
    if (unit >= end) cutOff(unit);
    const header = units[unit];
    const changes = popCount(header & 0xff);
    const count = changes - ((header >>> 8) & 1);
    const here = inlineMasks(header);
    const inPlanes = header >>> 15 === 1;
    if (changes === 0 || (header & 0x1ff) === 0x101 || (inPlanes && (here !== 0 || count === 0))) badBits(unit);
    // Bits of missing masks must be zero, except that 6 and 7 share a bit with 5.
    if (count <= 5 && here >>> count !== 0) badBits(unit);
    let at = unit + 1;
    if (inPlanes) {
      const planes = digits(count);
      if (at + 4 * planes > end) cutOff(unit);
      low.fill(-1);
      high.fill(-1);
      for (let bit = 0; bit < planes; bit++, at += 4) {
        // The entry behind the last mask shows counts above the number of masks.
        for (let i = 0; i <= count; i++) {
          low[i] = withPlane(low[i], twoHalves(units, at), (i + 1) >>> bit);
          high[i] = withPlane(high[i], twoHalves(units, at + 2), (i + 1) >>> bit);
        }
      }
      if ((count + 1) >>> planes === 0 && (low[count] | high[count]) !== 0) badBits(unit);
    } else {
      for (let i = 0; i < count; i++) {
        if ((here >>> i) & 1) {
          if (at + 4 > end) cutOff(unit);
          low[i] = twoHalves(units, at);
          high[i] = twoHalves(units, at + 2);
          at += 4;
        } else {
          if (at >= end) cutOff(unit);
          const place = units[at++];
          if (place >= isReached.length) {
            packedFault('LeafMaskRange', `the node at unit ${unit} refers to leaf mask ${place}, but there are only ${isReached.length}`);
          }
          isReached[place] = 1;
          low[i] = leafMasks[2 * place];
          high[i] = leafMasks[2 * place + 1];
        }
      }
    }
    let lastLow = -1;
    let lastHigh = -1;
    for (let i = 0; i < count; i++) {
      const nextLow = low[i] | 0;
      const nextHigh = high[i] | 0;
      // Each mask has some, but fewer voxels lit than the one before it, and no others.
      const isSubset = (nextLow & ~lastLow) === 0 && (nextHigh & ~lastHigh) === 0;
      if (!isSubset || (nextLow | nextHigh) === 0 || (nextLow === lastLow && nextHigh === lastHigh)) {
        packedFault('LeafMasks', `the node at unit ${unit} has a leaf mask that is no proper subset of the one before`);
      }
      lastLow = nextLow;
      lastHigh = nextHigh;
    }
    return at;
  };

  return { check, isReached };
}
