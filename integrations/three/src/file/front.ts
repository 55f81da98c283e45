// The beginning of a file after its header: the directory of levels, and their tables.

import { parseDirectory } from './directory.js';
import type { GridEntry } from './directory.js';
import { HEADER_BYTES, checkChecksum, truncated } from './faults.js';
import { directoryEndOf } from './header.js';
import type { ShadowFileHeader } from './header.js';
import { parseTable } from './table.js';
import type { BundleEntry } from './table.js';

/** Reads and checks the directory of a file with this header. `bytes` are the file's, or its beginning. */
export function parseEntries(bytes: Uint8Array, header: ShadowFileHeader): GridEntry[] {
  const end = directoryEndOf(header.levelCount);
  if (bytes.length < end) throw truncated('directory', end, bytes.length);
  const directory = bytes.subarray(HEADER_BYTES, end);
  checkChecksum(directory, header.directoryChecksum, 'directory');
  return parseDirectory(directory, header);
}

/** Reads and checks the tables of all levels, which are in `bytes`. */
export function parseTables(bytes: Uint8Array, entries: readonly GridEntry[], isCoded: boolean): BundleEntry[][] {
  return entries.map(({ table: { name, offset, length, checksum }, bundles }, level) => {
    const table = bytes.subarray(offset, offset + length);
    checkChecksum(table, checksum, name);
    return parseTable(table, level, name, bundles.length, isCoded);
  });
}
