// Where an app places a file's world: moved, turned, and scaled by one number. A placed file has the same
// voxels with another grid. Counterpart of `crates/adumbra/src/grid/placement.rs`; `spec/look-up-texture.md`,
// "Placement".

import type { LightGrid } from './light-grid.js';
import { cross, dot, map3 } from './vec3.js';
import type { Mat3, Vec3 } from './vec3.js';

/** A matrix from a file's world to the app's, column by column, as the `elements` of a `Matrix4` are. */
export type WorldFromFile = ArrayLike<number>;

/**
 * Returns the grid in the app's world. If the app has not placed the file, it is the file's own grid.
 *
 * @throws RangeError if the matrix does anything but move, turn, and scale by one number.
 */
export function placedGrid(grid: LightGrid, worldFromFile: WorldFromFile | undefined): LightGrid {
  if (worldFromFile === undefined) return grid;
  /**
   * Largest relative difference between scales, and largest cosine between axes, that rounding of products of
   * 32-bit matrices may cause.
   */
  const TOLERANCE = 1e-5;
  const column = (number: number): Vec3 => [0, 1, 2].map((row) => worldFromFile[4 * number + row]) as unknown as Vec3;
  const columns: Mat3 = [column(0), column(1), column(2)];
  const origin = column(3);
  const lengths = map3(columns, (axis) => Math.sqrt(dot(axis, axis)));
  const scale = (lengths[0] + lengths[1] + lengths[2]) / 3;
  const [x, y, z] = columns.map((axis) => map3(axis, (c) => c / scale)) as unknown as Mat3;
  const volume = dot(cross(x, y), z);
  const cosine = Math.max(...[dot(x, y), dot(y, z), dot(z, x)].map(Math.abs));
  const refuse = (what: string): never => {
    throw new RangeError(`a placement moves, turns, and scales alike along all axes, but this one ${what}; apply that to the scene before it is baked`);
  };
  if (![...lengths, ...origin].every(isFinite) || Math.min(...lengths) === 0) refuse('is not finite or has no size');
  if (Math.max(...lengths) > Math.min(...lengths) * (1 + TOLERANCE)) refuse(`scales by ${lengths.join(', ')}`);
  if (cosine > TOLERANCE) refuse('shears');
  if (volume < 0) refuse('mirrors');

  const toWorld = (d: Vec3): Vec3 => map3(d, (_, a) => (columns[0][a] * d[0] + columns[1][a] * d[1] + columns[2][a] * d[2]) / scale);
  const back = [cross(y, z), cross(z, x), cross(x, y)].map((row) => map3(row, (c) => c / volume)) as unknown as Mat3;
  const turned = (axis: Vec3): Vec3 => map3(axis, (_, a) => axis[0] * back[0][a] + axis[1] * back[1][a] + axis[2] * back[2][a]);
  const axes = grid.axes.map(turned) as unknown as Mat3;
  const voxelSize = grid.voxelSize * scale;
  const sun = toWorld(grid.sun);
  const length = Math.sqrt(dot(sun, sun));
  return {
    ...grid,
    sun: map3(sun, (c) => c / length),
    voxelSize,
    corner: map3(grid.corner, (c, a) => c + dot(axes[a], origin) / voxelSize),
    axes,
    edges: grid.edges.map(toWorld) as unknown as Mat3,
  };
}
