// Look-ups on the CPU against the Rust crate, bit for bit: `adumbra query` answers the same points. Runs
// where the environment variable ADUMBRA_BIN names the program, such as `target/release/adumbra` of the
// repository.

import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';

import { afterAll, beforeAll, describe, expect, it } from 'vitest';

import { parseHeader } from '../../src/file/header.js';
import { BakedShadowFile, Sampler } from '../../src/index.js';
import type { Bias, FilterWidth } from '../../src/index.js';
import { surfacesOf } from './points.js';
import { VECTORS, readBytes } from './vectors.js';

const PROGRAM = process.env['ADUMBRA_BIN'];
const POINTS = process.env['ADUMBRA_FULL'] === undefined ? 5000 : 20_000;
const BIAS: Bias = { constantTexels: 0.3, slopeTexels: 1.7, normalOffsetTexels: 0.6 };

const FRAMES = ['light', 'oblique'];
const SOME_VECTORS = [
  'cliff_depths',
  'levels_coded_depths',
  'levels_depths',
  'low_sun_tall_depths',
  'many_depths_coded_depths',
  'many_pages_coded_depths',
  'many_pages_depths',
  'odd_sizes_depths',
  'slopes_depths',
  'sphere_depths',
  'upright_turned_low_depths',
];

const bytesOf = ({ buffer, byteOffset, byteLength }: Uint32Array): Buffer => Buffer.from(buffer, byteOffset, byteLength);

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

  /** Compares answers of each level at many points, with and without normals. */
  function compare(path: string, filter: FilterWidth, bias?: Bias): void {
    const whole = new BakedShadowFile(readBytes(path));
    for (let level = 0; level < whole.levelCount; level++) compareLevel(path, whole.level(level)!, level, filter, bias);
  }

  function compareLevel(path: string, file: BakedShadowFile, level: number, filter: FilterWidth, bias?: Bias): void {
    const { points, normals } = surfacesOf(file, POINTS, filter);
    const [pointsPath, normalsPath, answersPath] = ['p', 'n', 'v'].map((name) => join(folder, name));
    writeFileSync(pointsPath, points);
    writeFileSync(normalsPath, normals);
    const args = ['query', path, '--points-f64', pointsPath, '--filter', String(filter), '--level', String(level), '-o', answersPath];
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

  it('a city of 8192 columns has the words of its raw twin', async () => {
    const scene = join(folder, 'city.glb');
    const [coded, raw] = [join(folder, 'coded.adumbra'), join(folder, 'raw.adumbra')];
    run('bake', scene, '-o', coded, '--resolution', '8192');
    run('convert', coded, '--encoding', 'raw', '-o', raw);
    const bytes = readBytes(coded);
    expect(parseHeader(bytes).isCoded).toBe(true);
    const expected = new BakedShadowFile(readBytes(raw));
    const file = await BakedShadowFile.parseAsync(bytes);
    for (let level = 0; level < expected.levelCount; level++) {
      for (const part of ['code', 'top'] as const) expect(Buffer.compare(bytesOf(file.level(level)![part]), bytesOf(expected.level(level)![part]))).toBe(0);
    }
  });

  it.each(SOME_VECTORS)('%s', (name) => {
    const path = join(VECTORS, 'valid', `${name}.adumbra`);
    for (const filter of [1, 3, 5, 9] as const) compare(path, filter);
    compare(path, 9, BIAS);
  });
});
