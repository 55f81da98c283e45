// The guide's example for React Three Fiber: bundled as an app bundles it, drawn in a browser, with its file
// changed and its light taken away.

import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

import { decode } from 'fast-png';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, expect, test } from 'vitest';
import { build } from 'vite';

import demo from '../../demo/vite.config.js';
import { Stage, VERSIONS, packagePath } from './stage.js';
import { WALL_AND_GROUND } from './worlds.js';

/** Pixels per unit of the world, and of the world's origin. */
const [ZOOM, ORIGIN] = [10, 100];

let folder: string;
let stage: Stage;

beforeAll(async () => {
  const program = process.env['ADUMBRA_BIN'];
  if (program === undefined) throw new Error('the browser tests need the program: ADUMBRA_BIN=…/adumbra');
  folder = mkdtempSync(join(tmpdir(), 'adumbra-three-'));
  writeFileSync(join(folder, 'world.obj'), WALL_AND_GROUND);
  for (const [name, sun] of [['east', '0.6,0.8,0'], ['west', '-0.6,0.8,0']] as const) {
    const output = join(folder, `${name}.adumbra`);
    execFileSync(program, ['bake', join(folder, 'world.obj'), '--sun', sun, '--resolution', '1024', '-o', output]);
  }
  await build({
    configFile: false,
    logLevel: 'error',
    resolve: demo.resolve!,
    define: { 'process.env.NODE_ENV': '"development"' },
    build: {
      outDir: join(folder, 'app'),
      target: 'es2022',
      minify: false,
      lib: { entry: packagePath('tests/browser/page/react.tsx'), formats: ['es'], fileName: () => 'app.js' },
    },
  });
  stage = await Stage.start(folder);
});

afterAll(async () => {
  await stage?.stop();
  rmSync(folder, { recursive: true, force: true });
});

/** Brightness, 0 to 255, of the ground on either side of the wall and away from it. */
async function brightness(page: Page): Promise<{ west: number; east: number; away: number }> {
  const { data, width, channels } = decode(await page.screenshot({ clip: { x: 0, y: 0, width: 200, height: 200 } }));
  const at = (x: number, z: number): number => data[channels * ((ORIGIN + ZOOM * z) * width + ORIGIN + ZOOM * x)]!;
  return { west: at(-2.5, -5), east: at(2.5, -5), away: at(0, 5) };
}

test.each(['webgpu', 'webgl'])('the example for %s has the shadows of a file, another, and none', async (renderer) => {
  const { page, complaints } = await stage.open(VERSIONS['0.187.0'], `/files/app/app.js&renderer=${renderer}`);
  const seen = (url: string | null) => ({
    async toBe(west: boolean, east: boolean, away: boolean): Promise<void> {
      await page.evaluate((to) => (window as unknown as { setUrl(url: string | null): void }).setUrl(to), url);
      const isLit = async () => Object.values(await brightness(page)).map((value) => value > 128);
      await expect.poll(isLit, { timeout: 60_000, interval: 500 }).toEqual([west, east, away]);
    },
  });
  await seen(null).toBe(false, false, false);
  await seen('/files/east.adumbra').toBe(false, true, true);
  await seen('/files/west.adumbra').toBe(true, false, true);
  await seen(null).toBe(false, false, false);
  await seen('/files/east.adumbra').toBe(false, true, true);
  // React Three Fiber 9 has a clock that three 0.187 is about to drop.
  expect(complaints.filter((each) => !each.startsWith('THREE.Clock: '))).toEqual([]);
});
