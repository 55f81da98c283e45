// For any bytes, reading gives either a file in which every point can be looked up, or a ShadowFileError.

import { expect, it } from 'vitest';

import { HEADER_BYTES } from '../../src/file/faults.js';
import { parseHeader } from '../../src/file/header.js';
import { BakedShadowFile, LookUpTexture, Sampler, ShadowFileError } from '../../src/index.js';
import { mutate, partsOfFile } from './damage.js';
import { surfacesOf } from './points.js';
import { caught, scatter, validBytes, validNames } from './vectors.js';

const VALID = validNames().map((name) => ({ name, bytes: validBytes(name) }));

const ROUNDS = process.env['ADUMBRA_FULL'] === undefined ? 1 : 2;

/** A part of a file. */
type Part = Pick<ReturnType<typeof partsOfFile>[0], 'name' | 'offset' | 'length'>;

const endOf = ({ offset, length }: Part): number => offset + length;

/** Reads a file; if it is accepted, looks points up in it. Returns the fault, or `undefined`. */
function exercise(bytes: Uint8Array, seed: number): string | undefined {
  let file;
  try {
    file = new BakedShadowFile(bytes);
  } catch (error) {
    expect(error).toBeInstanceOf(ShadowFileError);
    const { kind, fault } = error as ShadowFileError;
    return fault === undefined ? kind : `${kind} ${fault}`;
  }
  for (let level = 0; level < file.levelCount; level++) lookUp(file.level(level)!, seed);
  return undefined;
}

function lookUp(file: BakedShadowFile, seed: number): void {
  const { points, normals } = surfacesOf(file, 8, seed);
  for (const filter of [1, 9] as const) {
    const answers = new Sampler(file, { filter }).visibilities(points, normals);
    expect(answers.every((visibility) => visibility >= 0 && visibility <= 1)).toBe(true);
  }
}

it.each(VALID)('$name, cut off anywhere, is Truncated and names the first part that is not whole', ({ bytes }) => {
  const header: Part = { name: 'header', offset: 0, length: HEADER_BYTES };
  const parts = [header, ...partsOfFile(bytes)];
  const around = parts.flatMap(({ offset, length }) => [offset, offset + length]).flatMap((at) => [at - 1, at, at + 1]);
  const lengths = [0, 1, 7, 8, 12, 15, 16, 200, ...around].filter((length) => length >= 0 && length < bytes.length);
  for (const length of lengths) {
    const { name: what, offset, length: whole } = parts.find((part) => endOf(part) > length)!;
    const error = caught(() => new BakedShadowFile(bytes.slice(0, length)));
    expect(error, `${length}`).toMatchObject({ kind: 'Truncated', details: { what, needed: offset + whole, have: length } });
  }
});

it('every flipped bit is an error', () => {
  const valid = validBytes('example_8_depths');
  for (let at = 0; at < valid.length; at++) {
    for (let bit = 0; bit < 8; bit++) {
      const bytes = valid.slice();
      bytes[at] ^= 1 << bit;
      expect(caught(() => new BakedShadowFile(bytes)), `byte ${at}, bit ${bit}`).toBeInstanceOf(ShadowFileError);
    }
  }
});

it('mutations are refused or can be looked up in', () => {
  const random = scatter(20_261_124);
  const found = new Map<string | undefined, number>();
  for (let seed = 0; seed < 7_500 * ROUNDS; seed++) {
    const fault = exercise(mutate(VALID[seed % VALID.length].bytes, random), seed);
    found.set(fault, (found.get(fault) ?? 0) + 1);
  }
  // The mutations reach the checks, and also leave files that are valid.
  expect(found.get(undefined)).toBeGreaterThan(200 * ROUNDS);
  const kinds = 'Magic FutureVersion Truncated TrailingBytes HeaderChecksum SectionChecksum HeaderField SectionBounds Bundle Coded';
  const all = [...kinds.split(' '), ...['Root', 'Order', 'End', 'Bits', 'Overlap', 'Ranks'].map((fault) => `Depths ${fault}`)];
  expect(all.filter((fault) => !found.has(fault))).toEqual([]);
});

it('look-ups end in damaged voxels that were not verified', () => {
  const random = scatter(3);
  let read = 0;
  for (let seed = 0; seed < 2500 * ROUNDS; seed++) {
    const bytes = VALID[seed % VALID.length].bytes.slice();
    const tablesEnd = Math.max(...partsOfFile(bytes).filter(({ name }) => name.startsWith('table')).map(endOf));
    for (let faults = 0; faults < 8; faults++) {
      bytes[tablesEnd + Math.floor(random() * (bytes.length - tablesEnd))] = 256 * random();
    }
    try {
      lookUp(new BakedShadowFile(bytes, { verify: 'header' }), seed);
      read++;
    } catch (error) {
      // The lengths of pages say where the next one begins, and coded parts may not be decodable.
      expect(error).toMatchObject({ name: 'ShadowFileError', kind: expect.stringMatching(/^(Bundle|Coded)$/) });
    }
  }
  expect(read).toBeGreaterThan(1000 * ROUNDS);
});

it.each([
  ['HeaderChecksum', 100],
  ['SectionChecksum', HEADER_BYTES + 100],
  ['SectionChecksum', HEADER_BYTES + 256 + 8],
])('verifying the header alone finds the %s at byte %i', (kind, at) => {
  const bytes = validBytes('sphere_depths');
  bytes[at]! ^= 1;
  expect(caught(() => new BakedShadowFile(bytes, { verify: 'header' }))).toMatchObject({ kind });
});

it('a file does not keep the bytes that it was made from', () => {
  const bytes = validBytes('upright_depths');
  const file = new BakedShadowFile(bytes);
  const expected = new LookUpTexture(file, 4096, { filter: 3 }).words;
  bytes.fill(0);
  expect(new LookUpTexture(file, 4096, { filter: 3 }).words).toEqual(expected);
});

it('bytes at any place in their buffer are read', () => {
  const valid = validBytes('upright_depths');
  const expected = new LookUpTexture(new BakedShadowFile(valid.buffer), 4096, { filter: 3 }).words;
  for (const from of [1, 2, 4, 8]) {
    const padded = new Uint8Array(valid.length + 20);
    padded.set(valid, from);
    const file = new BakedShadowFile(padded.subarray(from, from + valid.length));
    expect(new LookUpTexture(file, 4096, { filter: 3 }).words).toEqual(expected);
  }
  // A Buffer of Node, whose bytes lie within others.
  const file = new BakedShadowFile(Buffer.from(Buffer.concat([Buffer.alloc(5), valid])).subarray(5));
  expect(new LookUpTexture(file, 4096, { filter: 3 }).words).toEqual(expected);
});

it('the header can be read without the rest', () => {
  const bytes = validBytes('sphere_depths');
  const header = parseHeader(bytes.subarray(0, HEADER_BYTES));
  expect(header).toMatchObject({ fileBytes: bytes.length, levelCount: 1 });
  expect(header.settings).toMatchObject({
    receivers: 'static',
    bounds: { min: [-8, 0, -8], max: [8, 12.5, 8] },
  });
});
