// Levels of detail of one file.

import { describe, expect, it } from 'vitest';

import { toWorld } from '../../src/grid/light-grid.js';
import { BakedShadowFile, Sampler } from '../../src/index.js';
import { scatter, validBytes } from './vectors.js';

const file = new BakedShadowFile(validBytes('levels_depths'));

it('each level is a file with the levels coarser than it', () => {
  expect(file.levelCount).toBe(3);
  expect(file.level(0)).toBe(file);
  for (let n = 0; n < 3; n++) {
    const level = file.level(n)!;
    expect(level).toBeInstanceOf(BakedShadowFile);
    expect(level.levelCount).toBe(3 - n);
    expect(level.grid.voxelSize).toBe(0.25 * 4 ** n);
    expect(level.settings).toEqual({ ...file.settings, resolution: Math.ceil(file.settings.resolution / 4 ** n) });
    expect(level.level(2 - n)).toBe(file.level(2));
    expect(level.level(3 - n)).toBeUndefined();
  }
  expect(file.level(-1)).toBeUndefined();
});

it('a file of one level has no coarser level', () => {
  const one = new BakedShadowFile(validBytes('sphere_depths'));
  expect(one.levelCount).toBe(1);
  expect(one.level(1)).toBeUndefined();
});

describe.each([[1, 0.9], [2, 0.85]])('level %i', (n, share) => {
  it(`answers as the finest one does at ${100 * share} % of points`, () => {
    const [fine, coarse] = [file, file.level(n)!].map((level) => new Sampler(level, { filter: 1 })) as [Sampler, Sampler];
    const random = scatter(n);
    const { size } = file.grid;
    let [alike, lit] = [0, 0];
    for (let i = 0; i < 2000; i++) {
      const [x, y, z] = toWorld(file.grid, [size[0] * random(), size[1] * random(), size[2] * random()]);
      const wanted = fine.pointVisibility({ x, y, z });
      lit += wanted;
      alike += Number(coarse.pointVisibility({ x, y, z }) === wanted);
    }
    expect(lit).toBeGreaterThan(300);
    expect(lit).toBeLessThan(1700);
    expect(alike / 2000).toBeGreaterThan(share);
  });
});
