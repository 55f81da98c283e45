// Path files made of shadow files, and their repair after a change.

import { crc32 } from '../../src/file/crc32.js';
import { wordCount } from '../../src/gpu/look-up-header.js';
import { BakedShadowFile } from '../../src/index.js';
import type { Vec3 } from '../../src/index.js';

/** Size of the header, and of an entry of either table, bytes. */
const [HEADER_BYTES, ENTRY_BYTES] = [128, 32];

/** A moment and where the sun is. */
export type PathStep = readonly [seconds: number, towardsSun: Vec3];
/** A moment and the bytes of its shadow file. */
export type Key = readonly [seconds: number, bytes: Uint8Array];

/** Returns a path file without a place. */
export function pathFile(steps: readonly PathStep[], keys: readonly Key[]): Uint8Array<ArrayBuffer> {
  const aligned = (at: number): number => Math.ceil(at / 8) * 8;
  const frontBytes = HEADER_BYTES + ENTRY_BYTES * (steps.length + keys.length);
  let end = frontBytes;
  const offsets = keys.map(([, { length }]) => {
    const offset = aligned(end);
    end = offset + length;
    return offset;
  });
  const bytes = new Uint8Array(end);
  const view = new DataView(bytes.buffer);
  bytes.set(new TextEncoder().encode('ADUMDAY\n'));
  [1, HEADER_BYTES, 0, steps.length, keys.length, 3600].forEach((word, i) => view.setUint32(8 + 4 * i, word, true));
  view.setBigUint64(48, BigInt(end), true);
  steps.forEach(([seconds, towards], i) => [seconds, ...towards].forEach((number, n) => view.setFloat64(HEADER_BYTES + ENTRY_BYTES * i + 8 * n, number, true)));
  keys.forEach(([seconds, file], i) => {
    const at = HEADER_BYTES + ENTRY_BYTES * (steps.length + i);
    view.setFloat64(at, seconds, true);
    view.setBigUint64(at + 8, BigInt(offsets[i]!), true);
    view.setBigUint64(at + 16, BigInt(file.length), true);
    view.setBigUint64(at + 24, BigInt(wordCount(new BakedShadowFile(file))), true);
    bytes.set(file, offsets[i]);
  });
  repairPath(bytes);
  return bytes;
}

/** Writes the checksums of the tables and of the header. */
export function repairPath(bytes: Uint8Array<ArrayBuffer>): void {
  const view = new DataView(bytes.buffer);
  const frontBytes = HEADER_BYTES + ENTRY_BYTES * (view.getUint32(20, true) + view.getUint32(24, true));
  view.setUint32(56, crc32(bytes.subarray(HEADER_BYTES, frontBytes)), true);
  view.setUint32(124, crc32(bytes.subarray(0, 124)), true);
}
