// Look-ups at moments of a sun path against the Rust crate, bit for bit: `adumbra query --time` answers the
// same points. Runs where the environment variable ADUMBRA_BIN names the program, such as
// `target/release/adumbra` of the repository.

import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';

import { afterAll, afterEach, beforeAll, describe, expect, it, vi } from 'vitest';

import { BakedShadowFile } from '../../src/index.js';
import type { Bias, FilterWidth } from '../../src/index.js';
import { SunPathFile } from '../../src/path/index.js';
import { surfacesOf } from './points.js';
import { serve } from './stream-server.js';
import { readBytes } from './vectors.js';

const PROGRAM = process.env['ADUMBRA_BIN'];
const POINTS = 5000;
const BIAS: Bias = { constantTexels: 0.3, slopeTexels: 1.7, normalOffsetTexels: 0.6 };

describe.skipIf(PROGRAM === undefined)('adumbra query --time, skipped unless ADUMBRA_BIN names the program', () => {
  let folder = '';
  let bytes: Uint8Array<ArrayBuffer>;
  const run = (...args: string[]) => execFileSync(resolve(PROGRAM ?? ''), args, { stdio: ['ignore', 'ignore', 'pipe'] });
  const path = () => join(folder, 'day.adumbra');

  beforeAll(() => {
    folder = mkdtempSync(join(tmpdir(), 'adumbra-path-'));
    const scene = join(folder, 'city.glb');
    run('generate', 'city', '-o', scene);
    run('bake', scene, '--sun-path', 'lat=48,lon=11,date=2026-03-20,from=17:00,to=18:30', '--resolution', '512', '-o', path());
    bytes = readBytes(path());
  });
  afterAll(() => rmSync(folder, { recursive: true, force: true }));
  afterEach(() => vi.unstubAllGlobals());

  /** Compares the answers at a moment, at points around the surfaces of a key. */
  async function compare(file: SunPathFile, seconds: number, filter: FilterWidth, bias?: Bias): Promise<Set<number>> {
    await file.load(seconds);
    const sampler = file.sampler(bias === undefined ? { filter } : { filter, bias });
    expect(sampler.isExact).toBe(true);
    const { points, normals } = surfacesOf(keyOf(0), POINTS, filter);
    const [pointsPath, normalsPath, answersPath] = ['p', 'n', 'v'].map((name) => join(folder, name)) as [string, string, string];
    writeFileSync(pointsPath, points);
    writeFileSync(normalsPath, normals);
    const args = ['query', path(), '--time', String(seconds), '--points-f64', pointsPath, '--filter', String(filter), '-o', answersPath];
    if (bias !== undefined) {
      args.push('--bias-constant', String(bias.constantTexels), '--bias-slope', String(bias.slopeTexels));
      args.push('--bias-normal', String(bias.normalOffsetTexels));
    }
    const different = new Set<number>();
    for (const some of [normals, undefined]) {
      run(...args, ...(some === undefined ? [] : ['--normals', normalsPath]));
      const expected = new Float32Array(readBytes(answersPath).buffer);
      const answers = sampler.visibilities(points, some);
      const wrong = answers.findIndex((answer, i) => answer !== expected[i]);
      expect(wrong, `${points.subarray(3 * wrong, 3 * wrong + 3)}; ${normals.subarray(3 * wrong, 3 * wrong + 3)}`).toBe(-1);
      expect(answers.length).toBe(POINTS);
      for (const answer of answers) different.add(answer);
    }
    return different;
  }

  /** Returns a key of the path. */
  function keyOf(key: number): BakedShadowFile {
    const view = new DataView(bytes.buffer);
    const entry = 128 + 32 * (view.getUint32(20, true) + key);
    const [offset, length] = [8, 16].map((at) => Number(view.getBigUint64(entry + at, true))) as [number, number];
    return new BakedShadowFile(bytes.slice(offset, offset + length));
  }

  it('every moment from afternoon to night has the answers of the program', async () => {
    serve(bytes);
    const file = await SunPathFile.open('day');
    expect(file.keySeconds.length).toBeGreaterThan(3);
    const [first, last] = file.spanSeconds;
    const moments = Array.from({ length: 24 }, (_, i) => first + ((i + 0.37) / 24) * (last - first));
    let nights = 0;
    for (const seconds of [...moments, ...file.keySeconds.slice(0, 2)]) {
      const different = await compare(file, seconds, 1);
      nights += Number(file.sunAt(seconds) === undefined);
      if (file.sunAt(seconds) !== undefined) expect([...different].sort()).toEqual([0, 1]);
      else expect([...different]).toEqual([0]);
      expect(file.stats.resident.length).toBeLessThanOrEqual(3);
    }
    expect(nights).toBeGreaterThan(0);
    file.dispose();
  });

  it.each([3, 5, 9, 17] as const)('a filter of %i has the answers of the program', async (filter) => {
    serve(bytes);
    const file = await SunPathFile.open('day');
    const [a, b] = file.keySeconds as [number, number];
    const different = await compare(file, 0.6 * a + 0.4 * b, filter);
    expect(different.size).toBeGreaterThan(5);
    await compare(file, 0.2 * a + 0.8 * b, filter, BIAS);
    file.dispose();
  });
});
