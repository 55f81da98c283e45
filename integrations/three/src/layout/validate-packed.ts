// Validates a graph of the packed layout: every pointer leads to a node of the level below, every unit belongs to one
// node, and everything is reached. Counterpart of `crates/adumbra/src/layout/packed/validate.rs`.
//
// A node's pool pointers lead to a pool that was read before its own, and the nodes inside another follow its slots one
// behind the other, so one pass from the first unit to the last proves it.

import type { BakedShadowFile } from '../file/shadow-file.js';
import { bitsBelow } from './bits.js';
import { CubeReader } from './packed-cube.js';
import { badBits, cutOff, packedFault } from './packed-fault.js';
import {
  LEAF_NODE_LEVEL,
  NEAR_UNITS,
  NO_FOLLOWER,
  POOL_WORDS,
  highBits,
  pointersIn,
  stringUnits,
} from './packed-node.js';
import { validatePackedTop } from './validate-packed-top.js';

/** Number of units at the start of a pool that narrow slots can address. */
const NARROW_POOL_UNITS = 65536 - NEAR_UNITS;
/** Bits of a unit in `#marks`: a node of a pool begins there; a pointer leads there. */
const BEGINS = 1;
const REACHED = 2;
/** In place of a number of pointers: codes that no node has. */
const INVALID = 255;

/**
 * Checks the words of a file of the packed layout. Cost: one pass over them, and one byte of memory per unit.
 *
 * @throws ShadowFileError of the kind `Packed`.
 */
export function validatePacked(file: BakedShadowFile): void {
  validatePackedTop(file);
  new PackedWalk(file).walk();
}

class PackedWalk {
  readonly #top: Uint32Array;
  readonly #rootLevel: number;
  readonly #rootsAt: number;
  readonly #units: Uint16Array;
  readonly #marks: Uint8Array;
  readonly #cubes: CubeReader;
  /** Number of pointers of a node with these codes. */
  readonly #pointers = pointersByCodes();
  /** Distances to the children inside a node, sorted; up to eight for each level. */
  readonly #inside: Uint16Array;

  constructor({ top, nodes, leafMasks, topDims, rootLevel }: BakedShadowFile) {
    this.#top = top;
    this.#rootLevel = rootLevel;
    this.#rootsAt = POOL_WORDS + 2 * topDims[0] * topDims[1] + 1;
    this.#units = new Uint16Array(nodes.buffer, nodes.byteOffset, 2 * nodes.length);
    this.#marks = new Uint8Array(this.#units.length);
    this.#cubes = new CubeReader(this.#units, leafMasks);
    this.#inside = new Uint16Array(8 * (rootLevel + 1));
  }

  walk(): void {
    const marks = this.#marks;
    for (let level = LEAF_NODE_LEVEL; level <= this.#rootLevel; level++) {
      const end = this.#pool(level + 1);
      for (let at = this.#pool(level); at < end; ) {
        marks[at] |= BEGINS;
        at = level === LEAF_NODE_LEVEL ? this.#cubes.check(at, end) : this.#node(at, end, level);
      }
    }
    for (let index = this.#rootsAt; index < this.#top.length; index++) {
      this.#reach(this.#top[index], this.#rootLevel, 'top word', index);
    }
    checkAllReached('unit', marks.indexOf(BEGINS));
    checkAllReached('leaf mask', this.#cubes.firstUnreached());
  }

  /** Returns the first unit of a level's pool, which is the end of the pool of the level below. */
  #pool(level: number): number {
    return this.#top[level - LEAF_NODE_LEVEL];
  }

  #reach(pointer: number, level: number, place: string, index: number): void {
    const at = this.#pool(level) + pointer;
    if (at >= this.#pool(level + 1) || (this.#marks[at] & BEGINS) === 0) {
      packedFault('Pointer', `${place} ${index} leads to unit ${pointer} of the pool of level ${level}, where no node begins`);
    }
    this.#marks[at] |= REACHED;
  }

  /** Checks the node at `unit` with all nodes inside it. Returns the unit at which it ends. */
  #node(unit: number, end: number, level: number): number {
    const units = this.#units;
    if (unit >= end) cutOff(unit, level);
    const header = units[unit];
    const pointers = this.#pointers[header & 0xfff];
    const field = (header >>> 12) & 7;
    const hasFollower = field !== NO_FOLLOWER;
    // Pointer 7 is never the follower.
    const follower = hasFollower ? field : -1;
    if (pointers === INVALID || follower >= pointers) badBits(unit, level);
    let wide = 0;
    let bits = 0;
    let slot = unit + 1;
    let slotsEnd = slot + pointers - (hasFollower ? 1 : 0);
    if (header >>> 15 === 1) {
      if (slot >= end) cutOff(unit, level);
      const front = units[slot];
      wide = front & 0xff;
      bits = highBits(this.#pool(level) - this.#pool(level - 1));
      const slotted = bitsBelow(pointers) & ~(hasFollower ? 1 << follower : 0);
      if (wide === 0 || (wide & ~slotted) !== 0 || (bits === 16 && front > 0xff)) badBits(unit, level);
      slot += stringUnits(wide, bits);
      slotsEnd += slot - unit - 1;
    }
    if (slotsEnd > end) cutOff(unit, level);
    if (wide !== 0) this.#checkWide(unit, level, slot, wide, follower, bits);

    const first = 8 * level;
    let last = first;
    let place = Math.max(bits, 8);
    for (let p = 0; p < pointers; p++) {
      if (p === follower) {
        last = this.#insert(first, last, 0);
        continue;
      }
      const value = units[slot++];
      if (((wide >>> p) & 1) === 1) {
        const high = this.#highPart(unit, place, bits);
        place += bits;
        this.#reach(high * 65536 + value, level - 1, 'unit', unit);
      } else if (value < NEAR_UNITS) {
        last = this.#insert(first, last, value);
      } else {
        this.#reach(value - NEAR_UNITS, level - 1, 'unit', unit);
      }
    }
    let at = slotsEnd;
    for (let i = first; i < last; i++) {
      const found = this.#inside[i];
      if (found !== at - slotsEnd) {
        const place = `unit ${unit} begins a node with a child ${found} units after its slots`;
        packedFault('Order', `${place}, but the next child must begin ${at - slotsEnd} units after them`);
      }
      at = level - 1 === LEAF_NODE_LEVEL ? this.#cubes.check(at, end) : this.#node(at, end, level - 1);
    }
    return at;
  }

  /** Checks that wide pointers need their high parts, and that zeros follow those. `slot` is the first slot. */
  #checkWide(unit: number, level: number, slot: number, wide: number, follower: number, bits: number): void {
    const units = this.#units;
    let place = Math.max(bits, 8);
    for (let p = 0, at = slot; wide >>> p !== 0; p++) {
      if (p === follower) continue;
      if (((wide >>> p) & 1) === 1) {
        if (this.#highPart(unit, place, bits) * 65536 + units[at] < NARROW_POOL_UNITS) badBits(unit, level);
        place += bits;
      }
      at++;
    }
    if ((place & 15) !== 0 && units[slot - 1] >>> (place & 15) !== 0) badBits(unit, level);
  }

  /** Returns the high part that begins at bit `place` of a node's string. */
  #highPart(unit: number, place: number, bits: number): number {
    return (this.#units[unit + 1 + (place >>> 4)] >>> (place & 15)) & bitsBelow(bits);
  }

  /** Inserts a distance into the sorted ones at `first` to `last`. Returns the new end. */
  #insert(first: number, last: number, distance: number): number {
    const inside = this.#inside;
    let at = last;
    for (; at > first && inside[at - 1] > distance; at--) inside[at] = inside[at - 1];
    inside[at] = distance;
    return last + 1;
  }
}

/** Returns the number of pointers for all codes of a header, `INVALID` for those that no node has. */
function pointersByCodes(): Uint8Array {
  return Uint8Array.from({ length: 4096 }, (_, codes) => {
    // 7 is the only code with all three bits set. A node with one state belongs into its parent.
    const isInvalid = (codes & (codes >>> 1) & (codes >>> 2) & 0o1111) !== 0;
    return isInvalid || codes === 0 || codes === 0o1111 ? INVALID : pointersIn(codes);
  });
}

function checkAllReached(what: string, index: number): void {
  if (index >= 0) packedFault('Unreached', `${what} ${index} is not reachable from any root`);
}
