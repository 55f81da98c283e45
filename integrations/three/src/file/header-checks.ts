// Checks of the header's fields. Each is written so that a NaN anywhere fails.

import { obliqueAxes } from '../grid/light-grid.js';
import type { LightGrid } from '../grid/light-grid.js';
import { cross, dot } from '../grid/vec3.js';
import type { Vec3 } from '../grid/vec3.js';
import type { FileSettings } from '../settings.js';
import { check } from './faults.js';

/** Tolerance for unit vectors and axes: far above rounding errors, and far below a texel. */
const UNIT_TOLERANCE = 1e-9;

/** Checks the fields that say how the file was baked. */
export function checkSettings({ resolution, thicknessWorld, bias, bounds }: FileSettings): void {
  check(resolution > 0, 'resolution', resolution, 'at least 1');
  check(isFinite(thicknessWorld) && thicknessWorld >= 0, 'thickness', thicknessWorld, 'a finite number, zero or more');
  checkFinite('bias', [bias.constantTexels, bias.slopeTexels, bias.normalOffsetTexels]);
  if (bounds === null) return;
  const { min, max } = bounds;
  const isGood = [...min, ...max].every(isFinite) && min.every((c, a) => c <= max[a as 0 | 1 | 2]);
  check(isGood, 'bounds', `${min}, ${max}`, 'finite, with no minimum above its maximum');
}

/** Checks the fields that place the grid in the world. */
export function checkGrid(grid: LightGrid): void {
  const { size, voxelSize, corner, axes, frame } = grid;
  check(!size.includes(0), 'size', size, 'at least 1 along each axis');
  check(isFinite(voxelSize) && voxelSize > 0, 'voxel_size', voxelSize, 'a finite number above zero');
  checkFinite('corner', corner);
  if (frame === 'light') {
    check(isAlongLight(grid), 'axes', axes.join(), 'orthonormal, right-handed, the third away from the sun');
  } else check(isUpright(grid), 'axes', axes.join(), 'those of the oblique frame for this sun and yaw');
}

function checkFinite(name: string, values: Vec3): void {
  check(values.every(isFinite), name, values, 'finite numbers');
}

/** Whether two numbers that follow from unit vectors are the same. */
export function isNear(value: number, wanted: number): boolean {
  return Math.abs(value - wanted) <= UNIT_TOLERANCE;
}

function isAlongLight({ axes, sun }: LightGrid): boolean {
  const [x, y, z] = axes;
  return (
    axes.every((axis) => isNear(dot(axis, axis), 1)) &&
    isNear(dot(x, y), 0) &&
    isNear(dot(y, z), 0) &&
    isNear(dot(z, x), 0) &&
    dot(cross(x, y), z) > 0 &&
    sun.every((c, a) => isNear(z[a as 0 | 1 | 2], -c))
  );
}

function isUpright({ axes, sun, yawRadians }: LightGrid): boolean {
  const expected = obliqueAxes(sun, yawRadians).flat();
  // Under a low sun the shear is large.
  return axes.flat().every((c, i) => Math.abs(c - expected[i]) <= UNIT_TOLERANCE * (1 + Math.abs(expected[i])));
}
