// Look-ups on the CPU, on their own: worked values of the specification, and the layouts against each other.

import { describe, expect, it } from 'vitest';

import { BakedShadowFile, BakedShadowQuery, FILTER_WIDTHS } from '../../src/index.js';
import type { FilterWidth, LightGrid } from '../../src/index.js';
import { layerAt, receiverAt } from '../../src/query/receiver.js';
import { surfacesOf } from './points.js';
import { caught, validBytes } from './vectors.js';

function open(name: string): BakedShadowFile {
  return new BakedShadowFile(validBytes('valid', name));
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

  it('is held near the grid, and before it if it is not finite', () => {
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
  for (const name of ['example_8', 'example_8_packed', 'example_8_depths']) {
    expect(new BakedShadowQuery(open(name), { filter: 1 }).pointVisibility({ x, y, z }), name).toBe(visibility);
  }
});

describe.each(['cliff', 'low_sun_tall', 'odd_sizes', 'slopes', 'terraces', 'upright', 'upright_turned_low'])(
  '%s',
  (name) => {
    it.each(FILTER_WIDTHS)('has the same answers in every layout at filter %i', (filter) => {
      const plain = open(name);
      const { points, normals } = surfacesOf(plain, 2000, filter);
      const answers = new BakedShadowQuery(plain, { filter }).visibilities(points, normals);
      expect(new Set(answers).size).toBeGreaterThan(1);
      for (const layout of ['packed', 'depths']) {
        const query = new BakedShadowQuery(open(`${name}_${layout}`), { filter });
        expect(query.visibilities(points, normals), layout).toEqual(answers);
      }
    });
  },
);

it('points one by one have the answers of all at once', () => {
  const file = open('upright_turned_low_depths');
  const { points, normals } = surfacesOf(file, 500, 7);
  const query = new BakedShadowQuery(file, { filter: 5 });
  const together = query.visibilities(points, normals);
  const at = (all: ArrayLike<number>, i: number) => ({ x: all[3 * i], y: all[3 * i + 1], z: all[3 * i + 2] });
  together.forEach((answer, i) => expect(query.visibility(at(points, i), at(normals, i))).toBe(answer));
  const airborne = query.visibilities(points);
  airborne.forEach((answer, i) => expect(query.visibility(at(points, i))).toBe(answer));
});

it('a filter of another width is refused', () => {
  const filter = 4 as FilterWidth;
  expect(caught(() => new BakedShadowQuery(open('sphere'), { filter }))).toBeInstanceOf(RangeError);
});
