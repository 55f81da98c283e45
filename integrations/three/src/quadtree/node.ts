// The children of nodes. `spec/adumbra-file.md`, "The quadtree", has the fields. Counterpart of
// `crates/adumbra/src/layout/depths/code.rs`.

import { bitsBelow, popCount, twoHalves } from './bits.js';
import { NEVER, UNIFORM } from './leaf.js';
import { NODE_LEVELS } from './quadtree.js';

/** A child of a node. */
export interface Child {
  /** Address of its shape; {@link UNIFORM} if it has none. */
  at: number;
  /** Difference that is added to the base, modulo 2^32. */
  delta: number;
  /** Whether it never switches. */
  isNever: boolean;
  /** Whether the pointer counts back from the node. Otherwise it is an address in the common section. */
  isRelative: boolean;
}

/** Reads a child of the node at an address, 0 to 15. The result is valid until the next call. */
export type Children = (node: number, index: number) => Child;

/**
 * Returns the reader of children in a code. In an invalid code it returns arbitrary children, and does not
 * throw.
 */
export function childrenOf(code: Uint16Array): Children {
  /** Near pointers have this bit if they are relative. */
  const NEAR = 2 ** 15;
  /** Far pointers have this bit if they are relative. */
  const FAR = 2 ** 31;
  /** Number of bits of a far pointer's address or distance. Those above, below {@link FAR}, are the highest of the delta. */
  const FAR_BITS = 25;
  const child: Child = { at: UNIFORM, delta: 0, isNever: false, isRelative: false };
  const point = (at: number, isRelative: boolean): void => {
    child.at = at;
    child.isRelative = isRelative;
  };
  const near = (node: number, pointer: number): void => {
    if (pointer < NEAR) point(pointer, false);
    else point(node - (pointer - NEAR), true);
  };
  return (node, index) => {
    const low = code[node];
    const high = code[node + 1];
    const kind = code[node + 2];
    const at = node + 3 + fieldsLength(low, high, kind, bitsBelow(index));
    const field = code[at];
    const form = (((high >>> index) & 1) << 2) | (((low >>> index) & 1) << 1) | ((kind >>> index) & 1);
    child.at = UNIFORM;
    child.delta = 0;
    child.isNever = form === 1;
    if (form === 2) near(node, field);
    else if (form === 4) {
      child.delta = signed(field >>> 8, 8);
      point(node - (field & 255), true);
    } else if (form > 5) {
      const far = twoHalves(code, at + 1);
      child.delta = signed(field | ((far >>> FAR_BITS) << 16), 22);
      const place = far & bitsBelow(FAR_BITS);
      if (far < FAR) point(place, false);
      else if (place > 0) point(node - place, true);
    } else if (form > 1) {
      child.delta = signed(field, 16);
      if (form === 5) near(node, code[at + 1]);
    }
    return child;
  };
}

/** Returns the number of half-words of the fields of some of a node's children, one bit per child. */
export function fieldsLength(low: number, high: number, kind: number, children: number): number {
  return popCount(low & children) + 2 * popCount(high & children) - popCount(high & ~low & ~kind & children);
}

/** Returns the lowest bits of a number as one in two's complement. */
function signed(value: number, bits: number): number {
  return (value << (32 - bits)) >> (32 - bits);
}

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
