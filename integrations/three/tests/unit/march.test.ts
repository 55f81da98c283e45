// Marches equal those of the Rust crate, whose answers are in `tests/golden/`, in every bit.

import { readFileSync } from 'node:fs';

import { afterAll, describe, expect, it } from 'vitest';

import { crc32 } from '../../src/file/crc32.js';
import { BakedShadowFile } from '../../src/index.js';
import type { Vec3 } from '../../src/index.js';
import { PathSampler } from '../../src/path/index.js';
import { marchSlope } from '../../src/path/slope.js';
import { VECTORS, readBytes } from './vectors.js';

/** Answers for the sun of a moment, in two files of other suns. */
interface Golden {
  readonly files: [string, string];
  readonly darkAfterVoxels: number;
  readonly sun: Vec3;
  /** Points with a normal each. */
  readonly points: [number[], number[]][];
  /** With filters of 1 and 5. */
  readonly answers: [number[], number[]];
}

const GOLDEN = JSON.parse(readFileSync(new URL('../golden/marches.json', import.meta.url), 'utf8')) as Golden[];

/** Points that are dark because both files hide them. */
let guessed = 0;
afterAll(() => expect(guessed).toBeGreaterThan(5));

describe.each(GOLDEN)('$files', ({ files, darkAfterVoxels, sun, points, answers }) => {
  const keysWith = (darkAfter: number) =>
    files.map((name, key) => {
      const bytes = readBytes(`${VECTORS}/${name}.adumbra`);
      const words = new DataView(bytes.buffer);
      words.setUint32(4 * 39, darkAfter, true);
      words.setUint32(4 * 63, crc32(bytes.subarray(0, 4 * 63)), true);
      const file = new BakedShadowFile(bytes);
      return { key, file, slope: marchSlope(file.grid, sun)! };
    });
  const keys = keysWith(darkAfterVoxels);
  const all = (part: 0 | 1): Float32Array => new Float32Array(points.flatMap((one) => one[part]));

  it.each([1, 5] as const)('equals the answers of the Rust crate with a filter of %i', (filter) => {
    const answersOf = ([first, second]: typeof keys) =>
      new PathSampler({ towardsSun: sun, parts: [first!, second!], isExact: true }, { filter }).visibilities(all(0), all(1));
    const expected = Float32Array.from(answers[filter === 1 ? 0 : 1]);
    expect(answersOf(keys)).toEqual(expected);
    guessed += answersOf(keysWith(0)).filter((visibility, i) => visibility > expected[i]!).length;
    expect(new Set(expected).size).toBeGreaterThan(1);
  });

  it('has no slope towards a sun out of reach', () => {
    const { grid } = keys[0]!.file;
    const [x, y, z] = grid.sun;
    expect(marchSlope(grid, [-x, -y, -z])).toBeUndefined();
    expect(marchSlope(grid, grid.sun)!.every((c) => Math.abs(c) <= 1)).toBe(true);
  });
});
