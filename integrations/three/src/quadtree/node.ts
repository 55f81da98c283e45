// The children of nodes. `spec/adumbra-file.md`, "The quadtree", has the fields. Counterpart of
// `crates/adumbra/src/layout/depths/code.rs`.

import { bitsBelow, popCount, twoHalves } from './bits.js';
import { NEVER, UNIFORM } from './leaf.js';
import { NODE_LEVELS } from './quadtree.js';

/** A child of a node. */
export interface Child {
  /** Address of its shape; {@link UNIFORM} if it has none. */
  at: number;
  /** What is added to the base, modulo 2^32. */
  delta: number;
  /** Whether it never switches. */
  isNever: boolean;
  /** Whether the pointer counts back from the node. Otherwise it is an address in the common section. */
  isRelative: boolean;
}

/** Reads a child of the node at an address, 0 to 15. The result is valid until the next call. */
export type Children = (node: number, index: number) => Child;

/** Returns the reader of children in a code. In one that is not valid it reads something, and does not throw. */
export function childrenOf(code: Uint16Array): Children {
  const child: Child = { at: UNIFORM, delta: 0, isNever: false, isRelative: false };
  /** Sets a pointer, of which values from `back` on count back from the node. */
  const point = (node: number, pointer: number, back: number): void => {
    child.isRelative = pointer >= back;
    child.at = child.isRelative ? node - (pointer - back) : pointer;
  };
  return (node, index) => {
    const below = bitsBelow(index);
    const low = code[node];
    const high = code[node + 1];
    const field = node + 3 + popCount(low & below) + 2 * popCount(high & below);
    const size = ((low >>> index) & 1) | (((high >>> index) & 1) << 1);
    const isKind = ((code[node + 2] >>> index) & 1) === 1;
    child.at = UNIFORM;
    child.delta = 0;
    child.isNever = size === 0 && isKind;
    if (size === 3 && isKind) {
      child.delta = twoHalves(code, field) | 0;
      // A pointer to the node itself says that there is no shape.
      if (code[field + 2] !== NEAR) point(node, code[field + 2], NEAR);
    } else if (size > 0) {
      const hasDelta = isKind || size === 3;
      const pointer = hasDelta ? field + 1 : field;
      // A signed half-word.
      if (hasDelta) child.delta = (code[field] << 16) >> 16;
      if (!isKind && size > 1) point(node, twoHalves(code, pointer), FAR);
      else if (!isKind || size > 1) point(node, code[pointer], NEAR);
    }
    return child;
  };
}

/** From here on, near pointers count back from the node. */
const NEAR = 2 ** 15;
/** From here on, far pointers count back from the node. */
const FAR = 2 ** 31;

/** Descends from a block of `level` towards a column, to a block of `end` or to one without a shape. Returns address and base. */
export function descend(
  children: Children,
  [at, base]: readonly [at: number, base: number],
  level: number,
  end: number,
  x: number,
  y: number,
): [at: number, base: number] {
  while (at !== UNIFORM && level > end) {
    level -= NODE_LEVELS;
    const child = children(at, (((y >>> level) & 3) << 2) | ((x >>> level) & 3));
    at = child.at;
    base = child.isNever ? NEVER : (base + child.delta) >>> 0;
  }
  return [at, base];
}
