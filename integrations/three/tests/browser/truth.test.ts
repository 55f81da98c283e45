// Compares the views that three draws with another renderer's ray-traced truth images. Skipped if the images
// are absent, see CONTRIBUTING.md. Counterpart of `integrations/bevy_adumbra/tests/gpu/truth.rs`.

import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync, symlinkSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

import type { Page } from 'playwright-core';
import { afterAll, beforeAll, expect, test } from 'vitest';

import { BakedShadowFile, Sampler } from '../../src/index.js';
import { Npz } from './npz.js';
import type { TruthCamera } from './npz.js';
import { drivers, Stage, VERSIONS } from './stage.js';

/** The views, and the largest percentage of look-ups at the truth's own points that may be wrong. */
const VIEWS = { 'kaykit_city_21': 0.4, 'box-city-5k': 0.25, 'zdm2': 0.1, 'alpine-2': 0.2, 'auster': 0.05, 'dragon_202k': 0.05 };

const BACKENDS = ['webgpu', 'webgl', 'webgl2'];

const SHARED = process.env['ADUMBRA_SHARED'] ?? fileURLToPath(new URL('../../../../../shared', import.meta.url));
const isThere = existsSync(join(SHARED, 'truth')) && existsSync(join(SHARED, 'scenes'));

/** The program that bakes. */
const program = process.env['ADUMBRA_BIN'];

let folder: string;
let stage: Stage;
let page: Page;
let complaints: string[];

beforeAll(async () => {
  if (!isThere) return;
  if (program === undefined) throw new Error('the browser tests need the program: ADUMBRA_BIN=…/adumbra');
  folder = mkdtempSync(join(tmpdir(), 'adumbra-three-'));
  symlinkSync(join(SHARED, 'scenes'), join(folder, 'scenes'));
  stage = await Stage.start(folder);
  ({ page, complaints } = await stage.open(VERSIONS['0.187.0'], 'truth.js'));
});

afterAll(async () => {
  if (!isThere) return;
  await stage?.stop();
  rmSync(folder, { recursive: true, force: true });
});

/** Returns the name of the scene's file, whatever its extension. */
function sceneFile(name: string): string {
  const found = ['glb', 'ply', 'obj'].map((extension) => `${name}.${extension}`).find((file) => existsSync(join(SHARED, 'scenes', file)));
  if (found === undefined) throw new Error(`no scene for ${name}`);
  return found;
}

/**
 * Errors of the pixels with n·l > 0.1, %: the share on the wrong side of 1/2, the mean difference, and the
 * share where nothing was drawn, along outlines, which counts as lit.
 */
function errors(found: Float32Array, sun: Float32Array, nDotL: Float32Array): { wrong: number; mean: number; empty: number } {
  let [compared, wrong, sum, empty] = [0, 0, 0, 0];
  nDotL.forEach((cosine, i) => {
    if (!(cosine > 0.1)) return;
    compared += 1;
    const visibility = Number.isNaN(found[i]) ? 1 : found[i]!;
    wrong += Number(visibility < 0.5 !== sun[i]! < 0.5);
    sum += Math.abs(visibility - sun[i]!);
    empty += Number(Number.isNaN(found[i]));
  });
  return { wrong: (100 * wrong) / compared, mean: (100 * sum) / compared, empty: (100 * empty) / compared };
}

async function draw(backend: string, scene: string, file: string, { eye, target, fov_y: fov }: TruthCamera): Promise<Float32Array> {
  const task = { backend, scene: `/files/scenes/${scene}`, file: `/files/${file}`, eye, target, fov };
  const text = await page.evaluate((all) => (window as unknown as { draw(task: object): Promise<string> }).draw(all), task);
  return new Float32Array(Uint8Array.from(Buffer.from(text, 'base64')).buffer);
}

test.for(Object.entries(VIEWS))('%s is drawn as accurately as its file answers', async ([name, limit], { skip }) => {
  skip(!isThere, `${SHARED} has no truth and scenes; set ADUMBRA_SHARED`);
  skip(drivers !== 'opengl', 'SwiftShader moves corners, and with them shadows, by up to 1/32 of a pixel; run with ADUMBRA_DRIVERS=opengl and a display');
  const scene = sceneFile(name);
  const truth = new Npz(join(SHARED, 'truth', `${name}.npz`));
  const camera = truth.camera();
  const [sun, nDotL] = [truth.floats('sun'), truth.floats('ndotl')];
  const baked = join(folder, `${name}.adumbra`);
  const options = ['--resolution', '16384', '--sun', camera.sun.join(','), '--ignore-alpha', '--progress', 'none'];
  execFileSync(program!, ['bake', join(SHARED, 'scenes', scene), ...options, '-o', baked], { stdio: 'pipe' });
  // The file's visibility at the points that the other renderer saw.
  const sampler = new Sampler(new BakedShadowFile(readFileSync(baked)), { filter: 1 });
  const byFile = errors(sampler.visibilities(truth.floats('pos'), truth.floats('normal')), sun, nDotL).wrong;
  expect(byFile).toBeLessThan(limit);
  for (const backend of BACKENDS) {
    const drawn = await draw(backend, scene, `${name}.adumbra`, camera);
    const { wrong, mean, empty } = errors(drawn, sun, nDotL);
    const figures = [wrong, mean, byFile, empty].map((percent) => `${percent.toFixed(2)} %`);
    console.log(`${name}, ${backend}: ${figures[0]} of pixels wrong, mean ${figures[1]}, nothing drawn at ${figures[3]}; ${figures[2]} wrong by look-ups at the same points`);
    expect(empty, backend).toBeLessThan(0.1);
    expect(wrong, backend).toBeLessThanOrEqual(byFile + 0.1);
  }
  expect(complaints).toEqual([]);
});
