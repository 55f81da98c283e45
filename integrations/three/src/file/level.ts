// Reading of a level of detail: its common section and bundles become the words that look-ups read.
// Counterpart of `crates/adumbra/src/file/read.rs`.

import { NEVER, UNIFORM } from '../quadtree/leaf.js';
import { BUNDLE_PAGES, BUNDLE_SIDE, PAGE_LEVEL, blockDims, bundleDims, bundleOrder, isUniform } from '../quadtree/pages.js';
import type { Page } from '../quadtree/pages.js';
import type { Quadtree } from '../quadtree/quadtree.js';
import { quadtreeOf } from '../quadtree/top.js';
import { depthsError, rangeOf, validate } from '../quadtree/validate.js';
import type { DepthRange } from '../quadtree/validate.js';
import type { GridEntry } from './directory.js';
import { checkBundle, checkChecksum } from './faults.js';
import type { Steps } from './steps.js';
import { HEAD_WORDS, codedUnpacker, rawUnpacker, unpackBundle } from './table.js';
import type { BundleEntry, Unpacker } from './table.js';

/** A bundle of a level. */
interface Bundle {
  readonly entry: BundleEntry;
  /** Its pages in rows, also those outside the grid. */
  readonly pages: Page[];
  /** Of each page, its number in the grid, x fastest, or {@link OUTSIDE}. */
  readonly numbers: number[];
}

/** In place of the number of a page outside the grid. */
const OUTSIDE = -1;

/**
 * Reads a level of a file that has all of its parts. If `isVerified` is false, the checksums and shapes of
 * its common section and bundles are not checked.
 */
export function* readLevel(
  bytes: Uint8Array,
  level: number,
  { grid, common, commonRawBytes, bundles }: GridEntry,
  table: readonly BundleEntry[],
  isCoded: boolean,
  isVerified: boolean,
): Steps<Quadtree> {
  /** Addresses of half-words have 32 bits. */
  const MAX_WORDS = 2 ** 31 - 1;
  const stored = (offset: number, length: number, checksum: number, name: string): Uint8Array => {
    const part = bytes.subarray(offset, offset + length);
    if (isVerified) checkChecksum(part, checksum, name);
    return part;
  };
  let unpacker: Unpacker | undefined = isCoded ? codedUnpacker() : rawUnpacker();
  const commonBytes = stored(common.offset, common.length, common.checksum, common.name);
  const shared = yield* unpacker.common(commonBytes, commonRawBytes, common.name);
  const unpacked: Uint32Array[] = [];
  let offset = bundles.offset;
  for (const entry of table) {
    const bundle = stored(offset, entry.storedBytes, entry.checksum, entry.name);
    unpacked.push(yield* unpackBundle(unpacker, bundle, entry));
    offset += entry.storedBytes;
    yield;
  }
  const wordCount = table.reduce((sum, { pageWords }) => sum + pageWords, shared.length);
  if (wordCount > MAX_WORDS) {
    throw depthsError(level, 'TooLong', `${wordCount} words of code, but addresses can reach at most ${MAX_WORDS}`);
  }
  const code = new Uint32Array(wordCount);
  code.set(shared);
  const [across, down] = blockDims(grid.size, PAGE_LEVEL);
  const pages: Page[] = Array(across * down);
  let firstWord = shared.length;
  const all: Bundle[] = [];
  for (const [i, [bundleX, bundleY]] of bundleOrder(bundleDims(grid.size)).entries()) {
    const words = unpacked[i];
    code.set(words.subarray(HEAD_WORDS), firstWord);
    const bundle: Bundle = { entry: table[i], pages: [], numbers: [] };
    for (let slot = 0; slot < BUNDLE_PAGES; slot++) {
      const x = BUNDLE_SIDE * bundleX + (slot % BUNDLE_SIDE);
      const y = BUNDLE_SIDE * bundleY + Math.floor(slot / BUNDLE_SIDE);
      const number = x < across && y < down ? across * y + x : OUTSIDE;
      const [root, base, count] = words.subarray(3 * slot);
      const page: Page = { root, base, firstWord, words: count };
      if (number !== OUTSIDE) pages[number] = page;
      bundle.pages.push(page);
      bundle.numbers.push(number);
      firstWord += count;
    }
    all.push(bundle);
    yield;
  }
  // Free both first: checking takes as much memory as they do.
  unpacker = undefined;
  unpacked.length = 0;
  if (isVerified) {
    const ranges = yield* validate(code, shared.length, pages, across, level);
    for (const bundle of all) checkPages(bundle, ranges);
  }
  yield;
  return quadtreeOf(grid.size, code, pages);
}

/**
 * Checks properties that no look-up depends on: that pages outside the grid are as writers write them, that
 * the stored range is the pages' own, and that no bytes are stored if one depth suffices.
 */
function checkPages({ entry: { name, storedBytes, range }, pages, numbers }: Bundle, ranges: readonly DepthRange[]): void {
  if (storedBytes === 0) return;
  pages.forEach((page, slot) => {
    checkBundle(numbers[slot] !== OUTSIDE || isUniform(page, NEVER), name, 'something outside the grid', 'no switches there');
    checkBundle(page.root !== UNIFORM || page.words === 0, name, 'words in a uniform page', 'none');
  });
  const inside = numbers.filter((number) => number !== OUTSIDE);
  // The first page of a bundle is inside the grid.
  const isOneDepth = pages.every((page, slot) => numbers[slot] === OUTSIDE || isUniform(page, pages[0].base));
  checkBundle(!isOneDepth, name, 'bytes although all columns switch at one depth', 'none');
  const isOwn = rangeOf(inside.map((number) => ranges[number])).join() === range.join();
  checkBundle(isOwn, name, `the depths ${range.join()}`, 'the range of depths of its columns');
}
