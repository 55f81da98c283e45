// The world-to-grid transform for shaders: a grid and an anchor as 32-bit numbers. `spec/look-up-texture.md`,
// "Parameter block", has the words. Counterpart of `crates/adumbra/src/gpu/grid.rs`.

import { ShadowFileError } from '../error.js';
import { FIXED_ONE, MAX_FIXED_SIDE } from '../grid/fixed.js';
import { toGrid } from '../grid/light-grid.js';
import type { LightGrid } from '../grid/light-grid.js';
import { map3 } from '../grid/vec3.js';
import type { Vec3 } from '../grid/vec3.js';


/** The same memory as words of three types. */
export interface WordViews {
  readonly words: Uint32Array<ArrayBuffer>;
  readonly ints: Int32Array;
  readonly floats: Float32Array;
}

/**
 * Writes words 0 to 67 of the parameter block, the transform from positions relative to `anchorWorld` to the
 * grid.
 *
 * @throws ShadowFileError of the kind `TooLarge` if a side of the grid has more voxels than fit the arithmetic of
 * shaders.
 */
export function writeGridParameters({ ints, floats }: WordViews, grid: LightGrid, anchorWorld: Vec3): void {
  /** Largest length of a step, voxels. */
  const STEP_VOXELS = 8;
  const { axes, edges, voxelSize, size } = grid;
  const voxels = Math.max(...size);
  if (voxels > MAX_FIXED_SIDE) {
    throw new ShadowFileError(
      'TooLarge',
      `the grid has ${voxels} voxels along a side, but on a GPU at most ${MAX_FIXED_SIDE} work; bake at a lower resolution`,
      { voxels, limit: MAX_FIXED_SIDE },
    );
  }
  // A power of two, so that the shader's products with it are exact.
  const stepWorld = powerOfTwoBelow(STEP_VOXELS * voxelSize);
  const writeSplit = (at: number, restAt: number, position: Vec3): void => {
    const whole = map3(position, (c) => Math.floor(c * FIXED_ONE));
    // Storing wraps at 2^32, which is right because the shader adds modulo 2^32.
    ints.set(whole, at);
    floats.set(
      map3(position, (c, a) => (c * FIXED_ONE - whole[a]) / FIXED_ONE),
      restAt,
    );
  };
  for (const a of [0, 1, 2] as const) {
    floats.set(axes[a], 4 * a);
    floats.set(edges[a], 12 + 4 * a);
    writeSplit(
      24 + 4 * a,
      36 + 4 * a,
      map3(size, (_, row) => (axes[row][a] * stepWorld) / voxelSize),
    );
  }
  const anchor = toGrid(grid, anchorWorld);
  writeSplit(48, 52, anchor);
  floats.set(anchor, 56);
  ints.set(size, 60);
  floats.set([1 / voxelSize, stepWorld, 1 / stepWorld], 63);
}

/** Returns the largest power of two that is at most `x`, a positive normal number. */
function powerOfTwoBelow(x: number): number {
  const bits = new BigUint64Array(new Float64Array([x]).buffer);
  // The exponent is kept, and the fraction set to zero.
  bits[0]! &= 0x7ffn << 52n;
  return new Float64Array(bits.buffer)[0]!;
}
