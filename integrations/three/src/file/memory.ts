// The memory that a file takes while it is parsed, computed from its header, directory and tables alone.
// Counterpart of `crates/adumbra/src/file/memory.rs`.

import { ShadowFileError } from '../error.js';
import type { GridEntry } from './directory.js';
import type { BundleEntry } from './table.js';

/**
 * The most memory that decoding and then checking a part takes in addition to its words, as a multiple of
 * them. The smallest leaf has four bytes, and takes 60 in lists of shapes that may be half empty. The
 * smallest node has six bytes, and takes some 170 in the map of checked shapes.
 */
const DECODING_RATIO = 32;
/** Bytes that a bundle takes in addition to its words: an entry, and sixteen pages with blocks. */
const BUNDLE_BYTES = 6000;

/**
 * Checks that a file of `fileBytes` bytes can be parsed within a limit of memory.
 *
 * @throws ShadowFileError of the kind `TooLarge` if it cannot.
 */
export function checkMemory(fileBytes: number, entries: readonly GridEntry[], tables: readonly (readonly BundleEntry[])[], limit: number): void {
  let needed = fileBytes;
  let largest = 0;
  // The words of a level exist twice until all of them are joined.
  for (const { commonRawBytes } of entries) needed += (2 + DECODING_RATIO) * commonRawBytes;
  for (const { pageWords } of tables.flat()) {
    needed += 8 * pageWords + BUNDLE_BYTES;
    largest = Math.max(largest, pageWords);
  }
  needed += 4 * DECODING_RATIO * largest;
  if (needed > limit) throw new ShadowFileError('TooLarge', `takes ${needed} bytes of memory, above limitBytes: ${limit}`, { needed, limit });
}
