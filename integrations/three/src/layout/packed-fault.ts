// The errors of a packed graph that is not valid.

import type { ShadowFileFault } from '../error.js';
import { voxelFault } from '../file/faults.js';

/** Throws the error for a packed graph with this fault. */
export function packedFault(fault: ShadowFileFault, message: string): never {
  return voxelFault('Packed', fault, message);
}

/** Throws the error for a node with bits that no writer makes. */
export function badBits(unit: number): never {
  return packedFault('NodeBits', `the node at unit ${unit} has invalid bits, or is too long`);
}

/** Throws the error for a node that does not fit its pool. */
export function cutOff(unit: number): never {
  return packedFault('NodeEnd', `the node at unit ${unit} extends past the end of its pool`);
}
