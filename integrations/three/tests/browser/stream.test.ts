// Streamed files in three's renderers: a fully resident file has the same pixels as the whole file, a partly
// resident file those of look-ups on the CPU, and no task of the page takes 50 ms meanwhile.

import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

import type { Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, test } from 'vitest';

import type { StreamStats } from '../../src/stream/index.js';
import { Stage, VERSIONS } from './stage.js';

/**
 * The WebGL2 fallback of WebGPURenderer has the look-up of WebGLRenderer, so it runs only with
 * `ADUMBRA_FULL`.
 */
const BACKENDS = process.env['ADUMBRA_FULL'] === undefined ? (['webgpu', 'webgl'] as const) : (['webgpu', 'webgl2', 'webgl'] as const);
const SQUARE = { height: 0.25, middle: [0, 0], width: 120 };
const MIB = 1024 * 1024;
/** So fine that all of a file is wanted. */
const ALL = 1e-9;

/** The pictures that a page has drawn. */
interface Drawn {
  /** The first picture, then one of each place. */
  visibility: string[];
  places: Place[];
}

/** A place that was drawn, once everything that fits was resident. */
interface Place {
  answers: string;
  levels: Record<string, number>;
  longestTask: number;
  longestUpdate: number;
  atFirst: StreamStats;
  atLast: StreamStats;
}

let folder: string;
let stage: Stage;
let page: Page;
let complaints: string[];

beforeAll(async () => {
  const program = process.env['ADUMBRA_BIN'];
  if (program === undefined) throw new Error('the browser tests need the program: ADUMBRA_BIN=…/adumbra');
  folder = mkdtempSync(join(tmpdir(), 'adumbra-three-'));
  const scene = join(folder, 'city.glb');
  execFileSync(program, ['generate', 'city', '-o', scene]);
  execFileSync(program, ['bake', scene, '--sun', '0.5,0.8,0.35', '-o', join(folder, 'city.adumbra'), '--resolution', '16384', '--progress', 'none']);
  stage = await Stage.start(folder);
  ({ page, complaints } = await stage.open(VERSIONS['0.187.0'], 'points.js'));
});

afterAll(async () => {
  await stage?.stop();
  rmSync(folder, { recursive: true, force: true });
});

async function draw(task: object, on = page): Promise<Drawn> {
  return on.evaluate((drawn) => (window as unknown as { draw(task: object): Promise<Drawn> }).draw(drawn), {
    ...SQUARE,
    files: ['/files/city.adumbra'],
    lookUp: 'filtered',
    ...task,
  });
}

const floats = (text: string): Float32Array => new Float32Array(new Uint8Array(Buffer.from(text, 'base64')).buffer);

/** Compares pixels bit for bit. */
function expectSame(found: string, wanted: string): void {
  const [a, b] = [floats(found), floats(wanted)];
  expect(a).toHaveLength(b.length);
  expect(a.filter((value, i) => !Object.is(value, b[i]))).toHaveLength(0);
}

/** Compares pixels with answers on the CPU: at most 0.2 % may differ, by a row of taps. */
function expectAlike(found: Float32Array, wanted: Float32Array, filter: number): void {
  let [off, most, shadowed] = [0, 0, 0];
  wanted.forEach((value, i) => {
    const difference = Math.abs(found[i]! - value);
    off += Number(!(difference <= 0.004));
    most = Math.max(most, difference);
    shadowed += Number(value < 0.5);
  });
  expect(shadowed).toBeGreaterThan(wanted.length / 20);
  expect({ off, most }).toSatisfy(() => off * 500 <= wanted.length && most <= 1 / filter + 0.004);
}

describe.each(BACKENDS)('%s', (backend) => {
  test('a fully resident file has the pixels of the whole file', async () => {
    const settings = { filter: 5 };
    const whole = await draw({ backend, settings });
    const streamed = await draw({ backend, settings, stream: { budgetBytes: 8 * MIB, detailPixels: ALL } });
    const { atFirst, atLast, levels } = streamed.places[0]!;
    console.log(`${backend}: ${atFirst.requests} requests and ${atFirst.fetchedBytes} bytes to the first picture, ${atLast.requests} and ${atLast.fetchedBytes} in all`);
    expect(atFirst.requests).toBeLessThanOrEqual(4);
    expect(atLast.levels.every(({ bundles, resident }) => bundles === resident)).toBe(true);
    expect(Object.keys(levels)).toEqual(['0']);
    expect(streamed.visibility).toHaveLength(2);
    // The first picture is of the coarsest level.
    expect(streamed.visibility[0] === whole.visibility[0]).toBe(false);
    expectSame(streamed.visibility[1]!, whole.visibility[0]!);
  });

  // Few pixels, because with a software renderer, uploads make the page wait for pixels. A machine that is
  // busy with other work may stop the page: one run of three without a long task counts.
  test.each([true, false])('no task takes 50 ms while frames are drawn, worker %s', { retry: 2 }, async (worker) => {
    const stream = { budgetBytes: 32 * MIB, detailPixels: ALL, worker };
    const { places } = await draw({ backend, settings: { filter: 5 }, stream, shown: 1 });
    const { longestTask, longestUpdate, atLast } = places[0]!;
    console.log(`${backend}, worker ${worker}: longest task ${longestTask} ms (0: none above 50), longest update ${longestUpdate.toFixed(1)} ms`);
    expect(atLast.missing).toBe(0);
    expect(longestTask).toBeLessThan(50);
  });

  test('penumbrae of a fully resident file equal the whole file’s', async () => {
    // Few pixels: a software renderer takes a second for a frame of all.
    const task = { backend, lookUp: 'soft', settings: { sunDegrees: 2 }, pixelsAcross: 96 };
    const whole = await draw(task);
    const streamed = await draw({ ...task, stream: { budgetBytes: 8 * MIB, detailPixels: ALL }, cpu: { filter: 1 } });
    expectSame(streamed.visibility[1]!, whole.visibility[0]!);
  });

  test('a partly resident file has the pixels of look-ups on the CPU', async () => {
    const stream = { budgetBytes: MIB, detailPixels: 0.02 };
    const places = [[-60, -60], [60, 60], [-60, 60]];
    const found = await draw({ backend, settings: { filter: 5 }, stream, width: 200, places });
    found.places.forEach(({ answers, levels, atLast }, i) => {
      console.log(`${backend}: pixels by level ${JSON.stringify(levels)}, ${atLast.chosen} bundles chosen, ${atLast.missing} missing, ${atLast.requests} requests`);
      expect(Object.keys(levels).length).toBeGreaterThan(1);
      expectAlike(floats(found.visibility[i + 1]!), floats(answers), 5);
    });
    // Some bundles were loaded twice.
    const { levels, requests } = found.places.at(-1)!.atLast;
    expect(requests).toBeGreaterThan(6);
    expect(levels[0]!.resident).toBeLessThan(levels[0]!.bundles / 2);
  });

  // The oldest version that the renderer works with.
  const versions = Object.entries(VERSIONS).filter(([version]) => version === (backend === 'webgl' ? '0.166.0' : '0.183.0'));
  test.each(versions)('works with three %s', async (_, three) => {
    const other = await stage.open(three, 'points.js');
    const settings = { filter: 5 };
    const whole = await draw({ backend, settings }, other.page);
    const streamed = await draw({ backend, settings, stream: { budgetBytes: 8 * MIB, detailPixels: ALL } }, other.page);
    expectSame(streamed.visibility[1]!, whole.visibility[0]!);
    expect(other.complaints).toEqual([]);
    await other.page.close();
  });
});

test('the page decodes if the worker cannot be loaded', async () => {
  const other = await stage.open(VERSIONS['0.187.0'], 'points.js');
  await other.page.route('**/stream/worker.js', (route) => route.abort());
  const { places } = await draw({ backend: 'webgl', settings: { filter: 1 }, stream: { budgetBytes: 8 * MIB, detailPixels: ALL }, shown: 1 }, other.page);
  expect(places[0]!.atLast.levels.every(({ bundles, resident }) => bundles === resident)).toBe(true);
  await other.page.close();
});

test('the console is silent', () => {
  expect(complaints).toEqual([]);
});
