// Checks of a path file's header and tables, and the position of its sun.

import { describe, expect, it, test } from 'vitest';

import { ShadowFileError } from '../../src/index.js';
import { parsePathHeader, parsePathTables } from '../../src/path/front.js';
import type { PathFront } from '../../src/path/front.js';
import { keysAt, sunAt, wantedAt } from '../../src/path/sun.js';
import { pathFile, repairPath } from './path-files.js';
import type { PathStep } from './path-files.js';
import { caught, scatter, validBytes } from './vectors.js';

const KEY = validBytes('cliff_depths');
const [NOON, EVENING, NIGHT] = [[0, 1, 0], [0.6, 0.8, 0], [1, 0, 0]] as const;
const STEPS: PathStep[] = [[0, NOON], [100, EVENING], [200, NIGHT]];
const VALID = pathFile(STEPS, [[0, KEY], [100, KEY]]);
const KEYS_AT = 128 + 32 * STEPS.length;

const parse = (bytes: Uint8Array): PathFront => parsePathTables(bytes, parsePathHeader(bytes));

test('a valid file is read', () => {
  const front = parse(VALID);
  expect(front).toMatchObject({ placeDegrees: null, utcOffsetSeconds: 3600, fileBytes: VALID.length });
  expect(front.keys.map(({ seconds, bytes }) => [seconds, bytes])).toEqual([[0, KEY.length], [100, KEY.length]]);
});

/** A change of a file, and the error that it must cause. */
type Fault = readonly [what: string, kind: string, message: RegExp, change: (view: DataView, bytes: Uint8Array<ArrayBuffer>) => void];

/** Faults whose checksums are repaired. */
const FAULTS: Fault[] = [
  ['another magic', 'Magic', /not a sun path/, (_, bytes) => bytes.set([0x50, 0x4b])],
  ['a shadow file', 'OtherKind', /the shadow file of one sun/, (_, bytes) => bytes.set(KEY.subarray(0, 8))],
  ['a later version', 'FutureVersion', /version 2/, (view) => view.setUint32(8, 2, true)],
  ['version 0', 'HeaderField', /version is 0/, (view) => view.setUint32(8, 0, true)],
  ['another length', 'HeaderField', /header_bytes is 256/, (view) => view.setUint32(12, 256, true)],
  ['unknown flags', 'HeaderField', /flags/, (view) => view.setUint32(16, 2, true)],
  ['a place without its flag', 'HeaderField', /place/, (view) => view.setFloat64(32, 48, true)],
  ['a place beyond the pole', 'HeaderField', /latitude/, (view) => (view.setUint32(16, 1, true), view.setFloat64(32, 91, true))],
  ['an offset of two days', 'HeaderField', /utc_offset_seconds/, (view) => view.setInt32(28, -172_800, true)],
  ['a reserved word', 'HeaderField', /reserved word 20/, (view) => view.setUint32(80, 1, true)],
  ['another length of the file', 'HeaderField', /file_bytes/, (view) => view.setBigUint64(48, 1n, true)],
  ['no unit vector', 'HeaderField', /step 1 is .* unit vector/, (view) => view.setFloat64(128 + 32 + 8, 0.7, true)],
  ['steps out of order', 'HeaderField', /step 1 is -5.* later/, (view) => view.setFloat64(128 + 32, -5, true)],
  ['a step at no time', 'HeaderField', /step 0 .* finite/, (view) => view.setFloat64(128, NaN, true)],
  ['keys out of order', 'HeaderField', /key 1 .* later/, (view) => view.setFloat64(KEYS_AT + 32, 0, true)],
  ['a key elsewhere', 'HeaderField', /key 0 .* a file at byte/, (view) => view.setBigUint64(KEYS_AT + 8, 8n, true)],
  ['a key without bytes', 'HeaderField', /key 0 .* a file at byte/, (view) => view.setBigUint64(KEYS_AT + 16, 0n, true)],
];

describe('faults', () => {
  it.each(FAULTS)('%s', (_, kind, message, change) => {
    const bytes = VALID.slice();
    change(new DataView(bytes.buffer), bytes);
    repairPath(bytes);
    const error = caught(() => parse(bytes)) as Error;
    expect(error).toMatchObject({ name: 'ShadowFileError', kind });
    expect(error.message).toMatch(message);
  });

  it.each([['steps', 20], ['keys', 24]] as const)('refuses a file without %s', (_, at) => {
    const bytes = VALID.slice();
    new DataView(bytes.buffer).setUint32(at, 0, true);
    repairPath(bytes);
    expect(caught(() => parse(bytes))).toMatchObject({ kind: 'HeaderField' });
  });

  it.each([[60, 'HeaderChecksum'], [130, 'SectionChecksum']] as const)('finds a flipped bit in byte %i', (at, kind) => {
    const bytes = VALID.slice();
    bytes[at]! ^= 1;
    expect(caught(() => parse(bytes))).toMatchObject({ kind });
  });

  it.each([0, 7, 15, 127, 128, KEYS_AT])('a file of %i bytes is Truncated', (length) => {
    expect(caught(() => parse(VALID.subarray(0, length)))).toMatchObject({ kind: 'Truncated' });
  });
});

test('random damage gives a path or a ShadowFileError', () => {
  const random = scatter(3);
  const front = KEYS_AT + 64;
  let read = 0;
  for (let i = 0; i < 5000; i++) {
    const bytes = VALID.slice(0, random() < 0.9 ? VALID.length : Math.floor(random() * front));
    for (let faults = 1 + Math.floor(3 * random()); faults > 0; faults--) bytes[Math.floor(random() * Math.min(front, bytes.length))] = Math.floor(256 * random());
    if (bytes.length >= front && random() < 0.9) {
      const view = new DataView(bytes.buffer);
      // The numbers of entries stay, so that checksums can be repaired.
      view.setUint32(20, STEPS.length, true);
      view.setUint32(24, 2, true);
      repairPath(bytes);
    }
    try {
      const { steps, keys } = parse(bytes);
      expect([steps.length, keys.length]).toEqual([4 * STEPS.length, 2]);
      read += 1;
    } catch (error) {
      expect(error).toBeInstanceOf(ShadowFileError);
    }
  }
  expect(read).toBeGreaterThan(10);
});

describe('the sun', () => {
  const front = parse(VALID);

  it('is on the shortest arc between steps', () => {
    expect(sunAt(front, 0)).toEqual(NOON);
    expect(sunAt(front, 100)).toEqual(EVENING);
    const [x, y, z] = sunAt(front, 50)!;
    const half = Math.asin(0.6) / 2;
    expect([x, y, z]).toEqual([expect.closeTo(Math.sin(half), 12), expect.closeTo(Math.cos(half), 12), 0]);
  });

  it.each([-1, 200, 201, NaN])('is undefined at %d', (seconds) => {
    expect(sunAt(front, seconds)).toBeUndefined();
    expect(keysAt(front, seconds)).toBeUndefined();
  });

  it.each([
    [0, [0, 0]],
    [50, [0, 1]],
    [79, [0, 1]],
    // More than four times nearer to the key with the lower sun.
    [81, [1, 0]],
    [100, [1, 1]],
    [150, [1, 1]],
  ])('has at %d the keys %j', (seconds, keys) => expect(keysAt(front, seconds)).toEqual(keys));

  it.each([
    [50, true, [0, 1]],
    [0, true, [0, 1]],
    [100, false, [1, 0]],
    [-5, false, [0]],
    [300, true, [1]],
  ])('wants at %d, if time goes on (%j), the keys %j', (seconds, isForward, keys) => expect(wantedAt(front, seconds, isForward)).toEqual(keys));
});
