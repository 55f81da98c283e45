// The errors of a packed graph that is not valid.

import { ShadowFileError } from '../error.js';
import type { ShadowFileFault } from '../error.js';

/** Throws the error for a packed graph with this fault. */
export function packedFault(fault: ShadowFileFault, message: string): never {
  throw new ShadowFileError('Packed', `the packed graph is not valid: ${message}; bake it again`, {}, { fault });
}

/** Throws the error for a node with bits that no writer makes. */
export function badBits(unit: number, level: number): never {
  packedFault('NodeBits', `unit ${unit} begins a node of level ${level} with invalid bits or an encoding that is too long`);
}

/** Throws the error for a node that does not fit its pool. */
export function cutOff(unit: number, level: number): never {
  packedFault('NodeEnd', `unit ${unit} begins a node of level ${level} that extends past the end of its pool`);
}
