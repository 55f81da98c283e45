// What look-ups in the layouts plain and packed have in common: both lead down to cubes of 8 × 8 × 8 voxels of which each
// layer is a leaf mask of 64 bits. Counterpart of `crates/adumbra/src/layout/trail.rs`.

import type { Voxels } from './voxels.js';

/** In place of a node: the whole cube is lit. */
export const LIT = -1;
/** In place of a node: the whole cube is shadowed. */
export const SHADOWED = -2;

/**
 * Returns the look-up of a graph of cubes with leaf masks at the bottom.
 *
 * @param findNode Returns the node of level 3 that contains a voxel, {@link LIT} or {@link SHADOWED}.
 * @param readLeafMask Gives `set` both halves of a layer's leaf mask; `layer` is 0 to 7.
 */
export function graphVoxels(
  findNode: Find,
  readLeafMask: (node: number, layer: number, set: (lowHalf: number, highHalf: number) => void) => void,
): Voxels {
  let lastX = -1;
  let lastY = -1;
  let lastZ = -1;
  let lastLayer = -1;
  let node = LIT;
  /** Rows y & 7 = 0 to 3 of the last leaf mask, and 4 to 7. */
  let low = 0;
  let high = 0;
  const set = (lowHalf: number, highHalf: number): void => {
    low = lowHalf;
    high = highHalf;
  };
  return (x, y, z) => {
    const cubeX = x >>> 3;
    const cubeY = y >>> 3;
    const cubeZ = z >>> 3;
    if (cubeX !== lastX || cubeY !== lastY || cubeZ !== lastZ) {
      lastX = cubeX;
      lastY = cubeY;
      lastZ = cubeZ;
      lastLayer = -1;
      node = findNode(x, y, z);
    }
    const layer = z & 7;
    if (layer !== lastLayer) {
      lastLayer = layer;
      if (node >= 0) readLeafMask(node, layer, set);
      else low = high = node === LIT ? -1 : 0;
    }
    const half = (y & 4) === 0 ? low : high;
    return ((half >>> ((y & 3) * 8 + (x & 7))) & 1) === 1;
  };
}

/** Finds the node of a voxel. */
type Find = (x: number, y: number, z: number) => number;
