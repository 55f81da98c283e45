// Faults before the voxels: each is made in a valid file, and must give the error that names it.

import { expect, it } from 'vitest';

import { HEADER_BYTES } from '../../src/file/faults.js';
import { BakedShadowFile, ShadowFileError } from '../../src/index.js';
import { partsOfFile, repair } from './damage.js';
import { caught, validBytes } from './vectors.js';

/** A file in the frame of the light, with bounds. */
const LIGHT = validBytes('sphere_depths');
/** A file in the oblique frame, without bounds. */
const OBLIQUE = validBytes('upright_turned_low_depths');
/** A file of three levels, in the oblique frame. */
const LEVELS = validBytes('levels_depths');

/** The fields of a file. Words are numbered as in the specification, from the beginning of the part. */
class Fields {
  readonly #view: DataView;
  readonly #from: number;

  constructor(bytes: Uint8Array<ArrayBuffer>, from: number) {
    this.#view = new DataView(bytes.buffer);
    this.#from = from;
  }

  u32(word: number, value: number): void {
    this.#view.setUint32(this.#from + 4 * word, value, true);
  }

  f64(word: number, value: number): void {
    this.#view.setFloat64(this.#from + 4 * word, value, true);
  }

  add(word: number, more: number): void {
    this.u32(word, this.#view.getUint32(this.#from + 4 * word, true) + more);
  }

  negate(word: number): void {
    this.f64(word, -this.#view.getFloat64(this.#from + 4 * word, true));
  }
}

type Fault = (fields: Fields) => void;

/** Returns a file with a fault in the fields from a byte on, and good checksums. */
function faulty(valid: Uint8Array<ArrayBuffer>, fault: Fault, from = 0): Uint8Array<ArrayBuffer> {
  const bytes = valid.slice();
  fault(new Fields(bytes, from));
  repair(bytes);
  return bytes;
}

/** Returns a file with a fault in the entry of a level. */
function faultyEntry(valid: Uint8Array<ArrayBuffer>, fault: Fault, level = 0): Uint8Array<ArrayBuffer> {
  return faulty(valid, fault, HEADER_BYTES + 256 * level);
}

/** Returns the error of a file, which must say what to do. */
function errorOf(bytes: Uint8Array): ShadowFileError {
  const error = caught(() => new BakedShadowFile(bytes)) as ShadowFileError;
  expect(error).toBeInstanceOf(ShadowFileError);
  expect(error.message).toMatch(/bake|copy|update/);
  return error;
}

/** Checks that the error names a field. */
function expectField(bytes: Uint8Array, name: string): void {
  const { kind, message } = errorOf(bytes);
  expect({ kind, message }).toEqual({ kind: 'HeaderField', message: expect.stringContaining(`the header's ${name} is `) });
}

it.each<[name: string, fault: Fault]>([
  ['version', (h) => h.u32(2, 0)],
  ['version', (h) => h.u32(2, 3)],
  ['header_bytes', (h) => h.u32(3, 384)],
  ['region', (h) => h.u32(36, 1)],
  ['region', (h) => h.u32(36, 1000)],
  ['region', (h) => h.u32(36, 262144)],
  ['region', (h) => h.u32(38, 1)],
  ['reserved word 40', (h) => h.u32(40, 1)],
  ['reserved word 62', (h) => h.u32(62, 1)],
  ['flags', (h) => h.u32(4, 64)],
  ['encoding', (h) => h.u32(7, 2)],
  ['bounds', (h) => h.u32(4, 0)],
  ['bounds', (h) => h.f64(16, 1e9)],
  ['bounds', (h) => h.f64(22, NaN)],
  ['resolution', (h) => h.u32(5, 0)],
  ['grids', (h) => h.u32(6, 0)],
  ['grids', (h) => h.u32(6, 9)],
  ['thickness', (h) => h.f64(8, -1)],
  ['bias', (h) => h.f64(12, Infinity)],
  ['file_bytes', (h) => h.u32(34, 511)],
  ['file_bytes', (h) => h.add(34, 1)],
  ['file_bytes', (h) => h.add(35, 1)],
])('a fault in %s of the header is named', (name, fault) => expectField(faulty(LIGHT, fault), name));

it.each<[name: string, fault: Fault]>([
  ['reserved word 37 of level 0', (e) => e.u32(37, 1)],
  ['reserved word 45 of level 0', (e) => e.u32(45, 1)],
  ['reserved word 51 of level 0', (e) => e.u32(51, 1)],
  ['reserved word 57 of level 0', (e) => e.u32(57, 1)],
  ['reserved word 60 of level 0', (e) => e.u32(60, 1)],
  ['reserved word 63 of level 0', (e) => e.u32(63, 1)],
  ['level', (e) => e.u32(3, 1)],
  ['checksum of all bundles', (e) => e.u32(56, 1)],
  ['sun', (e) => e.negate(8)],
  ['sun', (e) => e.f64(6, 2)],
  ['frame', (e) => e.u32(36, 2)],
  ['yaw', (e) => e.f64(38, 0.1)],
  ['yaw', (e) => e.f64(38, -0)],
  ['size', (e) => e.u32(1, 0)],
  ['voxel_size', (e) => e.f64(4, 0)],
  ['voxel_size', (e) => e.f64(4, Infinity)],
  ['corner', (e) => e.f64(14, NaN)],
  ['axes', (e) => e.f64(18, 2)],
  ['axes', (e) => [18, 20, 22].forEach((word) => e.negate(word))],
])('a fault in %s of the entry of a level is named', (name, fault) => expectField(faultyEntry(LIGHT, fault), name));

it.each<[name: string, fault: Fault]>([
  ['yaw', (e) => e.f64(38, NaN)],
  ['yaw', (e) => e.f64(38, 3.2)],
  ['axes', (e) => e.f64(38, 0.25)],
])('a fault in %s of the oblique frame is named', (name, fault) => expectField(faultyEntry(OBLIQUE, fault), name));

it.each<[name: string, level: number, fault: Fault]>([
  ['level', 2, (e) => e.u32(3, 1)],
  ['voxel_size', 1, (e) => e.f64(4, 0.25)],
  // A sun overhead, and the axes for it.
  ['sun', 1, (e) => [0, 1, 0, ...[1, 0, 0, 0, 0, 1, 0, -1, 0]].forEach((value, i) => e.f64(i < 3 ? 6 + 2 * i : 12 + 2 * i, value))],
])('a fault in %s of another level is named', (name, level, fault) => expectField(faultyEntry(LEVELS, fault, level), name));

it('a later version is named with the versions that are read', () => {
  expect(errorOf(faulty(LIGHT, (h) => h.u32(2, 5)))).toMatchObject({ kind: 'FutureVersion', details: { version: 5, supported: 4 } });
});

it('refuses bytes without the magic', () => {
  const text = new TextEncoder().encode('ADUMBRA\r\n and more');
  expect(errorOf(text)).toMatchObject({ kind: 'Magic', details: { found: 'ADUMBRA\r' } });
});

it.each([
  ['table', 0, 'offset', 40, 8],
  ['table', 0, 'offset', 41, 1],
  ['table', 0, 'length', 42, 24],
  ['table', 0, 'length', 42, -24],
  ['common section', 0, 'offset', 46, 4],
  ['common section', 0, 'raw length', 58, 4],
  ['common section', 1, 'raw length', 59, 1],
  ['bundles', 0, 'offset', 52, -4],
  ['bundles', 0, 'offset', 53, 2],
  ['table', 1, 'length', 42, 24],
  ['common section', 2, 'offset', 46, 4],
  // A longer part of a coarser level moves the parts of the finer ones.
  ['common section', 0, 'offset', [54, 1], 4],
] as const)('refuses the %s of level %i with a wrong %s', (section, level, field, word, more) => {
  const [at, of] = typeof word === 'number' ? [word, level] : word;
  expect(errorOf(faultyEntry(LEVELS, (e) => e.add(at, more), of))).toMatchObject({
    kind: 'SectionBounds',
    details: { section: `${section} of level ${level}`, field },
  });
});

it('a part that extends beyond the file is Truncated', () => {
  const bytes = faultyEntry(LIGHT, (e) => e.add(54, 8));
  new Fields(bytes, 0).add(34, 8);
  repair(bytes);
  expect(errorOf(bytes)).toMatchObject({ kind: 'Truncated', details: { what: 'bundles of level 0', needed: LIGHT.length + 8 } });
});

it('bytes after the last part are TrailingBytes', () => {
  expect(errorOf(Uint8Array.of(...LIGHT, 0))).toMatchObject({ kind: 'TrailingBytes', details: { end: LIGHT.length } });
});

/** Offset of the table of a file of one level. */
const TABLE = HEADER_BYTES + 256;

it.each<[what: string, fault: Fault]>([
  ['too few raw bytes', (t) => [0, 1].forEach((word) => t.u32(word, 188))],
  ['raw bytes that are no whole words', (t) => [0, 1].forEach((word) => t.add(word, 2))],
  ['more raw than stored bytes', (t) => t.add(1, 4)],
  ['no bytes, but raw ones', (t) => t.u32(0, 0)],
  ['no bytes, but two depths', (t) => [0, 1, 2].forEach((word) => t.u32(word, 0))],
])('refuses the entry of a bundle with %s', (_, fault) => {
  expect(errorOf(faulty(LIGHT, fault, TABLE))).toMatchObject({ kind: 'Bundle', details: { section: 'bundle 0 of level 0' } });
});

it('refuses reserved bits in an entry of a table', () => {
  expectField(faulty(LIGHT, (t) => t.u32(5, 2), TABLE), 'reserved bits of bundle 0 of level 0');
});

it('refuses bundles whose total length is not the directory’s', () => {
  const fault: Fault = (t) => [0, 1].forEach((word) => t.add(word, -4));
  expect(errorOf(faulty(LIGHT, fault, TABLE))).toMatchObject({ kind: 'Bundle', details: { section: 'table of level 0' } });
});

it('damage in the header and in each part is found by checksums', () => {
  const flipped = (at: number): Uint8Array => {
    const bytes = LEVELS.slice();
    bytes[at]! ^= 1;
    return bytes;
  };
  expect(errorOf(flipped(HEADER_BYTES - 10))).toMatchObject({ kind: 'HeaderChecksum' });
  const parts = partsOfFile(LEVELS).filter(({ length }) => length > 0);
  expect(parts.length).toBe(8);
  for (const { name, offset } of parts) {
    const section = name.replace('bundles', 'bundle 0');
    expect(errorOf(flipped(offset))).toMatchObject({ kind: 'SectionChecksum', details: { section } });
  }
});

it.each([
  ['a web page', '<!doctype html><title>Not found</title>', /it is a web page, .*; check the address/],
  ['a web page with a blank line', '\n<HTML><body>', /it is a web page/],
  ['a pointer of Git LFS', 'version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n', /git lfs pull/],
  ['another file', 'glTF\x02\0\0\0', /it begins with "glTF/],
])('%s is named as what it is', (_, text, message) => {
  const error = caught(() => new BakedShadowFile(new TextEncoder().encode(text.padEnd(300))));
  expect(error).toMatchObject({ kind: 'Magic' });
  expect((error as Error).message).toMatch(message);
});
