// Streamed files answer like the whole files.

import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';

import { DirectionalLight, Scene, Texture } from 'three';
import type { Box2, Vector2 } from 'three';
import { afterAll, afterEach, beforeAll, describe, expect, it, vi } from 'vitest';

import { BakedShadowFile, LookUpTexture, Sampler } from '../../src/index.js';
import type { FilterWidth } from '../../src/index.js';
import { Allocator, inGranules } from '../../src/stream/allocator.js';
import type { Bundle } from '../../src/stream/bundles.js';
import { StreamedShadowFile } from '../../src/stream/index.js';
import { Pool } from '../../src/stream/pool.js';
import { attachBakedShadow } from '../../src/webgl/index.js';
import { surfacesOf } from './points.js';
import { cameraAt, serve, settled } from './stream-server.js';
import { readBytes, scatter, validBytes, validNames } from './vectors.js';

const PROGRAM = process.env['ADUMBRA_BIN'];
const MIB = 1024 * 1024;
/** So fine that all of a file is wanted. */
const ALL = 1e-9;

afterEach(() => {
  vi.unstubAllGlobals();
  vi.restoreAllMocks();
});

const at = (all: ArrayLike<number>, i: number) => ({ x: all[3 * i]!, y: all[3 * i + 1]!, z: all[3 * i + 2]! });

/** Compares the answers of a streamed file with those of a file, or of the level that answers. */
function compare(streamed: StreamedShadowFile, whole: BakedShadowFile, filter: FilterWidth, count = 500): Map<number, number> {
  const { points, normals } = surfacesOf(whole, count, filter);
  const samplers = Array.from({ length: whole.levelCount }, (_, level) => new Sampler(whole.level(level)!, { filter }));
  const sampler = streamed.sampler({ filter });
  const levels = new Map<number, number>();
  for (let i = 0; i < count; i++) {
    for (const normal of [at(normals, i), undefined]) {
      const level = sampler.levelAt(at(points, i), normal);
      levels.set(level, (levels.get(level) ?? 0) + 1);
      expect(sampler.visibility(at(points, i), normal)).toBe(samplers[level]!.visibility(at(points, i), normal));
    }
  }
  return levels;
}

describe.each(validNames())('%s', (name) => {
  it('answers like the file once everything is resident', async () => {
    const bytes = validBytes(name);
    const served = serve(bytes);
    const file = await StreamedShadowFile.open('file', { budgetBytes: MIB, detailPixels: ALL });
    await settled(file);
    expect(file.stats.missing).toBe(0);
    expect(file.stats.levels.every(({ bundles, resident }) => bundles === resident)).toBe(true);
    expect(served.ranges[0]).toEqual([0, 65_535]);
    const levels = compare(file, new BakedShadowFile(bytes), 5);
    expect([...levels.keys()]).toEqual([0]);
    file.dispose();
  });
});

describe('a light', () => {
  it('has a header for each level in use, with the anchor of the finest', async () => {
    const bytes = validBytes('levels_coded_depths');
    serve(bytes);
    const whole = new BakedShadowFile(bytes);
    const file = await StreamedShadowFile.open('file', { budgetBytes: MIB });
    const { lookUps, texture } = file.openWords({ filter: 9 }, 8192);
    const { width, height } = texture.image as { width: number; height: number };
    const tables = [2 * 18 * 17, 2 * 5 * 5, 2 * 2 * 2];
    const [second, third, end] = [tables[0]!, tables[0]! + tables[1]!, tables[0]! + tables[1]! + tables[2]!];
    const common = lookUps[1]!.words[16 + 79]! - end;
    expect(common).toBeGreaterThan(0);
    lookUps.forEach(({ words, count }, rank) => {
      expect(count).toBe(width * height);
      expect(words[3]).toBe(count);
      expect(words[7]).toBe(2 - rank);
      expect(words.slice(4, 7)).toEqual(lookUps[0]!.words.slice(4, 7));
      expect([...words.slice(16 + 76, 16 + 81)]).toEqual([[0, second, third][rank], 2 - rank, 1, [end, end + common, end + common][rank], 9]);
      expect(words[106]).toBe([1, 2, 0][rank]);
    });
    // The finest header is that of the file, except for the places of its parts.
    const header = new LookUpTexture(whole, 8192, { filter: 9 }).header.slice();
    const mine = lookUps[0]!.words.slice();
    for (const word of [3, 7, 16 + 76, 16 + 77, 16 + 78, 16 + 79, 106]) header[word] = mine[word] = 0;
    expect(mine).toEqual(header);
    file.dispose();
  });

  it('takes it only alone, and only if its texture is not too large', async () => {
    const bytes = validBytes('levels_coded_depths');
    serve(bytes);
    const file = await StreamedShadowFile.open('file', { budgetBytes: MIB });
    const light = new DirectionalLight();
    expect(() => attachBakedShadow(new Scene(), light, { file: [file, new BakedShadowFile(bytes)] })).toThrow(/a streamed file must be the only one of its light/);
    expect(() => attachBakedShadow(new Scene(), light, { file, maxTextureSize: 256 })).toThrow(/the budget needs a texture of 512 × 512, but a side may have 256 texels; lower it/);
    const attached = attachBakedShadow(new Scene(), light, { file });
    expect(attached.isActive).toBe(true);
    attached.setOptions({ filter: 3 });
    // Another file gets its own words, not the stream's.
    const words = vi.spyOn(Texture.prototype, 'dispose');
    attached.setFiles(new BakedShadowFile(bytes));
    expect(words.mock.instances).not.toHaveLength(0);
    expect(attached.isActive).toBe(true);
    words.mockRestore();
    attached.dispose();
    file.dispose();
  });
});

describe.skipIf(PROGRAM === undefined)('a city, skipped unless ADUMBRA_BIN names the program', () => {
  let folder = '';
  let bytes: Uint8Array;
  let whole: BakedShadowFile;
  beforeAll(() => {
    folder = mkdtempSync(join(tmpdir(), 'adumbra-stream-'));
    const run = (...args: string[]) => execFileSync(resolve(PROGRAM ?? ''), args, { stdio: ['ignore', 'ignore', 'pipe'] });
    run('generate', 'city', '-o', join(folder, 'city.glb'));
    run('bake', join(folder, 'city.glb'), '-o', join(folder, 'city.adumbra'), '--resolution', '16384', '--progress', 'none');
    bytes = readBytes(join(folder, 'city.adumbra'));
    whole = new BakedShadowFile(bytes);
  });
  afterAll(() => rmSync(folder, { recursive: true, force: true }));

  it('answers coarsely after two requests', async () => {
    const served = serve(bytes);
    const file = await StreamedShadowFile.open('file', { budgetBytes: 8 * MIB });
    expect(served.ranges.length).toBeLessThanOrEqual(2);
    console.log(`first picture: ${served.ranges.length} requests, ${file.stats.fetchedBytes} of ${bytes.length} bytes`);
    const levels = compare(file, whole, 5);
    // Points beside the grid and before it need no page.
    expect(levels.get(2)).toBeGreaterThan(200);
    expect(levels.has(1)).toBe(false);
    file.dispose();
  });

  it.each([1, 5, 17] as const)('answers like the file once everything is resident, filter %i', async (filter) => {
    serve(bytes);
    const file = await StreamedShadowFile.open('file', { budgetBytes: 16 * MIB, detailPixels: ALL });
    await settled(file);
    expect([...compare(file, whole, filter, 3000).keys()]).toEqual([0]);
    file.dispose();
  });

  it('with a small budget, answers like some level at each point', async () => {
    const served = serve(bytes);
    const file = await StreamedShadowFile.open('file', { budgetBytes: 1.25 * MIB, detailPixels: 0.05 });
    await settled(file, cameraAt(50, 20, -30));
    const levels = compare(file, whole, 5, 3000);
    console.log(`budget 1.25 MiB: answers by level ${JSON.stringify([...levels])}, ${JSON.stringify(file.stats)}`);
    expect(levels.size).toBeGreaterThan(1);
    expect(served.most).toBeLessThanOrEqual(6);
    file.dispose();
  });

  it('uploads only changes, about the requested bytes per update', async () => {
    serve(bytes);
    const uploadBytesPerFrame = 64 * 1024;
    const file = await StreamedShadowFile.open('file', { budgetBytes: 1.25 * MIB, detailPixels: 0.02, uploadBytesPerFrame });
    const words = file.openWords({ filter: 5 }, 8192);
    const pool = words.texture.image as unknown as { data: Uint32Array; width: number; height: number };
    /** The words on the GPU, as of the first picture. */
    const onGpu = pool.data.slice();
    let uploaded = 0;
    const copies = (source: Texture, target: Texture, region?: Box2 | null, place?: Vector2 | null): void => {
      expect(target).toBe(words.texture);
      const { data, width } = source.image as unknown as typeof pool;
      expect([region!.min.x, region!.min.y, region!.max.x, place!.x, width]).toEqual([0, 0, pool.width, 0, pool.width]);
      onGpu.set(data.subarray(0, width * region!.max.y), width * place!.y);
      uploaded += width * region!.max.y;
    };
    words.follow({ copyTextureToTexture: copies });
    const random = scatter(11);
    let most = 0;
    for (let frame = 0; frame < 300; frame++) {
      uploaded = 0;
      const where = Math.floor(frame / 20);
      file.update(cameraAt(400 * (((where * 0.37) % 1) - 0.5), 3 + 20 * random(), 400 * (((where * 0.71) % 1) - 0.5)), 1080);
      most = Math.max(most, 4 * uploaded);
      expect(Buffer.compare(Buffer.from(onGpu.buffer), Buffer.from(pool.data.buffer))).toBe(0);
      await new Promise((done) => setTimeout(done));
    }
    console.log(`most bytes of an update: ${most}`);
    // A page more than requested, the tables of blocks, and whole rows.
    expect(most).toBeGreaterThan(uploadBytesPerFrame);
    expect(most).toBeLessThan(uploadBytesPerFrame + 128 * 1024);
    words.dispose();
    file.dispose();
  });

  it('fades while bundles come and go, then answers like the file', async () => {
    serve(bytes);
    const UPDATES = 16;
    const { points, normals } = surfacesOf(whole, 400, 5);
    /** Returns the largest change of a point's visibility from one update to the next while a camera goes and jumps. */
    const largest = async (budget: number, fadeFrames: number): Promise<number> => {
      const file = await StreamedShadowFile.open('file', { budgetBytes: budget, detailPixels: 0.05, fadeFrames });
      const sampler = file.sampler({ filter: 5 });
      const visibilities = (): number[] => Array.from({ length: 400 }, (_, i) => sampler.visibility(at(points, i), at(normals, i)));
      let [before, most] = [visibilities(), 0];
      for (let frame = 0; frame < 120; frame++) {
        const along = (frame % 80) / 80;
        file.update(cameraAt(400 * (along - 0.5), 3, 200 * (0.5 - along)), 1080);
        await new Promise((done) => setTimeout(done));
        const after = visibilities();
        most = Math.max(most, ...after.map((visibility, i) => Math.abs(visibility - before[i]!)));
        before = after;
      }
      file.dispose();
      return most;
    };
    for (const budget of [1.25 * MIB, 16 * MIB]) {
      expect(await largest(budget, 0), 'nothing jumps').toBeGreaterThan(0.5);
      const faded = await largest(budget, UPDATES);
      expect(faded).toBeGreaterThan(0);
      // Two levels above the coarsest may fade together, each by a step.
      expect(faded).toBeLessThanOrEqual(2 / UPDATES + 1e-9);
    }
    const file = await StreamedShadowFile.open('file', { budgetBytes: 16 * MIB, detailPixels: ALL, fadeFrames: UPDATES });
    await settled(file);
    expect(file.stats.fading).toBe(0);
    expect([...compare(file, whole, 5, 1000).keys()]).toEqual([0]);
    // Shaders see whether pages are absent or fade in these words.
    const { lookUps } = file.openWords({ filter: 5 }, 8192);
    expect(lookUps.map(({ words }) => words[16 + 78])).toEqual([2, 2, 1]);
    file.dispose();
    await expect(StreamedShadowFile.open('file', { budgetBytes: MIB, fadeFrames: 1.5 })).rejects.toThrow(/fadeFrames is 1.5, but must be whole/);
  });

  /** A thousand jumps with `ADUMBRA_FULL`. */
  const JUMPS = process.env['ADUMBRA_FULL'] === undefined ? 25 : 200;

  it(`holds a budget of 1 to 64 MB over ${5 * JUMPS} random jumps, and answers like some level`, async () => {
    serve(bytes);
    const random = scatter(7);
    const held = watchPool();
    for (const budget of [1, 2, 4, 16, 64]) {
      const file = await StreamedShadowFile.open('file', { budgetBytes: budget * 1e6, detailPixels: 0.02 });
      for (let jump = 0; jump < JUMPS; jump++) {
        const camera = cameraAt(500 * (random() - 0.5), 1 + 200 * random() ** 3, 500 * (random() - 0.5));
        for (let frame = 0; frame < 3; frame++) {
          file.update(camera, 1080);
          await new Promise((done) => setTimeout(done));
          const { poolBytes, usedBytes } = file.stats;
          expect(poolBytes).toBeLessThanOrEqual(budget * 1e6);
          expect(usedBytes).toBeLessThanOrEqual(poolBytes);
          expect(held.words()).toBeLessThanOrEqual(usedBytes / 4);
        }
        // Without a wait, what arrives between two jumps would depend on the machine.
        if (jump % 12 === 0) await settled(file, camera);
        if (jump % 10 === 0) compare(file, whole, 5, 50);
      }
      console.log(`${budget} MB: ${JSON.stringify(file.stats)}`);
      file.dispose();
      held.forget();
    }
    console.log(`${held.most} bundles were in a pool at a time, and ${held.givenUp} were given up`);
    expect(held.givenUp).toBeGreaterThan(10);
  });
});

/** Watches the pool: no bundle goes in twice, none is given up that is not in, and no two pages overlap. */
function watchPool() {
  const inPool = new Set<Bundle>();
  const pages = new Map<number, number>();
  const watched = {
    most: 0,
    givenUp: 0,
    words: () => [...pages.values()].reduce((sum, words) => sum + words, 0),
    forget() {
      inPool.clear();
      pages.clear();
    },
  };
  const { enter, giveUp } = Pool.prototype;
  const { allocate, release } = Allocator.prototype;
  vi.spyOn(Pool.prototype, 'enter').mockImplementation(function (this: Pool, bundle, words) {
    expect(inPool.has(bundle)).toBe(false);
    const entering = enter.call(this, bundle, words);
    if (entering !== undefined) inPool.add(bundle);
    watched.most = Math.max(watched.most, inPool.size);
    return entering;
  });
  vi.spyOn(Pool.prototype, 'giveUp').mockImplementation(function (this: Pool, bundle) {
    expect(inPool.delete(bundle)).toBe(true);
    watched.givenUp += 1;
    giveUp.call(this, bundle);
  });
  vi.spyOn(Allocator.prototype, 'allocate').mockImplementation(function (this: Allocator, words) {
    const at = allocate.call(this, words);
    if (at === undefined) return at;
    for (const [other, length] of pages) expect(at + inGranules(words) <= other || other + length <= at).toBe(true);
    pages.set(at, inGranules(words));
    return at;
  });
  vi.spyOn(Allocator.prototype, 'release').mockImplementation(function (this: Allocator, at, words) {
    expect(pages.get(at)).toBe(inGranules(words));
    pages.delete(at);
    release.call(this, at, words);
  });
  return watched;
}
