// Checks of the header's fields. Each is written so that a NaN anywhere fails.

import { obliqueAxes } from '../grid/light-grid.js';
import type { LightGrid } from '../grid/light-grid.js';
import { cross, dot, map3 } from '../grid/vec3.js';
import type { Vec3 } from '../grid/vec3.js';
import type { FileSettings } from '../settings.js';
import { field } from './faults.js';

/** Tolerance for unit vectors and axes: far above rounding errors, and far below a texel. */
const UNIT_TOLERANCE = 1e-9;

/** Returns the number of roots along x, y, z that cover `size` voxels. */
export function rootsOf(size: Vec3, rootLevel: number): Vec3 {
  return map3(size, (n) => Math.ceil(n / 2 ** rootLevel));
}

/** Checks that the sun is a unit vector above the horizon. */
export function checkSun(sun: Vec3): void {
  if (!(Math.abs(dot(sun, sun) - 1) <= UNIT_TOLERANCE && sun[1] > 0)) {
    throw field('sun', sun, 'a unit vector with y above zero');
  }
}

/** Checks the fields that say how the file was baked. */
export function checkSettings(settings: FileSettings): void {
  const { resolution, thicknessWorld, bias, bounds } = settings;
  if (resolution === 0) throw field('resolution', resolution, 'at least 1');
  if (!(Number.isFinite(thicknessWorld) && thicknessWorld >= 0)) {
    throw field('thickness', thicknessWorld, 'a finite number, zero or more');
  }
  checkFinite('bias', [bias.constantTexels, bias.slopeTexels, bias.normalOffsetTexels]);
  if (bounds === null) return;
  const good = ([0, 1, 2] as const).every(
    (a) => Number.isFinite(bounds.min[a]) && Number.isFinite(bounds.max[a]) && bounds.min[a] <= bounds.max[a],
  );
  if (!good) throw field('bounds', `${bounds.min}, ${bounds.max}`, 'finite, with no minimum above its maximum');
}

/** Checks the fields that place the grid in the world. */
export function checkGrid(grid: LightGrid): void {
  const { size, voxelSize, corner, axes } = grid;
  if (size.includes(0)) throw field('size', size, 'at least 1 along each axis');
  if (!(Number.isFinite(voxelSize) && voxelSize > 0)) {
    throw field('voxel_size', voxelSize, 'a finite number above zero');
  }
  checkFinite('corner', corner);
  if (grid.frame === 'light') {
    if (!isAlongLight(grid)) {
      throw field('axes', axes.join(), 'orthonormal and right-handed, the third away from the sun');
    }
  } else if (!isUpright(grid)) {
    throw field('axes', axes.join(), 'those of the oblique frame for this sun and yaw');
  }
}

function checkFinite(name: string, values: Vec3): void {
  if (!values.every(Number.isFinite)) throw field(name, values, 'finite numbers');
}

function isAlongLight({ axes, sun }: LightGrid): boolean {
  const [x, y, z] = axes;
  const near = (value: number): boolean => Math.abs(value) <= UNIT_TOLERANCE;
  return (
    axes.every((axis) => near(dot(axis, axis) - 1)) &&
    near(dot(x, y)) &&
    near(dot(y, z)) &&
    near(dot(z, x)) &&
    dot(cross(x, y), z) > 0 &&
    sun.every((c, a) => near(z[a as 0 | 1 | 2] + c))
  );
}

function isUpright({ axes, sun, yawRadians }: LightGrid): boolean {
  const expected = obliqueAxes(sun, yawRadians).flat();
  // Under a low sun the shear is large.
  return axes.flat().every((c, i) => Math.abs(c - expected[i]) <= UNIT_TOLERANCE * (1 + Math.abs(expected[i])));
}
