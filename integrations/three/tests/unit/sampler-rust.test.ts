// Look-ups on the CPU against the Rust crate, bit for bit: `adumbra query` answers the same points. Runs where the
// environment variable ADUMBRA_BIN names the program, such as `target/release/adumbra` of the repository.

import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';

import { afterAll, beforeAll, describe, expect, it } from 'vitest';

import { BakedShadowFile, Sampler } from '../../src/index.js';
import type { Bias, FilterWidth } from '../../src/index.js';
import { surfacesOf } from './points.js';
import { VECTORS, readBytes } from './vectors.js';

const PROGRAM = process.env['ADUMBRA_BIN'];
const POINTS = 20_000;
const BIAS: Bias = { constantTexels: 0.3, slopeTexels: 1.7, normalOffsetTexels: 0.6 };

const FRAMES = ['light', 'oblique'];
const SOME_VECTORS = [
  'valid/cliff_depths',
  'valid/low_sun_tall_depths',
  'valid/odd_sizes_depths',
  'valid/sphere_depths',
  'valid/upright_turned_low_depths',
  'valid_v2/slopes_depths',
];

describe.skipIf(PROGRAM === undefined)('adumbra query, skipped unless ADUMBRA_BIN names the program', () => {
  let folder = '';
  const run = (...args: string[]) => execFileSync(resolve(PROGRAM ?? ''), args, { stdio: ['ignore', 'ignore', 'pipe'] });
  const cityPath = (frame: string) => join(folder, `${frame}.adumbra`);

  beforeAll(() => {
    folder = mkdtempSync(join(tmpdir(), 'adumbra-three-'));
    const scene = join(folder, 'city.glb');
    run('generate', 'city', '-o', scene);
    for (const frame of FRAMES) run('bake', scene, '-o', cityPath(frame), '--frame', frame, '--resolution', '1024');
  });
  afterAll(() => rmSync(folder, { recursive: true, force: true }));

  /** Compares answers at many points, with and without normals. */
  function compare(path: string, filter: FilterWidth, bias?: Bias): void {
    const file = new BakedShadowFile(readBytes(path));
    const { points, normals } = surfacesOf(file, POINTS, filter);
    const [pointsPath, normalsPath, answersPath] = ['p', 'n', 'v'].map((name) => join(folder, name));
    writeFileSync(pointsPath, points);
    writeFileSync(normalsPath, normals);
    const args = ['query', path, '--points-f64', pointsPath, '--filter', String(filter), '-o', answersPath];
    if (bias !== undefined) {
      args.push('--bias-constant', String(bias.constantTexels), '--bias-slope', String(bias.slopeTexels));
      args.push('--bias-normal', String(bias.normalOffsetTexels));
    }
    const sampler = new Sampler(file, bias === undefined ? { filter } : { filter, bias });
    for (const some of [normals, undefined]) {
      run(...args, ...(some === undefined ? [] : ['--normals', normalsPath]));
      const expected = new Uint32Array(readBytes(answersPath).buffer);
      const answers = new Uint32Array(sampler.visibilities(points, some).buffer);
      const wrong = answers.findIndex((bits, i) => bits !== expected[i]);
      const where = wrong < 0 ? '' : `${points.subarray(3 * wrong, 3 * wrong + 3)}; ${normals.subarray(3 * wrong, 3 * wrong + 3)}`;
      expect(wrong, where).toBe(-1);
      expect(answers.length).toBe(POINTS);
      expect(new Set(answers).size, 'different answers').toBeGreaterThan(1);
    }
  }

  it.each(FRAMES)('city in the frame %s', (frame) => {
    for (const filter of [1, 3, 5, 9, 17] as const) compare(cityPath(frame), filter);
    compare(cityPath(frame), 5, BIAS);
  });

  it.each(SOME_VECTORS)('%s', (name) => {
    for (const filter of [1, 3, 5, 9] as const) compare(join(VECTORS, `${name}.adumbra`), filter);
    compare(join(VECTORS, `${name}.adumbra`), 9, BIAS);
  });
});
