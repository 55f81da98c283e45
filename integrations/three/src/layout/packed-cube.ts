// Validates the nodes of level 3 of a packed graph: 8 × 8 × 8 voxels as the masks at which their layers change.
// Counterpart of `Cube::read` in `crates/adumbra/src/layout/packed/node.rs`.

import { digits, popCount } from './bits.js';
import { badBits, cutOff, packedFault } from './packed-fault.js';
import { LEAF_NODE_LEVEL, inlineMasks } from './packed-node.js';

/** Checks nodes of level 3 and remembers the leaf masks that they name. */
export class CubeReader {
  readonly #units: Uint16Array;
  readonly #leafMasks: Uint32Array;
  readonly #isReached: Uint8Array;
  /** Low and high halves of the voxels that are lit in at least 1, 2, … masks, for nodes of bit planes. */
  readonly #low = new Int32Array(9);
  readonly #high = new Int32Array(9);

  constructor(units: Uint16Array, leafMasks: Uint32Array) {
    this.#units = units;
    this.#leafMasks = leafMasks;
    this.#isReached = new Uint8Array(leafMasks.length >>> 1);
  }

  /** Returns the first leaf mask that no node names, or −1. */
  firstUnreached(): number {
    return this.#isReached.indexOf(0);
  }

  /** Checks the node at `unit` of a pool that ends at `end`. Returns the unit at which the node ends. */
  check(unit: number, end: number): number {
    if (unit >= end) cutOff(unit, LEAF_NODE_LEVEL);
    const header = this.#units[unit];
    const changes = popCount(header & 0xff);
    const count = changes - ((header >>> 8) & 1);
    const here = inlineMasks(header);
    const inPlanes = header >>> 15 === 1;
    if (changes === 0 || (header & 0x1ff) === 0x101 || (inPlanes && here !== 0)) badBits(unit, LEAF_NODE_LEVEL);
    // Bits of missing masks must be zero, except that 6 and 7 share a bit with 5.
    if ((count <= 5 && here >>> count !== 0) || (inPlanes && count === 0)) badBits(unit, LEAF_NODE_LEVEL);
    return inPlanes ? this.#checkPlanes(unit, end, count) : this.#checkMasks(unit, end, count, here);
  }

  #checkPlanes(unit: number, end: number, count: number): number {
    const units = this.#units;
    const low = this.#low.fill(-1);
    const high = this.#high.fill(-1);
    const planes = digits(count);
    let at = unit + 1;
    if (at + 4 * planes > end) cutOff(unit, LEAF_NODE_LEVEL);
    for (let bit = 0; bit < planes; bit++, at += 4) {
      const planeLow = units[at] | (units[at + 1] << 16);
      const planeHigh = units[at + 2] | (units[at + 3] << 16);
      // The entry behind the last mask shows counts above the number of masks.
      for (let i = 0; i <= count; i++) {
        const isSet = ((i + 1) >>> bit) & 1;
        low[i] = isSet ? low[i] & planeLow : low[i] | planeLow;
        high[i] = isSet ? high[i] & planeHigh : high[i] | planeHigh;
      }
    }
    if ((count + 1) >>> planes === 0 && (low[count] | high[count]) !== 0) badBits(unit, LEAF_NODE_LEVEL);
    let lastLow = -1;
    let lastHigh = -1;
    for (let i = 0; i < count; i++) {
      if (!isMixed(low[i], high[i], lastLow, lastHigh)) notMonotone(unit);
      lastLow = low[i];
      lastHigh = high[i];
    }
    return at;
  }

  #checkMasks(unit: number, end: number, count: number, here: number): number {
    const units = this.#units;
    const leafMasks = this.#leafMasks;
    let at = unit + 1;
    let isMonotone = true;
    let lastLow = -1;
    let lastHigh = -1;
    for (let i = 0; i < count; i++) {
      let low: number;
      let high: number;
      if ((here >>> i) & 1) {
        if (at + 4 > end) cutOff(unit, LEAF_NODE_LEVEL);
        low = units[at] | (units[at + 1] << 16);
        high = units[at + 2] | (units[at + 3] << 16);
        at += 4;
      } else {
        if (at >= end) cutOff(unit, LEAF_NODE_LEVEL);
        const place = units[at++];
        if (place >= this.#isReached.length) {
          const count = this.#isReached.length;
          packedFault('LeafMaskRange', `unit ${unit} begins a node that refers to leaf mask ${place}, but there are only ${count}`);
        }
        this.#isReached[place] = 1;
        low = leafMasks[2 * place] | 0;
        high = leafMasks[2 * place + 1] | 0;
      }
      isMonotone &&= isMixed(low, high, lastLow, lastHigh);
      lastLow = low;
      lastHigh = high;
    }
    if (!isMonotone) notMonotone(unit);
    return at;
  }
}

/** Whether a mask has some, but fewer voxels lit than the one before it, and no others. */
function isMixed(low: number, high: number, lastLow: number, lastHigh: number): boolean {
  const isSubset = (low & ~lastLow) === 0 && (high & ~lastHigh) === 0;
  return isSubset && (low | high) !== 0 && (low !== lastLow || high !== lastHigh);
}

function notMonotone(unit: number): never {
  packedFault('LeafMasks', `unit ${unit} begins a node whose leaf masks are not each a proper subset of the one before`);
}
