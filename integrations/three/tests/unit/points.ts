// Points and normals that exercise look-ups in a file: near the depths at which columns switch, all over the
// grid and outside of it, with normals of every kind.

import { toWorld } from '../../src/grid/light-grid.js';
import { Sampler } from '../../src/index.js';
import type { BakedShadowFile, Vec3 } from '../../src/index.js';
import { scatter } from './vectors.js';

/** Points in world space with a normal each, three numbers per point. Normals are 32-bit floating-point numbers. */
export interface Surfaces {
  readonly points: Float64Array;
  readonly normals: Float32Array;
}

/** Returns `count` points of a file. They follow from `seed`. */
export function surfacesOf(file: BakedShadowFile, count: number, seed: number): Surfaces {
  const random = scatter(seed);
  const sampler = new Sampler(file, { filter: 1 });
  const points = new Float64Array(3 * count);
  const normals = new Float32Array(3 * count);
  const { size, sun } = file.grid;
  for (let i = 0; i < count; i++) {
    const kind = random();
    let p: Vec3;
    if (kind < 0.02) {
      p = [NaN, Infinity, -Infinity].map((c) => (random() < 0.5 ? c : 1)) as unknown as Vec3;
    } else {
      const spread = kind < 0.2 ? 1.4 : 1.01;
      const [u, v, w] = [0, 1, 2].map((a) => size[a as 0 | 1 | 2] * (0.5 + spread * (random() - 0.5)));
      // Most points are within a few voxels of where their column switches.
      const depth = kind < 0.3 ? w : switchDepth(sampler, u, v) + 6 * (random() - 0.5);
      p = toWorld(file.grid, [u, v, depth]);
    }
    points.set(p, 3 * i);
    normals.set(normalOf(random, sun), 3 * i);
  }
  return { points, normals };
}

/** Returns a depth at which the column of a grid position switches, found by bisection. */
function switchDepth(sampler: Sampler, u: number, v: number): number {
  const { grid } = sampler.file;
  let lit = -1;
  let dark = grid.size[2];
  while (dark - lit > 0.5) {
    const middle = (lit + dark) / 2;
    const [x, y, z] = toWorld(grid, [u, v, middle]);
    if (sampler.pointVisibility({ x, y, z }) === 1) lit = middle;
    else dark = middle;
  }
  return lit;
}

function normalOf(random: () => number, sun: Vec3): Vec3 {
  const kind = random();
  if (kind < 0.02) return [NaN, 0, 1];
  if (kind < 0.04) return [0, 0, 0];
  if (kind < 0.3) return [0, 1, 0];
  if (kind < 0.4) return sun;
  // Along the sun's compass direction: walls that the light grazes.
  if (kind < 0.5) return [sun[2], 0, -sun[0]];
  if (kind < 0.6) return random() < 0.5 ? [1, 0, 0] : [0, 0, -1];
  const n = [random() - 0.5, random() - 0.5, random() - 0.5];
  const length = Math.hypot(...n);
  return [n[0] / length, n[1] / length, n[2] / length];
}
