// Validates a quadtree: every shape is within its page or the common section, every pointer leads to an
// earlier shape of the same page or to one of the common section, and every column of a leaf has one of its
// depths. The same walk finds the depths at which columns switch. Counterpart of
// `crates/adumbra/src/layout/depths/validate.rs` and `ranges.rs`.
//
// Results are remembered by address, and overlapping shapes are refused, so the walk takes time and memory
// linear in the half-words.

import { ShadowFileError, hex } from '../error.js';
import type { ShadowFileFault } from '../error.js';
import { halvesOf, lowestBit } from './bits.js';
import { NEVER, UNIFORM, depthOf, largestRise, leafHead } from './leaf.js';
import { childrenOf, fieldsLength } from './node.js';
import { IN_PAGE, PAGE_LEVEL } from './pages.js';
import type { Page } from './pages.js';
import { LEAF_LEVEL, NODE_LEVELS } from './quadtree.js';

/**
 * The nearest and the farthest depth at which columns switch, and whether some column never switches. If no
 * column switches, both depths are {@link NEVER}.
 */
export type DepthRange = readonly [nearest: number, farthest: number, hasNever: boolean];

/** Checks the shape at an address, and returns its range relative to its base. Without switches the range is inverted. */
type Walk = (at: number, level: number) => DepthRange;

/** The range of no columns. */
const NONE: DepthRange = [Infinity, -Infinity, false];

/** Returns the error for a quadtree that cannot be looked up in. */
export function depthsError(level: number, fault: ShadowFileFault, message: string): ShadowFileError {
  return new ShadowFileError(
    'Depths',
    `the quadtree of depths of level ${level} is not valid: ${message}; bake it again`,
    { level },
    { fault },
  );
}

/**
 * Checks the pages of a level, of which there are `across` in a row. The code begins with `commonWords` words
 * of the common section. Cost: one pass over all shapes, in steps of a page.
 *
 * @returns the range of each page.
 * @throws ShadowFileError of the kind `Depths`.
 */
export function* validate(
  words: Uint32Array,
  commonWords: number,
  pages: readonly Page[],
  across: number,
  level: number,
): Generator<void, DepthRange[], void> {
  const code = halvesOf(words);
  const children = childrenOf(code);
  const commonEnd = 2 * commonWords;
  const fail = (fault: ShadowFileFault, message: string): never => {
    throw depthsError(level, fault, message);
  };

  /**
   * Returns the walk in a part of the code. `common` is the walk of the common section, unless the part is
   * that section.
   */
  const walkIn = (part: string, start: number, end: number, common?: Walk): Walk => {
    /** Ranges of nodes by address and level. */
    const known = new Map<number, DepthRange>();
    /** For each half-word, whether a leaf that begins there has been checked. */
    const checked = new Uint8Array(end - start);
    /** Number of half-words that further shapes may have. */
    let left = end - start;
    const named = (at: number): string => `the shape at half-word ${at - start} of ${part}`;
    const badBits = (at: number, half: number): never => fail('Bits', `${named(at)} has invalid bits: ${hex(half)}`);
    const checkEnd = (at: number, length: number): void => {
      if (length > end - at) fail('End', `${named(at)} extends past its end`);
    };
    const spend = (at: number, length: number): void => {
      checkEnd(at, length);
      left -= length;
      if (left < 0) fail('Overlap', `${named(at)} overlaps others`);
    };

    const checkLeaf = (at: number): void => {
      const half = code[at];
      const [last, differences, width, isSlanted, , planesAt, planes] = leafHead(half);
      if (half >>> 10 !== 0 || width > 2 || (last === 0 && (differences !== 0 || !isSlanted))) {
        badBits(at, half);
      }
      spend(at, planesAt + 4 * planes);
      const padded = code[at + planesAt - 1];
      if (width === 0 && (differences & 1) === 1 && padded >>> 8 !== 0) badBits(at, padded);
      // A rank above the last can be written only if the last is not all ones.
      for (let quarter = 0; quarter < 4 && (last + 1) >>> planes === 0; quarter++) {
        const above = columnsAbove(code, at + planesAt + quarter, planes, last);
        if (above !== 0) {
          const column = 16 * quarter + lowestBit(above);
          fail('Ranks', `${named(at)} gives column ${column} a rank above its last, ${last}`);
        }
      }
    };

    const leaf = (at: number): DepthRange => {
      if (checked[at - start] === 0) {
        checkLeaf(at);
        checked[at - start] = 1;
      }
      const head = leafHead(code[at]);
      const [last, differences, , isSlanted] = head;
      return [isSlanted ? -largestRise(code[at + 1]) : 0, depthOf(code, at, head, differences), differences < last];
    };

    const node = (at: number, below: number): DepthRange => {
      checkEnd(at, 3);
      const [low, high, kind] = [code[at], code[at + 1], code[at + 2]];
      if ((low & high & kind) !== 0) badBits(at, kind);
      spend(at, 3 + fieldsLength(low, high, kind, 0xffff));
      let range = NONE;
      for (let index = 0; index < 16; index++) {
        const { at: to, delta, isNever, isRelative } = children(at, index);
        let found: DepthRange = isNever ? [Infinity, -Infinity, true] : [0, 0, false];
        if (to !== UNIFORM) {
          const isOfCommon = common !== undefined && !isRelative;
          if (isOfCommon ? to >= commonEnd : to < start || to >= at) {
            fail('Order', `${named(at)} has a pointer for child ${index} that leads neither to an earlier shape of that part nor to the common section`);
          }
          found = (isOfCommon ? common : shape)(to, below);
        }
        range = joined(range, [found[0] + delta, found[1] + delta, found[2]]);
      }
      return range;
    };

    const shape: Walk = (at, ofLevel) => {
      if (ofLevel === LEAF_LEVEL) return leaf(at);
      const key = 4 * at + (ofLevel - LEAF_LEVEL) / NODE_LEVELS;
      let range = known.get(key);
      if (range === undefined) {
        range = node(at, ofLevel - NODE_LEVELS);
        known.set(key, range);
      }
      return range;
    };
    return shape;
  };

  const common = walkIn('the common section', 0, commonEnd);
  const rangeOfPage = ({ root, base, firstWord, words: count }: Page, i: number): DepthRange => {
    if (root === UNIFORM) return [base, base, base === NEVER];
    const part = `page (${i % across}, ${Math.floor(i / across)})`;
    const isInPage = root >= IN_PAGE;
    if (isInPage ? root - IN_PAGE >= 2 * count : root >= commonEnd) {
      fail('Root', `the root of ${part} is ${hex(root)}, which is neither in it nor in the common section`);
    }
    const start = 2 * firstWord;
    const [nearest, farthest, hasNever] = isInPage
      ? walkIn(part, start, start + 2 * count, common)(start + root - IN_PAGE, PAGE_LEVEL)
      : common(root, PAGE_LEVEL);
    if (nearest > farthest) return [NEVER, NEVER, true];
    const depth = (difference: number): number => Math.min(Math.max(base + difference, 0), NEVER - 1);
    return [depth(nearest), depth(farthest), hasNever];
  };
  const ranges: DepthRange[] = [];
  for (const [i, page] of pages.entries()) {
    ranges.push(rangeOfPage(page, i));
    yield;
  }
  return ranges;
}

/** Returns the range of the columns of all ranges, which are those of pages. */
export function rangeOf(ranges: readonly DepthRange[]): DepthRange {
  // Leave out NEVER: it is not a farthest depth.
  const [nearest, farthest, hasNever] = ranges.reduce((all, [near, far, never]) => joined(all, [near, far === NEVER ? -1 : far, never]), NONE);
  return [nearest, farthest < 0 ? NEVER : farthest, hasNever];
}

function joined(a: DepthRange, b: DepthRange): DepthRange {
  return [Math.min(a[0], b[0]), Math.max(a[1], b[1]), a[2] || b[2]];
}

/**
 * Returns which of sixteen columns have a rank above `last`. Bit p of their ranks is in half-word `plane + 4
 * p`. All are compared at once, highest bit first.
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
