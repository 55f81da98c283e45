// Validates a quadtree: every shape is within the code, every pointer leads to an earlier shape of the right
// level, and every column of a leaf has one of its depths.
//
// The levels at which an address was proved are remembered, so the walk takes time linear in the half-words.

import { ShadowFileError, hex } from '../error.js';
import type { ShadowFileFault } from '../error.js';
import { halvesOf, lowestBit, popCount, twoHalves } from './bits.js';
import { UNIFORM, leafHead } from './leaf.js';
import { LEAF_LEVEL } from './quadtree.js';
import type { Quadtree } from './quadtree.js';

function fail(fault: ShadowFileFault, message: string): never {
  throw new ShadowFileError('Depths', `the voxels are not valid: ${message}; bake it again`, {}, { fault });
}

/**
 * Checks the words of a quadtree. Cost: one pass over them, and one byte of memory per half-word.
 *
 * @throws ShadowFileError of the kind `Depths`.
 */
export function validate({ top, nodes, leafMasks, rootLevel }: Quadtree): void {
  if (rootLevel !== 5 && rootLevel !== 7 && rootLevel !== 9) {
    fail('RootLevel', `root level ${rootLevel} is not 5, 7 or 9`);
  }
  const code = halvesOf(nodes);
  const wideCount = leafMasks.length >>> 1;
  /** For each address, the levels at which it was proved, one bit per level. */
  const proved = new Uint8Array(code.length);

  const badBits = (at: number, half: number): never => fail('Bits', `the shape at half-word ${at} has invalid bits: ${hex(half)}`);
  const checkEnd = (at: number, length: number): void => {
    if (length > code.length - at) fail('End', `the shape at half-word ${at} extends past the end of the code`);
  };

  const pointer = (from: number, to: number, level: number): void => {
    if (to >= from) {
      fail('Order', `the shape at half-word ${from} points to ${to}, which is not before it`);
    }
    const bit = 1 << ((level - LEAF_LEVEL) >>> 1);
    if ((proved[to] & bit) !== 0) return;
    if (level === LEAF_LEVEL) leaf(to);
    else node(to, level);
    proved[to] |= bit;
  };

  const leaf = (at: number): void => {
    const half = code[at];
    const [last, differences, width, isSlanted, , planesAt, planes] = leafHead(half);
    if (half >>> 10 !== 0 || width > 2 || (last === 0 && (differences !== 0 || !isSlanted))) {
      badBits(at, half);
    }
    checkEnd(at, planesAt + 4 * planes);
    const padded = code[at + planesAt - 1];
    if (width === 0 && (differences & 1) === 1 && padded >>> 8 !== 0) badBits(at, padded);
    // A rank above the last can be written only where the last is not all ones.
    if ((last + 1) >>> planes !== 0) return;
    for (let quarter = 0; quarter < 4; quarter++) {
      const above = columnsAbove(code, at + planesAt + quarter, planes, last);
      if (above !== 0) {
        const column = 16 * quarter + lowestBit(above);
        fail('Ranks', `the shape at half-word ${at} has a rank above its last, ${last}, in column ${column}`);
      }
    }
  };

  const node = (at: number, level: number): void => {
    checkEnd(at, 3);
    const low = code[at];
    const high = code[at + 1];
    const kind = code[at + 2];
    checkEnd(at, 3 + popCount(low) + 2 * popCount(high));
    const near = (field: number): number => (code[field] < 32768 ? code[field] : (at - (code[field] - 32768)) >>> 0);
    for (let c = 0, field = at + 3; c < 16; c++) {
      const size = ((low >>> c) & 1) + 2 * ((high >>> c) & 1);
      const isKind = ((kind >>> c) & 1) === 1;
      let to = UNIFORM;
      if (size === 3 && isKind) {
        const index = twoHalves(code, field);
        if (index >= wideCount) {
          fail('Wide', `the shape at half-word ${at} refers to wide entry ${index}, but there are only ${wideCount}`);
        }
        if (code[field + 2] !== 0) badBits(at, code[field + 2]);
        to = leafMasks[2 * index + 1];
        if (to !== UNIFORM) pointer(at, to, level - 2);
      } else if (size > 0 && !(size === 1 && isKind)) {
        if (size === 1) to = near(field);
        else if (size === 2) to = isKind ? near(field + 1) : twoHalves(code, field);
        else to = twoHalves(code, field + 1);
        pointer(at, to, level - 2);
      }
      field += size;
    }
  };

  for (let root = 0; root < top.length; root += 2) {
    if (top[root] !== UNIFORM) pointer(code.length, top[root], rootLevel);
  }
}

/**
 * Returns which of sixteen columns have a rank above `last`. Bit p of their ranks is in half-word `plane + 4 p`. All are
 * compared at once, highest bit first.
 */
function columnsAbove(code: Uint16Array, plane: number, planes: number, last: number): number {
  let above = 0;
  let equal = 0xffff;
  for (let p = planes - 1; p >= 0; p--) {
    const bits = code[plane + 4 * p];
    if ((last >>> p) & 1) equal &= bits;
    else {
      above |= equal & bits;
      equal &= ~bits;
    }
  }
  return above;
}
