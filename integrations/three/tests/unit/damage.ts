// Damages files, and repairs their checksums, so that readers get past them to the fault.

import { crc32 } from '../../src/file/crc32.js';
import { parseDirectory, partsOf } from '../../src/file/directory.js';
import type { Section } from '../../src/file/directory.js';
import { HEADER_BYTES } from '../../src/file/faults.js';
import { parseHeader } from '../../src/file/header.js';

/** Size of a directory entry, and offset of its sections' entries within it, bytes. */
const GRID_BYTES = 256;
const TABLE_AT = 160;
const COMMON_AT = 184;
const BUNDLES_AT = 208;
/** Size of a bundle's entry in a table, bytes. */
const BUNDLE_BYTES = 24;
/** Offsets in the header of the number of grids and of the directory's checksum, bytes. */
const GRIDS_AT = 24;
const DIRECTORY_CHECKSUM_AT = 132;

/** Words with a special meaning in a quadtree, and others that are out of range everywhere. */
const SPECIAL = [0, 1, 2, 0x41, 0x200, 0x8000, 0xffff, 0x10000, 0x7fffffff, 0x80000000, 0xfffffffe, 0xffffffff];

/** Returns the parts of a valid file in file order: the directory, tables, common sections and bundles. */
export function partsOfFile(bytes: Uint8Array<ArrayBuffer>): Section[] {
  const header = parseHeader(bytes);
  const { levelCount, directoryChecksum } = header;
  const length = GRID_BYTES * levelCount;
  const directory: Section = { name: 'directory', offset: HEADER_BYTES, length, checksum: directoryChecksum };
  return [directory, ...partsOf(parseDirectory(bytes.subarray(HEADER_BYTES, HEADER_BYTES + length), header))];
}

/** Repairs the checksums of the header, and of all parts that are within the file. */
export function repair(bytes: Uint8Array<ArrayBuffer>): void {
  if (bytes.length < HEADER_BYTES) return;
  const view = new DataView(bytes.buffer);
  /** Writes the checksum of a range of bytes; returns whether the file has it. */
  const seal = (offset: number, length: number, at: number): boolean => {
    const isWithin = offset + length <= bytes.length;
    if (isWithin) view.setUint32(at, crc32(bytes.subarray(offset, offset + length)), true);
    return isWithin;
  };
  const range = (at: number): [offset: number, length: number] => [
    Number(view.getBigUint64(at, true)),
    Number(view.getBigUint64(at + 8, true)),
  ];
  const directoryBytes = GRID_BYTES * Math.min(view.getUint32(GRIDS_AT, true), 8);
  for (let grid = HEADER_BYTES; grid + GRID_BYTES <= Math.min(HEADER_BYTES + directoryBytes, bytes.length); grid += GRID_BYTES) {
    const [table, tableBytes] = range(grid + TABLE_AT);
    let [bundle] = range(grid + BUNDLES_AT);
    for (let entry = table; entry + BUNDLE_BYTES <= Math.min(table + tableBytes, bytes.length); entry += BUNDLE_BYTES) {
      const storedBytes = view.getUint32(entry, true);
      if (storedBytes > 0) seal(bundle, storedBytes, entry + 8);
      bundle += storedBytes;
    }
    seal(table, tableBytes, grid + TABLE_AT + 16);
    const [common, commonBytes] = range(grid + COMMON_AT);
    seal(common, commonBytes, grid + COMMON_AT + 16);
  }
  seal(HEADER_BYTES, directoryBytes, DIRECTORY_CHECKSUM_AT);
  seal(0, HEADER_BYTES - 4, HEADER_BYTES - 4);
}

/** Returns a file with one to four faults; most with good checksums. */
export function mutate(valid: Uint8Array<ArrayBuffer>, random: () => number): Uint8Array<ArrayBuffer> {
  const below = (n: number) => Math.floor(random() * n);
  let bytes = valid.slice();
  for (let faults = 1 + below(4); faults > 0; faults--) {
    // Three of four faults go after the header and the first directory entry, where more can go wrong.
    const from = below(4) === 0 ? 0 : Math.min(HEADER_BYTES + GRID_BYTES, bytes.length);
    const at = from + below(bytes.length - from);
    const word = at & ~3;
    if (word + 4 > bytes.length) continue;
    const view = new DataView(bytes.buffer);
    const kind = below(16);
    if (kind < 4) bytes[at] ^= 1 << below(8);
    else if (kind < 7) bytes[at] = below(256);
    else if (kind < 10) view.setUint32(word, SPECIAL[below(SPECIAL.length)], true);
    else if (kind < 12) view.setUint32(word, view.getUint32(word, true) + (below(2) === 0 ? 1 : -1), true);
    else if (kind < 14) view.setUint32(word, view.getUint32(4 * below(bytes.length >> 2), true), true);
    else if (kind === 14) bytes = bytes.slice(0, at);
    else bytes = Uint8Array.of(...bytes, below(256));
  }
  if (below(8) !== 0) repair(bytes);
  return bytes;
}
