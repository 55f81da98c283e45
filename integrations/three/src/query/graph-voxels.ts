// What look-ups in the layouts plain and packed have in common: both lead down to cubes of 8 × 8 × 8 voxels of which each
// layer is a leaf mask of 64 bits. Counterpart of `crates/adumbra/src/layout/trail.rs`.

import type { Voxels } from './voxels.js';

/** In place of a node: the whole cube is lit. */
export const LIT = -1;
/** In place of a node: the whole cube is shadowed. */
export const SHADOWED = -2;

/** Look-ups in a graph of cubes with leaf masks at the bottom. */
export abstract class GraphVoxels implements Voxels {
  /** Lower half of the last leaf mask: rows y & 7 = 0 to 3. */
  protected low = 0;
  /** Upper half of the last leaf mask: rows y & 7 = 4 to 7. */
  protected high = 0;
  #x = -1;
  #y = -1;
  #cube = -1;
  #layer = -1;
  #node = LIT;

  isLit(x: number, y: number, z: number): boolean {
    const cubeX = x >>> 3;
    const cubeY = y >>> 3;
    const cubeZ = z >>> 3;
    if (cubeX !== this.#x || cubeY !== this.#y || cubeZ !== this.#cube) {
      this.#x = cubeX;
      this.#y = cubeY;
      this.#cube = cubeZ;
      this.#layer = -1;
      this.#node = this.findNode(x, y, z);
    }
    const layer = z & 7;
    if (layer !== this.#layer) {
      this.#layer = layer;
      if (this.#node >= 0) this.readLeafMask(this.#node, layer);
      else this.low = this.high = this.#node === LIT ? -1 : 0;
    }
    const half = (y & 4) === 0 ? this.low : this.high;
    return ((half >>> ((y & 3) * 8 + (x & 7))) & 1) === 1;
  }

  /** Returns the node of level 3 that contains a voxel, {@link LIT} or {@link SHADOWED}. */
  protected abstract findNode(x: number, y: number, z: number): number;

  /** Sets `low` and `high` to a layer's leaf mask; `layer` is 0 to 7. */
  protected abstract readLeafMask(node: number, layer: number): void;
}
