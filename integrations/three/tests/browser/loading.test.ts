// How long loading a coded file blocks the page. The time is only printed, because it depends on the machine.
// tests/unit/coder.test.ts tests the slices. `ADUMBRA_SCENE` and `ADUMBRA_RESOLUTION` measure another file.

import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync, statSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

import { afterAll, beforeAll, expect, test } from 'vitest';

import { Stage } from './stage.js';

let folder: string;
let stage: Stage;

beforeAll(async () => {
  const program = process.env['ADUMBRA_BIN'];
  if (program === undefined) throw new Error('the browser tests need the program: ADUMBRA_BIN=…/adumbra');
  folder = mkdtempSync(join(tmpdir(), 'adumbra-loading-'));
  let scene = process.env['ADUMBRA_SCENE'];
  if (scene === undefined) {
    scene = join(folder, 'city.glb');
    execFileSync(program, ['generate', 'city', '-o', scene]);
  }
  const resolution = process.env['ADUMBRA_RESOLUTION'] ?? '16384';
  const file = join(folder, 'city.adumbra');
  execFileSync(program, ['bake', scene, '--sun=0.5,0.8,0.35', '--resolution', resolution, '-o', file, '--progress', 'none']);
  stage = await Stage.start(folder);
});

afterAll(async () => {
  await stage?.stop();
  rmSync(folder, { recursive: true, force: true });
});

test('a coded file loads', async () => {
  const { page, complaints } = await stage.open('three', 'loading.js');
  const loads: { longest: number; milliseconds: number; levelCount: number }[] = [];
  for (let i = 0; i < 5; i += 1) loads.push(await page.evaluate('load("/files/city.adumbra")'));
  const bytes = statSync(join(folder, 'city.adumbra')).size;
  console.log(`${bytes} bytes: ${loads.map((l) => `${l.milliseconds.toFixed(0)} ms, longest block ${l.longest.toFixed(1)}`).join('; ')}`);
  expect(loads.every(({ levelCount }) => levelCount === 3)).toBe(true);
  expect(complaints).toEqual([]);
});
