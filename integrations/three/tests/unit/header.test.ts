// Faults before the voxels: each is made in a valid file, and must give the error that names it.

import { describe, expect, it } from 'vitest';

import { BakedShadowFile, HEADER_BYTES, ShadowFileError } from '../../src/index.js';
import { repair, sectionBorders } from './damage.js';
import { LAYOUT_AT, REFUSED_LAYOUTS, caught, validBytes } from './vectors.js';

/** A file in the frame of the light, with bounds. */
const LIGHT = validBytes('valid', 'sphere_depths');
/** A file in the oblique frame, without bounds. */
const OBLIQUE = validBytes('valid', 'upright_turned_low_depths');

/** A header. Words are numbered as in the specification. */
class Header {
  readonly #view: DataView;

  constructor(bytes: Uint8Array<ArrayBuffer>) {
    this.#view = new DataView(bytes.buffer);
  }

  u32(word: number, value: number): void {
    this.#view.setUint32(4 * word, value, true);
  }

  f64(word: number, value: number): void {
    this.#view.setFloat64(4 * word, value, true);
  }

  add(word: number, more: number): void {
    this.u32(word, this.#view.getUint32(4 * word, true) + more);
  }

  negate(word: number): void {
    this.f64(word, -this.#view.getFloat64(4 * word, true));
  }
}

/** Returns a file with a fault in its header, and good checksums. */
function faulty(valid: Uint8Array<ArrayBuffer>, fault: (header: Header) => void): Uint8Array<ArrayBuffer> {
  const bytes = valid.slice();
  fault(new Header(bytes));
  repair(bytes);
  return bytes;
}

/** Returns the error of a file, which must say what to do. */
function errorOf(bytes: Uint8Array): ShadowFileError {
  const error = caught(() => new BakedShadowFile(bytes)) as ShadowFileError;
  expect(error).toBeInstanceOf(ShadowFileError);
  expect(error.message).toMatch(/bake|copy|update/);
  return error;
}

/** Faults in fields: the name of the field, and what is done to a header in the frame of the light. */
const FIELDS: [name: string, fault: (header: Header) => void][] = [
  ['version', (h) => h.u32(2, 0)],
  ['header_bytes', (h) => h.u32(3, 380)],
  ['layout', (h) => h.u32(13, 7)],
  ['flags', (h) => h.u32(4, 32)],
  ['bounds', (h) => h.u32(4, 0)],
  ['bounds', (h) => h.f64(54, 1e9)],
  ['bounds', (h) => h.f64(60, NaN)],
  ['sun', (h) => h.negate(18)],
  ['sun', (h) => h.f64(16, 2)],
  ['frame', (h) => h.u32(89, 2)],
  ['yaw', (h) => h.f64(90, 0.1)],
  ['resolution', (h) => h.u32(5, 0)],
  ['thickness', (h) => h.f64(46, -1)],
  ['bias', (h) => h.f64(50, Infinity)],
  ['size', (h) => h.u32(7, 0)],
  ['voxel_size', (h) => h.f64(14, 0)],
  ['voxel_size', (h) => h.f64(14, Infinity)],
  ['corner', (h) => h.f64(24, NaN)],
  ['axes', (h) => h.f64(28, 2)],
  ['axes', (h) => [28, 30, 32].forEach((word) => h.negate(word))],
  ['root_level', (h) => h.u32(9, 2)],
  ['root_level', (h) => h.u32(9, 21)],
  ['top_dims', (h) => h.add(10, 1)],
  ['reserved word 92', (h) => h.u32(92, 1)],
  ['reserved word 75', (h) => h.u32(75, 1)],
];

it.each(FIELDS)('a fault in %s is named', (name, fault) => {
  const { kind, message } = errorOf(faulty(LIGHT, fault));
  expect({ kind, message }).toEqual({ kind: 'HeaderField', message: expect.stringContaining(`the header's ${name} is `) });
});

it.each([
  ['yaw', 90, NaN],
  ['axes', 90, 0.25],
])('a fault in %s of the oblique frame is named', (name, word, value) => {
  const { kind, message } = errorOf(faulty(OBLIQUE, (h) => h.f64(word, value)));
  expect({ kind, message }).toEqual({ kind: 'HeaderField', message: expect.stringContaining(`the header's ${name} is `) });
});

it.each([
  [1, 13],
  [1, 88],
  [2, 89],
])('version %i has the reserved word %i', (version, word) => {
  const { kind, message } = errorOf(faulty(LIGHT, (h) => {
    h.u32(2, version);
    h.u32(13, 0);
    h.u32(word, 1);
  }));
  expect({ kind, message }).toEqual({ kind: 'HeaderField', message: expect.stringContaining(`reserved word ${word}`) });
});

describe.each(Object.entries(REFUSED_LAYOUTS))('the layout %s', (layout, number) => {
  it('is refused by name', () => {
    const error = errorOf(faulty(LIGHT, (h) => h.u32(LAYOUT_AT / 4, number)));
    expect(error).toMatchObject({ kind: 'Layout', details: { layout } });
    expect(error.message).toBe(`this file has the layout ${layout}, which this version does not read; bake it again`);
  });
});

it('version 1 has the layout plain alone', () => {
  const error = errorOf(faulty(LIGHT, (h) => [2, 13, 88].forEach((word) => h.u32(word, word === 2 ? 1 : 0))));
  expect(error).toMatchObject({ kind: 'Layout', details: { layout: 'plain' } });
});

it('a later version is named with the versions that are read', () => {
  expect(errorOf(faulty(LIGHT, (h) => h.u32(2, 4)))).toMatchObject({ kind: 'FutureVersion', details: { version: 4, supported: 3 } });
});

it('other bytes are no shadow file', () => {
  const text = new TextEncoder().encode('ADUMBRA\r\n and more');
  expect(errorOf(text)).toMatchObject({ kind: 'Magic', details: { found: 'ADUMBRA\r' } });
});

it.each([
  ['top', 'offset', 70, 8],
  ['top', 'length', 72, 8],
  ['top', 'length', 72, -8],
  ['nodes', 'offset', 76, 16],
  ['nodes', 'length', 78, 2],
  ['nodes', 'length', 79, 2],
  ['leaf_masks', 'offset', 82, -16],
  ['leaf_masks', 'length', 84, 4],
  ['leaf_masks', 'length', 85, 9],
])('the section %s has a wrong %s in word %i', (section, field, word, more) => {
  expect(errorOf(faulty(LIGHT, (h) => h.add(word, more)))).toMatchObject({ kind: 'SectionBounds', details: { section, field } });
});

it('a section that goes on behind the file is cut off', () => {
  expect(errorOf(faulty(LIGHT, (h) => h.add(84, 8)))).toMatchObject({ kind: 'Truncated', details: { what: 'leaf_masks' } });
});

it('a file that goes on behind its last section is named', () => {
  expect(errorOf(Uint8Array.of(...LIGHT, 0))).toMatchObject({ kind: 'TrailingBytes', details: { end: LIGHT.length } });
});

it('a byte between sections is zero', () => {
  const bytes = validBytes('valid', 'example_8_depths');
  const [, end, begin] = sectionBorders(bytes);
  expect(begin).toBeGreaterThan(end!);
  bytes[end!] = 1;
  expect(errorOf(bytes)).toMatchObject({ kind: 'Padding', details: { offset: end } });
});

it('damage in the header and in each section is found by checksums', () => {
  const flipped = (at: number): Uint8Array => {
    const bytes = LIGHT.slice();
    bytes[at]! ^= 1;
    return bytes;
  };
  expect(errorOf(flipped(HEADER_BYTES - 10))).toMatchObject({ kind: 'HeaderChecksum' });
  const sections = ['top', 'nodes', 'leaf_masks'];
  const borders = sectionBorders(LIGHT);
  const found = sections.filter((section, i) => {
    const [begin, end] = [borders[2 * i]!, borders[2 * i + 1]!];
    if (begin === end) return false;
    expect(errorOf(flipped(begin))).toMatchObject({ kind: 'SectionChecksum', details: { section } });
    return true;
  });
  expect(found).toContain('nodes');
});
