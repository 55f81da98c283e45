// For any bytes, reading gives either a file in which every point can be looked up, or a ShadowFileError.

import { expect, it } from 'vitest';

import { BakedShadowFile, HEADER_BYTES, LookUpTexture, Sampler, ShadowFileError, parseHeader } from '../../src/index.js';
import { mutate, sectionBorders } from './damage.js';
import { surfacesOf } from './points.js';
import { VALID_FOLDERS, caught, scatter, validBytes, validNames } from './vectors.js';

const VALID = VALID_FOLDERS.flatMap((folder) =>
  validNames(folder).map((name) => ({ name: `${folder}/${name}`, bytes: validBytes(folder, name) })),
);

/** Reads a file; where it is taken, looks points up in it. Returns the fault, or `undefined`. */
function exercise(bytes: Uint8Array, seed: number): string | undefined {
  let file;
  try {
    file = new BakedShadowFile(bytes);
  } catch (error) {
    expect(error).toBeInstanceOf(ShadowFileError);
    const { kind, fault } = error as ShadowFileError;
    return fault === undefined ? kind : `${kind} ${fault}`;
  }
  lookUp(file, seed);
  return undefined;
}

function lookUp(file: BakedShadowFile, seed: number): void {
  const { points, normals } = surfacesOf(file, 8, seed);
  for (const filter of [1, 9] as const) {
    const answers = new Sampler(file, { filter }).visibilities(points, normals);
    expect(answers.every((visibility) => visibility >= 0 && visibility <= 1)).toBe(true);
  }
}

it('a file that is cut off anywhere is Truncated', () => {
  for (const { name, bytes } of VALID) {
    const borders = sectionBorders(bytes);
    const around = [HEADER_BYTES, ...borders].flatMap((at) => [at - 1, at, at + 1]);
    const lengths = [0, 1, 7, 8, 12, 15, 16, 200, ...around].filter((length) => length < bytes.length);
    for (const length of lengths) expect(exercise(bytes.slice(0, length), 0), `${name}, ${length}`).toBe('Truncated');
  }
});

it('every flipped bit is an error', () => {
  const valid = validBytes('valid', 'example_8_depths');
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
  for (let seed = 0; seed < 40_000; seed++) {
    const fault = exercise(mutate(VALID[seed % VALID.length].bytes, random), seed);
    found.set(fault, (found.get(fault) ?? 0) + 1);
  }
  // The mutations reach the checks, and also leave files that are valid.
  expect(found.get(undefined)).toBeGreaterThan(1000);
  const kinds = 'Magic FutureVersion Truncated TrailingBytes HeaderChecksum SectionChecksum HeaderField SectionBounds Padding';
  const all = [...kinds.split(' '), ...['Order', 'End', 'Bits', 'Ranks'].map((fault) => `Depths ${fault}`)];
  expect(all.filter((fault) => !found.has(fault))).toEqual([]);
});

it('damaged voxels that were not verified still end every look-up', () => {
  const random = scatter(3);
  let read = 0;
  for (let seed = 0; seed < 5000; seed++) {
    const bytes = VALID[seed % VALID.length].bytes.slice();
    for (let faults = 0; faults < 8; faults++) {
      bytes[HEADER_BYTES + Math.floor(random() * (bytes.length - HEADER_BYTES))] = 256 * random();
    }
    try {
      lookUp(new BakedShadowFile(bytes, { verify: 'header' }), seed);
      read++;
    } catch (error) {
      expect(error).toMatchObject({ name: 'ShadowFileError', kind: 'Padding' });
    }
  }
  expect(read).toBeGreaterThan(2000);
});

it('verifying the header alone does not take a damaged header', () => {
  const bytes = validBytes('valid', 'sphere_depths');
  bytes[100] ^= 1;
  expect(caught(() => new BakedShadowFile(bytes, { verify: 'header' }))).toMatchObject({ kind: 'HeaderChecksum' });
});

it('bytes at any place in their buffer are read', () => {
  const valid = validBytes('valid', 'upright_depths');
  const expected = new LookUpTexture(new BakedShadowFile(valid.buffer), 4096, { filter: 3 }).words;
  for (const from of [1, 2, 4, 8]) {
    const padded = new Uint8Array(valid.length + 20);
    padded.set(valid, from);
    const file = new BakedShadowFile(padded.subarray(from, from + valid.length));
    expect(new LookUpTexture(file, 4096, { filter: 3 }).words).toEqual(expected);
  }
});

it('the header can be read without the rest', () => {
  const bytes = validBytes('valid', 'sphere_depths');
  const header = parseHeader(bytes.subarray(0, HEADER_BYTES));
  expect(header.fileBytes).toBe(bytes.length);
  expect(header.settings).toMatchObject({
    receivers: 'static',
    bounds: { min: [-8, 0, -8], max: [8, 12.5, 8] },
  });
});
