// Look-ups on the CPU, on their own: worked values of the specification, and filters tap by tap.

import { Matrix4, Quaternion, Vector3 } from 'three';
import { describe, expect, it } from 'vitest';

import { toWorld } from '../../src/grid/light-grid.js';
import { BakedShadowFile, FILTER_WIDTHS, LOOK_UP_DEFAULTS, Sampler } from '../../src/index.js';
import type { FilterWidth, LightGrid, LookUpOptions, Vec3 } from '../../src/index.js';
import { BAKED_SHADOW_DEFAULTS } from '../../src/light/options.js';
import { layerAt, receiverAt } from '../../src/sampler/receiver.js';
import { surfacesOf } from './points.js';
import { caught, validBytes } from './vectors.js';

function open(name: string): BakedShadowFile {
  return new BakedShadowFile(validBytes(name));
}

/** A grid that is the world. */
function plainGrid(size: LightGrid['size']): LightGrid {
  const axes = [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ] as const;
  return { sun: [0, 1, 0], frame: 'light', yawRadians: 0, voxelSize: 1, corner: [0, 0, 0], axes, edges: axes, size };
}

/** The texel of a coordinate in fixed point. */
const texel = (fixed: number): number => Math.floor(fixed / 4096);

const NO_BIAS = { constantTexels: 0, slopeTexels: 0, normalOffsetTexels: 0 };

describe('a receiver', () => {
  it('passes texels in the layers of the worked value', () => {
    // dz/dx = 0.5, dz/dy = 0.
    const receiver = receiverAt(plainGrid([64, 64, 64]), NO_BIAS, [7.5, 4.5, 20.25], [1, 0, -2]);
    expect([receiver.x, receiver.y].map(texel)).toEqual([7, 4]);
    expect([6, 7, 8].map((x) => layerAt(receiver, x, 3))).toEqual([19, 20, 20]);
  });

  it('is clamped near the grid, and before it if it is not finite', () => {
    const place = (p: [number, number, number]) => {
      const receiver = receiverAt(plainGrid([8, 16, 516_096]), NO_BIAS, p, undefined);
      return [texel(receiver.x), texel(receiver.y), layerAt(receiver, 0, 0)];
    };
    expect(place([1e30, -1e30, 1e30])).toEqual([8 + 4096, -4096, 516_096 + 4096]);
    expect(place([1, Infinity, 1])).toEqual([-4096, -4096, -4096]);
    expect(place([-0.00001, 2.999999, 0.5])).toEqual([-1, 2, 0]);
  });
});

it.each([
  [[2.25, 6.25, 7.5], 1],
  [[2.5, 5.5, 3.5], 1],
  [[5.5, 5.5, 3.5], 0],
  [[5.5, 5.5, 7.5], 1],
  [[4.25, 0.25, 2.5], 0],
  [[8.5, 0.5, 1.5], 1],
  [[5.5, 9, 1.5], 1],
  [[5.5, -3, 1.5], 0],
])('the example of the specification answers %j with %i', ([x, y, z], visibility) => {
  expect(new Sampler(open('example_8_depths'), { filter: 1 }).pointVisibility({ x, y, z })).toBe(visibility);
});

describe.each(['cliff', 'levels', 'low_sun_tall', 'many_pages', 'odd_sizes', 'slopes', 'terraces', 'upright', 'upright_turned_low'])('%s', (name) => {
  it.each(FILTER_WIDTHS)('has the share of lit taps at filter %i', (filter) => {
    const file = open(`${name}_depths`);
    const { points, normals } = surfacesOf(file, 300, filter);
    const sampler = new Sampler(file, { filter });
    const answers = sampler.visibilities(points, normals);
    expect(new Set(answers).size).toBeGreaterThan(1);
    answers.forEach((answer, i) => expect(answer).toBe(litShare(sampler, at(points, i), at(normals, i))));
  });
});

/** The share of lit taps of a point, each looked up on its own at the middle of its voxel. */
function litShare(sampler: Sampler, point: Vec3, normal: Vec3): number {
  const { file: { grid }, filter, bias } = sampler;
  const receiver = receiverAt(grid, bias, point, normal);
  const reach = (filter - 1) / 2;
  let lit = 0;
  for (let y = texel(receiver.y) - reach; y <= texel(receiver.y) + reach; y++) {
    for (let x = texel(receiver.x) - reach; x <= texel(receiver.x) + reach; x++) {
      const [worldX, worldY, worldZ] = toWorld(grid, [x + 0.5, y + 0.5, layerAt(receiver, x, y) + 0.5]);
      lit += sampler.pointVisibility({ x: worldX, y: worldY, z: worldZ });
    }
  }
  return Math.fround(lit / filter ** 2);
}

/** The numbers of one point. */
function at(all: ArrayLike<number>, i: number): Vec3 {
  return [all[3 * i]!, all[3 * i + 1]!, all[3 * i + 2]!];
}

it('has a filter of 5 × 5 texels unless another is set', () => {
  expect(BAKED_SHADOW_DEFAULTS.filter).toBe(LOOK_UP_DEFAULTS.filter);
  const file = open('slopes_depths');
  const { points, normals } = surfacesOf(file, 300, 3);
  const expected = new Sampler(file, { filter: 5 }).visibilities(points, normals);
  for (const sampler of [new Sampler(file), new Sampler(file, { filter: undefined })]) {
    expect(sampler.filter).toBe(5);
    expect(sampler.visibilities(points, normals)).toEqual(expected);
  }
});

it('points one by one have the answers of all at once', () => {
  const file = open('upright_turned_low_depths');
  const { points, normals } = surfacesOf(file, 500, 7);
  const sampler = new Sampler(file, { filter: 5 });
  const together = sampler.visibilities(points, normals);
  const named = (all: ArrayLike<number>, i: number) => new Vector3(...at(all, i));
  together.forEach((answer, i) => expect(sampler.visibility(named(points, i), named(normals, i))).toBe(answer));
  const airborne = sampler.visibilities(points);
  airborne.forEach((answer, i) => expect(sampler.visibility(named(points, i))).toBe(answer));
});

it.each([
  ['moved far', new Matrix4().makeTranslation(250_000, 10, -480_000)],
  ['upside down', new Matrix4().makeRotationX(Math.PI)],
  ['a model on a table', new Matrix4().makeScale(0.01, 0.01, 0.01).setPosition(0.4, 0.7, -0.3)],
  ['larger, tilted and moved', new Matrix4().compose(new Vector3(100, -40, 15), new Quaternion(-0.5, 0.4, 0.1, 0.7).normalize(), new Vector3(8.5, 8.5, 8.5))],
])('%s, look-ups answer in the app as in the file', (_, matrix) => {
  const file = open('upright_turned_low_depths');
  const { points, normals } = surfacesOf(file, 1000, 9);
  const options: LookUpOptions = { filter: 5, bias: { constantTexels: 0.7, slopeTexels: 1.3, normalOffsetTexels: 0.4 } };
  const placed = new Sampler(file, { ...options, placement: matrix.elements });
  const expected = new Sampler(file, options).visibilities(points, normals);
  expect(new Set(expected).size).toBeGreaterThan(5);
  const toWorld = (all: ArrayLike<number>, i: number): Vector3 => new Vector3(...at(all, i));
  expected.forEach((answer, i) => {
    const normal = toWorld(normals, i);
    if (normal.length() > 0) normal.transformDirection(matrix);
    expect(placed.visibility(toWorld(points, i).applyMatrix4(matrix), normal)).toBe(answer);
  });
});

it('a filter of another width is refused', () => {
  const filter = 4 as FilterWidth;
  expect(caught(() => new Sampler(open('sphere_depths'), { filter }))).toBeInstanceOf(RangeError);
});
