// What a file takes in memory while it is parsed, from its header, directory and tables alone. Counterpart of
// `crates/adumbra/src/file/memory.rs`.

import { ShadowFileError } from '../error.js';
import type { GridEntry } from './directory.js';
import type { BundleEntry } from './table.js';

/**
 * What decoding a part, and then checking it, takes at most beside its words, as a multiple of them. The smallest leaf has four
 * bytes, and 60 in lists of shapes that may be half empty. The smallest node has six bytes, and some 170 in the map of what has
 * been checked.
 */
const DECODING_RATIO = 32;
/** What a bundle takes beside its words: an entry, and sixteen pages with blocks. */
const BUNDLE_BYTES = 6000;

/**
 * Checks that a file of so many bytes can be parsed within a limit.
 *
 * @throws ShadowFileError of the kind `TooLarge` if it cannot.
 */
export function checkMemory(fileBytes: number, entries: readonly GridEntry[], tables: readonly (readonly BundleEntry[])[], limit: number): void {
  let needed = fileBytes;
  let largest = 0;
  // Words are there twice until all of a level are together.
  for (const { commonRawBytes } of entries) needed += (2 + DECODING_RATIO) * commonRawBytes;
  for (const { pageWords } of tables.flat()) {
    needed += 8 * pageWords + BUNDLE_BYTES;
    largest = Math.max(largest, pageWords);
  }
  needed += 4 * DECODING_RATIO * largest;
  if (needed > limit) throw new ShadowFileError('TooLarge', `takes ${needed} bytes of memory, above limitBytes: ${limit}`, { needed, limit });
}
