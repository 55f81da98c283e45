// Baked shadows in whole scenes, in three back ends: beside moving objects, with lights that turn, with
// foreign hooks in materials, from glTF files, and with files that are no shadow files. `page/scene.js` has
// the world and its plays.

import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

import type { Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, describe, expect, test } from 'vitest';

import { withJson } from './glb.js';
import { Stage, VERSIONS } from './stage.js';
import { WALL_AND_GROUND } from './worlds.js';

const IS_FULL = process.env['ADUMBRA_FULL'] !== undefined;
/**
 * WebGL2 under WebGPURenderer draws the same nodes as WebGPU: points, streams and paths are always compared
 * on it, scenes only with `ADUMBRA_FULL`.
 */
const BACKENDS = IS_FULL ? (['webgpu', 'webgl2', 'webgl'] as const) : (['webgpu', 'webgl'] as const);
const NODE_BACKENDS = ['webgpu', 'webgl2'] as const;

/** Visibility at the named points of the world, and how often wall and box were drawn into shadow maps. */
type SceneFactors = Record<'wallA' | 'wallB' | 'wallNone' | 'boxA' | 'boxB' | 'boxNone' | 'open', number> & {
  casters: { wall: number; mover: number };
};

/** The error that a load was rejected with. */
interface Rejection {
  name: string;
  kind?: string;
  url?: string;
  message: string;
}

/** The program that bakes. */
const program = process.env['ADUMBRA_BIN'];

let folder: string;
let stage: Stage;
let page: Page;
let complaints: string[];

const at = (name: string): string => join(folder, name);

function run(...options: string[]): void {
  execFileSync(program!, options);
}

beforeAll(async () => {
  if (program === undefined) throw new Error('the browser tests need the program: ADUMBRA_BIN=…/adumbra');
  folder = mkdtempSync(join(tmpdir(), 'adumbra-three-'));
  writeFileSync(at('world.obj'), WALL_AND_GROUND);
  for (const [name, sun] of [['a', '0.6,0.8,0'], ['b', '-0.6,0.8,0']] as const) {
    run('bake', at('world.obj'), '--sun', sun, '--resolution', '1024', '-o', at(`${name}.adumbra`));
  }
  run('generate', 'city', '-o', at('city.glb'));
  run('bake', at('city.glb'), '--resolution', '2048', '-o', at('city.adumbra'), '--link-in', at('city.glb'));
  const city = readFileSync(at('city.glb'));
  const named = (extras: object) => withJson(city, (json) => {
    json.extensions.KHR_lights_punctual.lights[0].extras.adumbra = extras;
  });
  writeFileSync(at('filtered.glb'), named({ shadow: 'city.adumbra', filter: 9 }));
  writeFileSync(at('missing.glb'), named({ shadow: 'nowhere/missing.adumbra' }));
  writeFileSync(at('broken.glb'), named({ shadow: 'truncated.adumbra' }));
  writeFileSync(at('empty.adumbra'), '');
  writeFileSync(at('page.adumbra'), '<!doctype html><title>Sign in</title>');
  writeFileSync(at('picture.adumbra'), PNG);
  const whole = readFileSync(at('a.adumbra'));
  writeFileSync(at('truncated.adumbra'), whole.subarray(0, whole.length - 100));
  writeFileSync(at('header.adumbra'), whole.subarray(0, 200));
  writeFileSync(at('longer.adumbra'), Buffer.concat([whole, Buffer.from('more')]));
  const damaged = Buffer.from(whole);
  damaged[whole.length - 1]! ^= 1;
  writeFileSync(at('damaged.adumbra'), damaged);
  stage = await Stage.start(folder);
  ({ page, complaints } = await stage.open(VERSIONS['0.187.0'], 'scene.js'));
});

afterEach(() => {
  expect(complaints.splice(0)).toEqual([]);
});

afterAll(async () => {
  await stage?.stop();
  rmSync(folder, { recursive: true, force: true });
});

/** A picture of one pixel. */
const PNG = Buffer.from(
  'iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGNgAAAAAgABSK+kcQAAAABJRU5ErkJggg==',
  'base64',
);

/** The results of plays with three 0.187.0; older versions are compared with them. */
const played = new Map<string, unknown>();

async function play<T>(name: string, ...options: unknown[]): Promise<T> {
  const result = await playOn<T>(page, name, ...options);
  played.set(JSON.stringify([name, ...options]), result);
  return result;
}

function playOn<T>(on: Page, name: string, ...options: unknown[]): Promise<T> {
  return on.evaluate(
    ([each, all]) => (window as unknown as { play(...options: unknown[]): Promise<T> }).play(each, ...all),
    [name, options] as const,
  );
}

/** Expects points to be in full shadow, and all others of those under the same suns to be lit. */
function expectShadows(seen: Partial<SceneFactors>, ...shadowed: string[]): void {
  const { casters: _, ...points } = seen;
  const wanted = Object.fromEntries(Object.keys(points).map((name) => [name, shadowed.includes(name) ? 0 : 1]));
  expect(points).toEqual(wanted);
}

describe.each(BACKENDS)('%s', (backend) => {
  test('only moving objects cast in the shadow map, beside the file', async () => {
    const { beside, half, cast, gone } = await play<Record<'beside' | 'half' | 'gone', SceneFactors> & { cast: boolean }>('movers', backend);
    expectShadows(beside, 'wallA', 'boxA');
    expect(beside.casters.mover).toBeGreaterThan(0);
    expect(beside.casters.wall).toBe(0);
    expect(cast).toBe(true);
    expect([half.wallA, half.boxA, half.open]).toEqual([0.5, 0.5, 1]);
    expectShadows(gone);
  });

  test('a file alone draws no shadow map, and intensity and receiveShadow count', async () => {
    const { seen, faint, without, hasMap } = await play<{ seen: SceneFactors; faint: SceneFactors; without: SceneFactors; hasMap: boolean }>(
      'filesAlone',
      backend,
    );
    expectShadows(seen, 'wallA');
    expect(seen.casters).toEqual({ wall: 0, mover: 0 });
    expect(hasMap).toBe(false);
    expect([faint.wallA, faint.open]).toEqual([0.75, 1]);
    expectShadows(without);
  });

  test('a light that turns away gives the casters back in the same frame', async () => {
    const states = await play<(SceneFactors & { isActive: boolean })[]>('turning', backend);
    expect(states.map(({ isActive }) => isActive)).toEqual([true, false, true, false]);
    expect(states.map(({ casters }) => casters.wall > 0)).toEqual([false, true, false, true]);
    const shadowed = [['wallA', 'boxA'], ['wallNone', 'boxNone'], ['wallA', 'boxA'], ['wallB', 'boxB']];
    states.forEach(({ isActive: _, ...seen }, i) => expectShadows(seen, ...shadowed[i]!));
  });

  test('objects rest below a static root, and cast again once removed', async () => {
    const states = await play<SceneFactors[]>('comingAndGoing', backend);
    states.forEach((seen) => expectShadows(seen, 'wallA', 'boxA'));
    expect(states.map(({ casters }) => casters.wall > 0)).toEqual([false, false, true]);
  });

  test('the file of the light’s sun is used', async () => {
    const states = await play<(SceneFactors & { isActive: boolean })[]>('severalSuns', backend);
    expect(states.map(({ isActive }) => isActive)).toEqual([true, true, false, true]);
    const shadowed = [['wallA'], ['wallB'], [], ['wallB']];
    states.forEach(({ isActive: _, ...seen }, i) => expectShadows(seen, ...shadowed[i]!));
  });

  test('two lights have a file each', async () => {
    interface Two {
      red: SceneFactors;
      green: SceneFactors;
      casters: SceneFactors['casters'];
    }
    const { both, oneTurned, back, first, none } = await play<Record<'both' | 'oneTurned' | 'back' | 'first' | 'none', Two>>('twoLights', backend);
    for (const { red, green, casters } of [both, back]) {
      expectShadows(red, 'wallA');
      expectShadows(green, 'wallB');
      expect(casters.wall).toBe(0);
    }
    expectShadows(oneTurned.red, 'wallNone');
    expectShadows(oneTurned.green, 'wallB');
    expectShadows(first.red, 'wallA');
    expectShadows(first.green);
    expect(first.casters.wall).toBe(0);
    expectShadows(none.red);
    expectShadows(none.green);
  });

  test('a SunLight has a file too', async () => {
    const { refusal, aligned, turned, isActive } = await play<{
      refusal: string;
      aligned: SceneFactors;
      turned: SceneFactors;
      isActive: boolean;
    }>('sunLight', backend);
    expect(refusal).toContain(backend === 'webgl' ? '' : 'sunShadow(light)');
    expectShadows(aligned, 'wallA', 'boxA');
    expect(aligned.casters.wall).toBe(0);
    expectShadows(turned, 'wallNone', 'boxNone');
    expect(isActive).toBe(false);
  });

  test('settings and files change while it runs', async () => {
    const { states, refusal } = await play<{ states: SceneFactors[]; refusal: string }>('runTime', backend);
    // After the second file, the light is where the app has set it.
    const shadowed = [['wallA'], ['wallA'], ['wallB'], ['wallA'], ['wallA']];
    states.forEach((seen, i) => expectShadows(seen, ...shadowed[i]!));
    expect(states.map(({ casters }) => casters.wall > 0)).toEqual([false, false, false, true, false]);
    expect(refusal).toBe('RangeError');
  });

  test('an app may go on as if there were no file', async () => {
    type Name = 'atFirst' | 'late' | 'followed' | 'two' | 'other' | 'frozen' | 'night' | 'disposed';
    const { clones, ...states } = await play<Record<Name, SceneFactors> & { clones: number }>('afterwards', backend);
    for (const each of ['atFirst', 'late', 'two', 'frozen'] as const) {
      expectShadows(states[each], 'wallA', 'boxA');
      expect(states[each].casters.wall).toBe(0);
    }
    expect(clones).toBeGreaterThan(0);
    expectShadows(states.followed, 'wallA', 'boxA');
    expectShadows(states.other, 'wallB', 'boxB');
    expectShadows(states.night, 'wallNone', 'boxNone');
    expect(states.night.casters.wall).toBeGreaterThan(0);
    // With WebGLRenderer the shadow is the scene's.
    expectShadows(states.disposed, ...(backend === 'webgl' ? ['wallA'] : []));
    expect(complaints.splice(0)).toEqual([expect.stringContaining("'DirectionalLight' was turned")]);
  });

  test('all kinds of surfaces have the same shadows', async () => {
    const { shadowed, off } = await play<{ shadowed: number; off: Record<string, number> }>('materials', backend);
    expect(shadowed).toBeGreaterThan(100);
    expect(off).toSatisfy((all: typeof off) => Object.values(all).every((count) => count <= 8));
    expect(Object.keys(off)).toHaveLength(6);
  });

  test.each([
    ['city.glb', undefined],
    ['filtered.glb', 9],
  ] as const)('the light of %s has its file', async (name, filter) => {
    const { off, shadowed, pixels, ...rest } = await play<Record<'off' | 'shadowed' | 'pixels', number>>('gltf', backend, name);
    expect(rest).toEqual({ lights: 1, ofScene: true, ...(filter === undefined ? {} : { filter }) });
    expect(shadowed).toBeGreaterThan(pixels / 20);
    expect(shadowed).toBeLessThan((pixels * 19) / 20);
    expect(off).toBeLessThanOrEqual(pixels / 500);
  });

  test('refuses files that are no shadow files, and goes on drawing', async () => {
    const wanted = {
      'empty.adumbra': 'Truncated',
      'header.adumbra': 'Truncated',
      'truncated.adumbra': 'Truncated',
      'longer.adumbra': 'TrailingBytes',
      'damaged.adumbra': 'SectionChecksum',
      'page.adumbra': 'Magic',
      'picture.adumbra': 'Magic',
      'world.obj': 'Magic',
    };
    const { before, errors, after, another } = await play<{
      before: SceneFactors;
      errors: Record<string, Rejection>;
      after: SceneFactors;
      another: SceneFactors;
    }>('badFiles', backend, Object.keys(wanted));
    expect(Object.fromEntries(Object.entries(errors).map(([url, { kind }]) => [url, kind]))).toEqual(wanted);
    for (const [name, error] of Object.entries(errors)) {
      expect(error).toMatchObject({ name: 'ShadowFileError', url: `/files/${name}` });
      expect(error.message).toContain(`/files/${name}: `);
    }
    expectShadows(before, 'wallA');
    expectShadows(after, 'wallA');
    expectShadows(another, 'wallB');
  });
});

describe.each(NODE_BACKENDS)('%s', (backend) => {
  test('CSMShadowNode has the shadows of moving objects', async () => {
    const { beside, turned, gone, lightsLeft } = await play<{ beside: SceneFactors; turned: SceneFactors; gone: SceneFactors; lightsLeft: number }>(
      'cascades',
      backend,
    );
    expectShadows(beside, 'wallA', 'boxA');
    expect(beside.casters.wall).toBe(0);
    expectShadows(turned, 'wallNone', 'boxNone');
    expectShadows(gone);
    expect(lightsLeft).toBe(4);
  });

  test('a light that stops casting for a while has its file afterwards, and another one in its place', async () => {
    const [on, off, again, other, gone] = await play<SceneFactors[]>('switchedOff', backend);
    expectShadows(on!, 'wallA', 'boxA');
    expectShadows(off!);
    expectShadows(again!, 'wallA', 'boxA');
    expectShadows(other!, 'wallB', 'boxB');
    expectShadows(gone!);
    expect([again, other].map((each) => each!.casters.wall)).toEqual([0, 0]);
    expect(again!.casters.mover).toBeGreaterThan(0);
  });

  test('has the shadows after compileAsync', async () => {
    expectShadows(await play<SceneFactors>('compileAsync', backend), 'wallA');
  });
});

test.each(Object.entries(VERSIONS).filter(([version]) => IS_FULL || version !== '0.183.0'))('CSM of the addons of %s has the shadows of moving objects', async (_, three) => {
  // It changes three's chunks for the whole page.
  const other = await stage.open(three, 'scene.js');
  const seen = await playOn<Record<'beside' | 'faded' | 'alone' | 'turned' | 'gone', SceneFactors>>(other.page, 'cascadesOfWebGL');
  for (const each of [seen.beside, seen.faded]) {
    expectShadows(each, 'wallA', 'boxA');
    expect(each.casters.mover).toBeGreaterThan(0);
    expect(each.casters.wall).toBe(0);
  }
  expectShadows(seen.alone, 'wallA');
  expectShadows(seen.turned, 'wallNone');
  expect(seen.turned.casters.wall).toBeGreaterThan(0);
  expectShadows(seen.gone, 'wallA');
  expect(seen.gone.casters.wall).toBeGreaterThan(0);
  expect(other.complaints).toEqual([]);
  await other.page.close();
});

/**
 * Plays that take long and find little beyond those in other renderers. They run only with `ADUMBRA_FULL`.
 */
const LONG = [
  ['0.183.0', 'movers', 'webgl'],
  ['0.183.0', 'runTime', 'webgpu'],
  ['0.183.0', 'comingAndGoing', 'webgl2'],
  ['0.183.0', 'twoLights', 'webgl2'],
  ['0.183.0', 'materials', 'webgpu'],
  ['0.183.0', 'hooks', 'webgl'],
  ['0.166.0', 'turning', 'webgl'],
  ['0.166.0', 'comingAndGoing', 'webgl'],
  ['0.166.0', 'runTime', 'webgl'],
  ['0.183.0', 'switchedOff', 'webgl2'],
  ['0.183.0', 'materials', 'webgl'],
  ['0.166.0', 'hooks', 'webgl'],
  ['0.166.0', 'twoLights', 'webgl'],
] as const;

test.each([
  ...(IS_FULL ? LONG : []),
  ['0.183.0', 'movers', 'webgpu'],
  ['0.183.0', 'compileAsync', 'webgpu'],
  ['0.166.0', 'movers', 'webgl'],
  ['0.166.0', 'filesAlone', 'webgl'],
  ['0.166.0', 'materials', 'webgl'],
  ['0.166.0', 'gltf', 'webgl', 'city.glb'],
  ['0.166.0', 'shaderMaterials'],
  ['0.166.0', 'loading'],
] as const)('three %s has the results of 0.187.0 in the play %s, on %s', async (version, name, ...options) => {
  const other = await stage.open(VERSIONS[version], 'scene.js');
  for (const on of [other.page, page]) await on.route('**/never*', () => undefined);
  const found = await playOn(other.page, name, ...options);
  expect(found).toEqual(played.get(JSON.stringify([name, ...options])) ?? (await play(name, ...options)));
  expect(other.complaints).toEqual([]);
  await other.page.close();
});

test('hooks of others in a material are called', async () => {
  type Three = Record<'red' | 'green' | 'blue', SceneFactors>;
  const states = await play<Record<'earlier' | 'gone' | 'again' | 'later' | 'laterGone', Three>>('hooks');
  const shadowed = { earlier: ['wallA'], gone: [], again: ['wallA'], later: ['wallA'], laterGone: [] };
  for (const [name, { red, green, blue }] of Object.entries(states)) {
    expectShadows(red, ...shadowed[name as keyof typeof shadowed]);
    // The ground is painted green, a patch at `open` blue, and one at `boxA` later half green.
    const painted = { wallA: 1, wallB: 1, wallNone: 1, boxA: name.startsWith('later') ? 0.5 : 0, boxB: 1, boxNone: 1, open: 0 };
    expect(green).toEqual(painted);
    expect(blue).toEqual({ ...Object.fromEntries(Object.keys(painted).map((point) => [point, 0])), open: 0.5 });
  }
});

test('the shadows of two lights may be disposed in either order', async () => {
  const { states, isRestored } = await play<{ states: number[][]; isRestored: boolean }>('disposalOrders');
  expect(states).toEqual([[0, 0], [1, 0], [1, 1], [0, 0], [0, 1], [1, 1]]);
  expect(isRestored).toBe(true);
});

test('a ShaderMaterial with three’s lights has the shadows, and one without is left alone', async () => {
  const { covered, skipped, bare, late } = await play<Record<'covered' | 'bare' | 'late', SceneFactors> & { skipped: string[] }>('shaderMaterials');
  expect(covered.wallA).toBe(0.5);
  expect(skipped).toEqual([]);
  expectShadows(bare, 'wallA');
  expectShadows(late, 'wallA');
});

test('masks of all shadows have those of the file', async () => {
  for (const version of IS_FULL ? (['0.187.0', '0.166.0'] as const) : (['0.187.0'] as const)) {
    const other = await stage.open(VERSIONS[version], 'scene.js');
    const states = await playOn<SceneFactors[]>(other.page, 'masks');
    expect(states).toHaveLength(8);
    states.forEach(({ wallA, boxA, open, wallB }, i) => {
      const visibility = [0, 0.5, 1, 1][i % 4];
      expect([wallA, boxA, open, wallB], `state ${i}`).toEqual([visibility, visibility, 1, 1]);
    });
    expect(other.complaints).toEqual([]);
    await other.page.close();
  }
});

test('a glTF file is rejected with the error of its shadow file, if the page says so', async () => {
  const other = await stage.open(VERSIONS['0.187.0'], 'scene.js');
  const missing = await playOn<Rejection>(other.page, 'gltfFails', 'missing.glb');
  expect(missing).toMatchObject({ name: 'ShadowFileError', kind: 'Io', url: '/files/nowhere/missing.adumbra' });
  expect(missing.message).toContain('/files/nowhere/missing.adumbra');
  const broken = await playOn<Rejection>(other.page, 'gltfFails', 'broken.glb');
  expect(broken).toMatchObject({ name: 'ShadowFileError', kind: 'Truncated', url: '/files/truncated.adumbra' });
  // The browser itself reports the answer 404.
  expect(other.complaints).toEqual([expect.stringContaining('404')]);
  await other.page.close();
});

test('loading is aborted, and reports its progress', async () => {
  await page.route('**/never*', () => undefined);
  const { aborted, last, byteLength } = await play<{ aborted: Rejection[]; last: number; byteLength: number }>('loading');
  expect(aborted.map(({ name }) => name)).toEqual(['AbortError', 'AbortError']);
  expect(last).toBe(byteLength);
});
