// Validates a graph of the packed layout: every pointer leads to a node of the level below, every unit belongs to one
// node, and everything is reached. Counterpart of `crates/adumbra/src/layout/packed/validate.rs`.
//
// A node's pool pointers lead to a pool that was read before its own, and the nodes inside another follow its slots one
// behind the other, so one pass from the first unit to the last proves it.

import type { BakedShadowFile } from '../file/shadow-file.js';
import { bitsBelow, halvesOf } from './bits.js';
import { cubeChecks } from './packed-cube.js';
import { badBits, cutOff, packedFault } from './packed-fault.js';
import {
  LEAF_NODE_LEVEL,
  NEAR_UNITS,
  NO_FOLLOWER,
  highBits,
  highPart,
  pointersIn,
  rootsWord,
  stringUnits,
} from './packed-node.js';
import { validatePackedTop } from './validate-packed-top.js';

/**
 * Checks the words of a file of the packed layout. Cost: one pass over them, and one byte of memory per unit.
 *
 * @throws ShadowFileError of the kind `Packed`.
 */
export function validatePacked(file: BakedShadowFile): void {
  validatePackedTop(file);
  /** Number of units at the start of a pool that narrow slots can address. */
  const NARROW_POOL_UNITS = 65536 - NEAR_UNITS;
  /** Bits of a unit in `marks`: a node of a pool begins there; a pointer leads there. */
  const BEGINS = 1;
  const REACHED = 2;
  /** In place of a number of pointers: codes that no node has. */
  const INVALID = 255;
  const { top, nodes, leafMasks, topDims, rootLevel } = file;
  const units = halvesOf(nodes);
  const marks = new Uint8Array(units.length);
  const cubes = cubeChecks(units, leafMasks);
  /** Number of pointers of a node with these codes. */
  const pointersOf = Uint8Array.from({ length: 4096 }, (_, codes) => {
    // 7 is the only code with all three bits set. A node with one state belongs into its parent.
    const isInvalid = (codes & (codes >>> 1) & (codes >>> 2) & 0o1111) !== 0;
    return isInvalid || codes === 0 || codes === 0o1111 ? INVALID : pointersIn(codes);
  });
  /** Distances to the children inside a node, sorted; up to eight for each level. */
  const inside = new Uint16Array(8 * (rootLevel + 1));

  /** Returns the first unit of a level's pool, which is the end of the pool of the level below. */
  const pool = (level: number): number => top[level - LEAF_NODE_LEVEL];

  const reach = (pointer: number, level: number, from: string, index: number): void => {
    const at = pool(level) + pointer;
    if (at >= pool(level + 1) || (marks[at] & BEGINS) === 0) {
      packedFault('Pointer', `${from} ${index} leads to unit ${pointer} of the pool of level ${level}, where no node begins`);
    }
    marks[at] |= REACHED;
  };

  /** Checks the node at `unit` with all nodes inside it. Returns the unit at which it ends. */
  const check = (unit: number, end: number, level: number): number => {
    if (level === LEAF_NODE_LEVEL) return cubes.check(unit, end);
    if (unit >= end) cutOff(unit);
    const header = units[unit];
    const pointers = pointersOf[header & 0xfff];
    const field = (header >>> 12) & 7;
    const hasFollower = field !== NO_FOLLOWER;
    // Pointer 7 is never the follower.
    const follower = hasFollower ? field : -1;
    if (pointers === INVALID || follower >= pointers) badBits(unit);
    let wide = 0;
    let bits = 0;
    let slot = unit + 1;
    let at = slot + pointers - (hasFollower ? 1 : 0);
    if (header >>> 15 === 1) {
      if (slot >= end) cutOff(unit);
      const front = units[slot];
      wide = front & 0xff;
      bits = highBits(pool(level) - pool(level - 1));
      const slotted = bitsBelow(pointers) & ~(hasFollower ? 1 << follower : 0);
      if (wide === 0 || (wide & ~slotted) !== 0 || (bits === 16 && front > 0xff)) badBits(unit);
      slot += stringUnits(wide, bits);
      at += slot - unit - 1;
    }
    if (at > end) cutOff(unit);

    // Wide pointers need their high parts, and zeros follow those.
    let place = Math.max(bits, 8);
    for (let p = 0, slotAt = slot; wide >>> p !== 0; p++) {
      if (p === follower) continue;
      if (((wide >>> p) & 1) === 1) {
        if (highPart(units, unit, place, bits) * 65536 + units[slotAt] < NARROW_POOL_UNITS) badBits(unit);
        place += bits;
      }
      slotAt++;
    }
    if (wide !== 0 && (place & 15) !== 0 && units[slot - 1] >>> (place & 15) !== 0) badBits(unit);

    const first = 8 * level;
    let last = first;
    place = Math.max(bits, 8);
    for (let p = 0; p < pointers; p++) {
      const value = p === follower ? 0 : units[slot++];
      if (((wide >>> p) & 1) === 1) {
        reach(highPart(units, unit, place, bits) * 65536 + value, level - 1, 'unit', unit);
        place += bits;
      } else if (value < NEAR_UNITS) {
        // Inserted where it belongs.
        let i = last++;
        for (; i > first && inside[i - 1] > value; i--) inside[i] = inside[i - 1];
        inside[i] = value;
      } else reach(value - NEAR_UNITS, level - 1, 'unit', unit);
    }
    const slotsEnd = at;
    for (let i = first; i < last; i++) {
      if (inside[i] !== at - slotsEnd) {
        packedFault('Order', `the node at unit ${unit} has a child ${inside[i]} units after its slots instead of ${at - slotsEnd}`);
      }
      at = check(at, end, level - 1);
    }
    return at;
  };

  for (let level = LEAF_NODE_LEVEL; level <= rootLevel; level++) {
    const end = pool(level + 1);
    for (let at = pool(level); at < end; ) {
      marks[at] |= BEGINS;
      at = check(at, end, level);
    }
  }
  for (let word = rootsWord(topDims); word < top.length; word++) reach(top[word], rootLevel, 'top word', word);
  for (const [what, index] of [
    ['unit', marks.indexOf(BEGINS)],
    ['leaf mask', cubes.isReached.indexOf(0)],
  ] as const) {
    if (index >= 0) packedFault('Unreached', `${what} ${index} is not reachable from any root`);
  }
}
