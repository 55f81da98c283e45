// Three draws the views of another renderer's truth images, and that renderer's rays judge. Skipped where these are
// absent, see CONTRIBUTING.md. Counterpart of `integrations/bevy_adumbra/tests/gpu/truth.rs`.

import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync, symlinkSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

import type { Page } from 'playwright-core';
import { afterAll, beforeAll, expect, test } from 'vitest';

import { BakedShadowFile, BakedShadowQuery } from '../../src/index.js';
import { Npz } from './npz.js';
import type { TruthCamera } from './npz.js';
import { ANGLE, Stage, VERSIONS } from './stage.js';

/** The views, and the back ends that draw them besides WebGPU on SwiftShader. */
const VIEWS = {
  'kaykit_city_21': [],
  'box-city-5k': [],
  'zdm2': [],
  'alpine-2': ['webgl', 'webgl2'],
  'auster': ['webgl', 'webgl2'],
  'dragon_202k': [],
} as const;

/**
 * Another renderer than SwiftShader draws WebGL plainly, as a page does. SwiftShader moves corners to the nearest 16th of
 * a pixel, and with them shadows: of alpine-2, 0.82 % is wrong drawn plainly, 0.33 with three times as many pixels each
 * way, 0.23 with five or nine. It draws five, and the middle one of each square is compared.
 */
const isPlain = ANGLE !== 'swiftshader';
const SCALE = isPlain ? 1 : 5;

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

/** Share of the pixels with n·l > 0.1 on the wrong side of 1/2, %. */
function wrongPercent(found: Float32Array, sun: Float32Array, nDotL: Float32Array): number {
  let [compared, wrong] = [0, 0];
  nDotL.forEach((cosine, i) => {
    if (!(cosine > 0.1)) return;
    compared += 1;
    wrong += Number(found[i]! < 0.5 !== sun[i]! < 0.5);
  });
  return (100 * wrong) / compared;
}

async function draw(backend: string, scene: string, file: string, { eye, target, fov_y: fov }: TruthCamera): Promise<Float32Array> {
  const task = { backend, scene: `/files/scenes/${scene}`, file: `/files/${file}`, eye, target, fov, scale: SCALE };
  const text = await page.evaluate((all) => (window as unknown as { draw(task: object): Promise<string> }).draw(all), task);
  return new Float32Array(Uint8Array.from(Buffer.from(text, 'base64')).buffer);
}

test.for(Object.entries(VIEWS))('%s is as right as its file', async ([name, others], { skip }) => {
  skip(!isThere, `${SHARED} has no truth and scenes; set ADUMBRA_SHARED`);
  const scene = sceneFile(name);
  const truth = new Npz(join(SHARED, 'truth', `${name}.npz`));
  const camera = truth.camera();
  const [sun, nDotL] = [truth.floats('sun'), truth.floats('ndotl')];
  const baked = join(folder, `${name}.adumbra`);
  const options = ['--resolution', '16384', '--sun', camera.sun.join(','), '--ignore-alpha', '--progress', 'none'];
  execFileSync(program!, ['bake', join(SHARED, 'scenes', scene), ...options, '-o', baked], { stdio: 'pipe' });
  // What the file answers at the points that the other renderer saw.
  const query = new BakedShadowQuery(new BakedShadowFile(readFileSync(baked)), { filter: 1 });
  const byFile = wrongPercent(query.visibilities(truth.floats('pos'), truth.floats('normal')), sun, nDotL);
  for (const backend of isPlain ? ['webgl', 'webgl2'] : ['webgpu', ...others]) {
    const drawn = await draw(backend, scene, `${name}.adumbra`, camera);
    const byThree = wrongPercent(drawn, sun, nDotL);
    console.log(`${name}, ${backend}: ${byThree.toFixed(2)} % of pixels wrong, ${byFile.toFixed(2)} % by look-ups at the same points`);
    expect(byThree, backend).toBeLessThanOrEqual(byFile + 0.1);
  }
  expect(complaints).toEqual([]);
});
