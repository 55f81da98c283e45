// Parts of a packed node that both look-ups and the validation decode. `spec/adumbra-file.md`, "The packed layout", has
// the bits. Counterpart of `crates/adumbra/src/layout/packed/node.rs`.

import type { Vec3 } from '../grid/vec3.js';
import { bitsBelow, popCount } from './bits.js';

/** Word of the top at which its columns begin; the words before are the first units of the pools. */
export const POOL_WORDS = 19;
/** Level of the nodes whose children are leaf masks. */
export const LEAF_NODE_LEVEL = 3;
/** Value of a header's field f if no child follows the slots directly. */
export const NO_FOLLOWER = 7;
/** Narrow slots below this value are distances from the end of the node's slots. */
export const NEAR_UNITS = 1024;

/** Returns the number of pointers of the quarters in `codes`, which have three bits each and are never 7. */
export function pointersIn(codes: number): number {
  return popCount(codes & 0o4444) + 2 * popCount(codes & (codes >>> 1) & 0o1111);
}

/** Returns the number of bits in a wide slot's high part for a target pool of `poolUnits` units. */
export function highBits(poolUnits: number): number {
  return poolUnits <= 1 << 20 ? 4 : poolUnits <= 1 << 24 ? 8 : 16;
}

/** Returns the number of units of the high parts of wide slots, with the mask `wide` of the wide pointers. */
export function stringUnits(wide: number, bits: number): number {
  return wide === 0 ? 0 : (Math.max(bits, 8) + bits * popCount(wide) + 15) >>> 4;
}

/** Returns which masks of a node of level 3 are inside it: bit i, mask i. Masks 5, 6 and 7 share a bit. */
export function inlineMasks(unit: number): number {
  const flags = (unit >>> 9) & 0x3f;
  return flags | ((flags & 0x20) * 6);
}

/** Returns the word of the top behind the columns and their count: that of the first root. */
export function rootsWord([x, y]: Vec3): number {
  return POOL_WORDS + 2 * x * y + 1;
}

/** Returns the high part of `bits` bits at bit `place` of the string of the node at `unit`. */
export function highPart(units: Uint16Array, unit: number, place: number, bits: number): number {
  return (units[unit + 1 + (place >>> 4)] >>> (place & 15)) & bitsBelow(bits);
}

/** Returns the voxels of `mask` that are lit too, or lit instead, in a bit plane, by the lowest bit of a count. */
export function withPlane(mask: number, plane: number, count: number): number {
  return count & 1 ? mask & plane : mask | plane;
}
