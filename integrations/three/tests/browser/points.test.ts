// Compares three's pictures with baked shadows with look-ups on the CPU: three back ends, all settings,
// materials, kinds of objects and depth buffers. A pixel may differ where a position in 32-bit floats falls
// into the next texel: at most 0.2 % of them, by at most one row of taps.

import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

import { decode } from 'fast-png';
import type { Page } from 'playwright-core';
import { Euler, Matrix4, Quaternion, Vector3 } from 'three';
import { afterAll, beforeAll, describe, expect, test } from 'vitest';

import { BakedShadowFile, Sampler } from '../../src/index.js';
import type { Bias, FilterWidth, LookUpOptions } from '../../src/index.js';
import { Stage, VERSIONS } from './stage.js';

const IS_FULL = process.env['ADUMBRA_FULL'] !== undefined;
const SIDE = 256;
const BACKENDS = ['webgpu', 'webgl2', 'webgl'] as const;
const SUN = '0.5,0.8,0.35';

/** The picture that a page should draw. */
interface Task {
  backend: (typeof BACKENDS)[number];
  files: string[];
  lookUp: string;
  settings?: object;
  later?: object[];
  material?: string;
  object?: string;
  transparent?: boolean;
  side?: string;
  depth?: string;
  morphs?: boolean;
  clips?: boolean;
  eyes?: boolean;
  loses?: boolean;
  cycles?: number;
  placements?: number[][];
  rig?: number;
  height?: number;
}

const SQUARE = { height: 0.25, middle: [0, 0] as const, width: 120 };

let folder: string;
let stage: Stage;
let page: Page;
let complaints: string[];

/** Angle of the sun in the pictures of penumbrae, degrees. */
const ANGLE = 8;
/** Pixels from the middle within which the tower's roof is seen. */
const TOWER = 32;
/** A tower on level ground. */
const TOWER_OBJ = `v -100 0 -100\nv 100 0 -100\nv 100 0 100\nv -100 0 100\nf 4 3 2 1
v -8 0 -8\nv 8 0 -8\nv 8 0 8\nv -8 0 8\nv -8 40 -8\nv 8 40 -8\nv 8 40 8\nv -8 40 8
f 12 11 10 9\nf 5 6 10 9\nf 6 7 11 10\nf 7 8 12 11\nf 8 5 9 12\n`;

/** The program that bakes. */
const program = process.env['ADUMBRA_BIN'];

function bake(name: string, ...options: string[]): void {
  const scene = join(folder, 'city.glb');
  execFileSync(program!, ['bake', scene, '--sun', SUN, '-o', join(folder, name), '--resolution', '2048', ...options]);
}

beforeAll(async () => {
  if (program === undefined) throw new Error('the browser tests need the program: ADUMBRA_BIN=…/adumbra');
  folder = mkdtempSync(join(tmpdir(), 'adumbra-three-'));
  execFileSync(program, ['generate', 'city', '-o', join(folder, 'city.glb')]);
  bake('city.adumbra');
  bake('light.adumbra', '--frame', 'light');
  bake('other.adumbra', '--bounds', '-70,-10,-70,70,100,70', '--frame', 'light');
  bake('low.adumbra', '--bounds', '-300,-10,-300,2,100,300');
  bake('high.adumbra', '--bounds', '-2,-10,-300,300,100,300');
  writeFileSync(join(folder, 'tower.obj'), TOWER_OBJ);
  execFileSync(program, ['bake', join(folder, 'tower.obj'), '--sun', SUN, '-o', join(folder, 'tower.adumbra'), '--resolution', '2048']);
  stage = await Stage.start(folder);
  ({ page, complaints } = await stage.open(VERSIONS['0.187.0'], 'points.js'));
});

afterAll(async () => {
  await stage?.stop();
  rmSync(folder, { recursive: true, force: true });
});

async function draw(task: Task, on: Page = page): Promise<{ pictures: Float32Array[]; memory: object[] }> {
  const files = task.files.map((name) => `/files/${name}`);
  const { visibility, memory } = await on.evaluate(
    (drawn) => (window as unknown as { draw(task: object): Promise<Drawn> }).draw(drawn),
    { ...SQUARE, ...task, files },
  );
  const pictures = visibility.map((text) => new Float32Array(new Uint8Array(Buffer.from(text, 'base64')).buffer));
  return { pictures, memory };
}

/** The visibility of the ground around the tower, as the program draws it. */
function rendered(): Float32Array {
  const picture = join(folder, 'tower.png');
  execFileSync(program!, [
    ...['render', join(folder, 'tower.obj'), '--shadow-file', join(folder, 'tower.adumbra')],
    ...['--shadow', `voxel:soft:sun-degrees=${ANGLE}`, '--layer', 'shadow', '--antialias', '1', '--size', `${SIDE}x${SIDE}`],
    ...['--eye=0,90,0.01', '--target=0,0,0', '--ortho', String(SQUARE.width), '-o', picture],
  ]);
  const { data, channels } = decode(readFileSync(picture));
  return Float32Array.from({ length: SIDE * SIDE }, (_, i) => data[channels * i]! / 255);
}

/** The means of blocks of pixels. */
function means(picture: Float32Array, block: number): Float32Array {
  const side = SIDE / block;
  const sums = new Float32Array(side * side);
  picture.forEach((value, i) => {
    sums[side * Math.floor(i / SIDE / block) + Math.floor((i % SIDE) / block)]! += value / block ** 2;
  });
  return sums;
}

interface Drawn {
  visibility: string[];
  memory: object[];
}

function read(name: string): BakedShadowFile {
  const bytes = readFileSync(join(folder, name));
  return new BakedShadowFile(bytes);
}

/**
 * The visibility of each pixel's point, by look-ups on the CPU. The points have the placement of the file.
 */
function expected(file: BakedShadowFile, options: LookUpOptions): Float32Array {
  const sampler = new Sampler(file, options);
  const across = (n: number) => ((n + 0.5) / SIDE - 0.5) * SQUARE.width;
  const placement = new Matrix4().fromArray(options.placement ?? new Matrix4().elements);
  const normal = new Vector3(0, 1, 0).transformDirection(placement);
  return Float32Array.from({ length: SIDE * SIDE }, (_, i) => {
    const point = new Vector3(across(i % SIDE), SQUARE.height, across(Math.floor(i / SIDE)));
    return sampler.visibility(point.applyMatrix4(placement), normal);
  });
}

/** Ten places that an app may give a file: moved, turned, scaled, and all of that. */
const PLACEMENTS = [
  [[0, 0, 0], [0, 0, 0], 1],
  [[100, -20, 3000], [0, 0, 0], 1],
  [[0, 0, 0], [0, 1.1, 0], 1],
  [[0, 0, 0], [-Math.PI / 2, 0, 0], 1],
  [[0, 0, 0], [0, 0, 0], 0.01],
  [[0, 0, 0], [0, 0, 0], 100],
  [[5, 7, -9], [0.3, -2, 0.5], 1],
  [[-40, 2, 16], [0, 0.4, 0], 0.1],
  [[1000, 0, -500], [1, 2, 3], 0.5],
  [[-3, 0.5, 8], [-0.2, 0.1, 2.8], 3.28084],
].map(([position, angles, scale]) =>
  new Matrix4().compose(
    new Vector3(...(position as [number, number, number])),
    new Quaternion().setFromEuler(new Euler(...(angles as [number, number, number]))),
    new Vector3().setScalar(scale as number),
  ).elements,
);

function expectAlike(found: Float32Array, wanted: Float32Array, filter: number): void {
  let [off, most, shadowed] = [0, 0, 0];
  wanted.forEach((value, i) => {
    const difference = Math.abs(found[i]! - value);
    off += Number(!(difference <= 0.004));
    most = Math.max(most, Number.isNaN(difference) ? Infinity : difference);
    shadowed += Number(value < 0.5);
  });
  expect(shadowed).toBeGreaterThan(wanted.length / 20);
  expect(shadowed).toBeLessThan((wanted.length * 19) / 20);
  expect({ off, most }).toSatisfy(() => off * 500 <= wanted.length && most <= 1 / filter + 0.004);
}

const alike = (name: string, found: Float32Array, filter: FilterWidth, bias?: Bias): void =>
  expectAlike(found, expected(read(name), bias === undefined ? { filter } : { filter, bias }), filter);

/**
 * The WebGL2 fallback of WebGPURenderer builds its materials from the same nodes as WebGPU, so it runs with
 * all of them only with `ADUMBRA_FULL`.
 */
const KINDS_OF_FALLBACK: Partial<Task>[] = [{ material: 'physical' }, { object: 'batched' }, { depth: 'logarithmic' }, { depth: 'reversed' }];
const KINDS: Partial<Task>[] = [
  ...KINDS_OF_FALLBACK,
  { material: 'lambert' },
  { material: 'phong' },
  { material: 'toon' },
  { object: 'instanced' },
  { object: 'skinned' },
  { transparent: true },
  { side: 'double' },
  { morphs: true, clips: true, eyes: true },
];

describe.each(BACKENDS)('%s', (backend) => {
  test.each(['city.adumbra', 'light.adumbra'])('draws what %s answers', async (name) => {
    const { pictures } = await draw({ backend, files: [name], lookUp: 'filtered', settings: { filter: 5 } });
    alike(name, pictures[0]!, 5);
  });

  test('follows filter and bias', async () => {
    const files = ['city.adumbra'];
    const bias = { constantTexels: 4, slopeTexels: 2, normalOffsetTexels: 1 };
    const later = [{ filter: 1 }, { filter: 9, bias }];
    const { pictures } = await draw({ backend, files, lookUp: 'filtered', later });
    alike(files[0]!, pictures[0]!, 5);
    alike(files[0]!, pictures[1]!, 1);
    alike(files[0]!, pictures[2]!, 9, bias);
  });

  test('follows its root, and that of its copy', async () => {
    const task = { backend, files: ['city.adumbra'], lookUp: 'filtered', settings: { filter: 5 } };
    const { pictures } = await draw({ ...task, placements: PLACEMENTS });
    expect(pictures).toHaveLength(1 + PLACEMENTS.length);
    const file = read('city.adumbra');
    PLACEMENTS.forEach((placement, i) => expectAlike(pictures[i + 1]!, expected(file, { filter: 5, placement }), 5));
  });

  test('softens as the program does', async () => {
    const settings = { sunDegrees: ANGLE };
    const task = { backend, files: ['tower.adumbra'], lookUp: 'soft', settings, height: 0 };
    const found = (await draw(task)).pictures[0]!;
    const wanted = rendered();
    // The noise of penumbrae turns with the pixel, which WebGL counts from the bottom: there it differs, its
    // means do not.
    const block = backend === 'webgpu' ? 1 : 8;
    const [a, b] = [means(found, block), means(wanted, block)];
    let [off, most, partial, compared] = [0, 0, 0, 0];
    a.forEach((value, i) => {
      const side = SIDE / block;
      const [x, y] = [(i % side) + 0.5, Math.floor(i / side) + 0.5].map((n) => block * n - SIDE / 2) as [number, number];
      // The tower stands in the middle, and the program draws its roof.
      if (Math.hypot(x, y) < TOWER) return;
      const difference = Math.abs(value - b[i]!);
      compared += 1;
      partial += Number(b[i]! > 0.02 && b[i]! < 0.98);
      off += Number(!(difference <= 0.02));
      most = Math.max(most, difference);
    });
    console.log(`soft, ${backend}: ${off} of ${compared} differ, by at most ${most.toFixed(3)}; ${partial} are in penumbrae`);
    expect(partial).toBeGreaterThan(compared / 40);
    expect({ off, compared }).toSatisfy(() => off * 500 <= compared);
  });

  test('joins tiles without a seam', async () => {
    const files = ['low.adumbra', 'high.adumbra'];
    const { pictures } = await draw({ backend, files, lookUp: 'filtered', settings: { filter: 5 } });
    const [low, high] = files.map((name) => expected(read(name), { filter: 5 }));
    const found = pictures[0]!;
    const half = (keep: (x: number) => boolean) => (_: number, i: number) => keep(i % SIDE);
    expectAlike(found.filter(half((x) => x < 120)), low!.filter(half((x) => x < 120)), 5);
    expectAlike(found.filter(half((x) => x > 136)), high!.filter(half((x) => x > 136)), 5);
    // No seam: where they meet, the tiles, which have separate grids, answer like one file of the whole.
    const seam = half((x) => x >= 120 && x <= 136);
    const whole = expected(read('city.adumbra'), { filter: 5 }).filter(seam);
    const off = found.filter(seam).filter((value, i) => !(Math.abs(value - whole[i]!) < 0.5)).length;
    console.log(`tiles, ${backend}: ${off} of ${whole.length} differ where they meet; ${whole.filter((v) => v < 0.5).length} are in shadow`);
    expect(off).toBeLessThan(whole.length / 50);
  });

  test.each(backend === 'webgl2' && !IS_FULL ? KINDS_OF_FALLBACK : KINDS)('draws %o', async (kind) => {
    const files = ['city.adumbra'];
    const { pictures } = await draw({ backend, files, lookUp: 'filtered', settings: { filter: 5 }, ...kind });
    alike(files[0]!, pictures[0]!, 5);
  });

  test.runIf(backend === 'webgl')('has its shadows again once a context that was lost is back', async () => {
    const task = { backend, files: ['city.adumbra'], lookUp: 'filtered', settings: { filter: 5 }, loses: true };
    const { pictures } = await draw(task as Task);
    expect(pictures).toHaveLength(2);
    for (const picture of pictures) alike('city.adumbra', picture, 5);
  });

  test('leaves nothing behind when it goes, and comes back with another file', async () => {
    const files = ['city.adumbra', 'other.adumbra'];
    const task = { backend, files, lookUp: 'filtered', settings: { filter: 5 }, cycles: 10 };
    const { pictures, memory } = await draw(task);
    expect(memory).toHaveLength(10);
    for (const each of memory) expect(each).toEqual(memory[0]);
    for (const cycle of [0, 1, 8, 9]) alike(files[(cycle + 1) % 2]!, pictures[cycle + 1]!, 5);
  });

  const versions = Object.entries(VERSIONS).filter(([version]) => backend === 'webgl' || version !== '0.166.0');
  test.each(versions)('works with three %s', async (_, three) => {
    const other = await stage.open(three, 'points.js');
    const files = ['city.adumbra'];
    const { pictures } = await draw({ backend, files, lookUp: 'filtered', settings: { filter: 5 } }, other.page);
    alike(files[0]!, pictures[0]!, 5);
    expect(other.complaints).toEqual([]);
    await other.page.close();
  });
});

test.each(['0.187.0', '0.166.0'] as const)('a camera below a scaled rig sees the same with three %s', async (version) => {
  const other = await stage.open(VERSIONS[version], 'points.js');
  const task = { backend: 'webgl', files: ['city.adumbra'], lookUp: 'filtered', settings: { filter: 5 } } as const;
  const { pictures } = await draw({ ...task, files: [...task.files], rig: 2.5 }, other.page);
  alike('city.adumbra', pictures[0]!, 5);
  expect(other.complaints).toEqual([]);
  await other.page.close();
});

test('the console is silent', () => {
  expect(complaints).toEqual([]);
});
