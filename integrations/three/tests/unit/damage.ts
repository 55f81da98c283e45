// Damages files, and repairs their checksums so that the fault is found behind them.

import { crc32 } from '../../src/file/crc32.js';
import { HEADER_BYTES } from '../../src/index.js';

/** Offset of the section table, and size of its entries, bytes. */
const TABLE = 280;
const ROW = 24;

/** Words that mean something special in a quadtree, and others that are out of range everywhere. */
const SPECIAL = [0, 1, 2, 0x41, 0x200, 0x8000, 0xffff, 0x10000, 0x7fffffff, 0xfffffffe, 0xffffffff];

/** Returns begin and end of the sections of a valid file, bytes. */
export function sectionBorders(bytes: Uint8Array<ArrayBuffer>): number[] {
  const view = new DataView(bytes.buffer);
  return [0, 1, 2].flatMap((i) => {
    const offset = view.getUint32(TABLE + ROW * i, true);
    return [offset, offset + view.getUint32(TABLE + ROW * i + 8, true)];
  });
}

/** Repairs the checksums of the header, and of the sections that are within the file. */
export function repair(bytes: Uint8Array<ArrayBuffer>): void {
  if (bytes.length < HEADER_BYTES) return;
  const view = new DataView(bytes.buffer);
  for (let row = TABLE; row < TABLE + 3 * ROW; row += ROW) {
    const offset = Number(view.getBigUint64(row, true));
    const end = offset + Number(view.getBigUint64(row + 8, true));
    if (end <= bytes.length) view.setUint32(row + 16, crc32(bytes.subarray(offset, end)), true);
  }
  view.setUint32(HEADER_BYTES - 4, crc32(bytes.subarray(0, HEADER_BYTES - 4)), true);
}

/** Returns a file with one to four faults; most with good checksums. */
export function mutate(valid: Uint8Array<ArrayBuffer>, random: () => number): Uint8Array<ArrayBuffer> {
  const below = (n: number) => Math.floor(random() * n);
  let bytes = valid.slice();
  for (let faults = 1 + below(4); faults > 0; faults--) {
    // Three of four faults go into the sections, because less can go wrong in the header.
    const from = below(4) === 0 ? 0 : Math.min(HEADER_BYTES, bytes.length);
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
