// CRC-32 of IEEE 802.3, as in gzip and PNG. Four bytes are taken at a time with four tables. Source: Kounavis
// and Berry, "A Systematic Approach to Building High Performance Software-based CRC Generators", 2005.

/** Entry 256 · s + b: the remainder of byte b, followed by s zero bytes. */
const TABLES = /* @__PURE__ */ makeTables();

function makeTables(): Int32Array {
  const POLYNOMIAL = 0xedb88320;
  /** Number of bytes that are taken at a time; one table for each. */
  const SLICES = 4;
  const tables = new Int32Array(256 * SLICES);
  for (let byte = 0; byte < 256; byte++) {
    let remainder = byte;
    for (let bit = 0; bit < 8; bit++) remainder = (remainder >>> 1) ^ (remainder & 1 ? POLYNOMIAL : 0);
    tables[byte] = remainder;
  }
  for (let i = 256; i < tables.length; i++) {
    const before = tables[i - 256];
    tables[i] = (before >>> 8) ^ tables[before & 255];
  }
  return tables;
}

/** Returns the CRC-32 of `bytes`, 0 to 2^32 − 1. Of no bytes it is 0. */
export function crc32(bytes: Uint8Array): number {
  const t = TABLES;
  let crc = -1;
  let at = 0;
  // Words can be read only at multiples of four bytes.
  if (bytes.byteOffset % 4 === 0) {
    const words = new Int32Array(bytes.buffer, bytes.byteOffset, bytes.length >>> 2);
    for (const word of words) {
      const w = word ^ crc;
      crc = t[768 + (w & 255)] ^ t[512 + ((w >>> 8) & 255)] ^ t[256 + ((w >>> 16) & 255)] ^ t[w >>> 24];
    }
    at = 4 * words.length;
  }
  for (; at < bytes.length; at++) crc = (crc >>> 8) ^ t[(crc ^ bytes[at]) & 255];
  return ~crc >>> 0;
}
