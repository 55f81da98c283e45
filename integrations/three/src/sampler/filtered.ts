// The visibility of a point, filtered. The rules are in `spec/adumbra-file.md`, "Look-up bias and filters".

import { FIXED_ONE } from '../grid/fixed.js';
import type { LightGrid } from '../grid/light-grid.js';
import type { Vec3 } from '../grid/vec3.js';
import type { Voxels } from '../quadtree/voxels.js';
import type { Bias, FilterWidth } from '../settings.js';
import { layerAt, receiverAt } from './receiver.js';

/** Returns the share of lit taps at a point of the world: 1 lit, 0 shadowed. */
export function filteredVisibility(
  grid: LightGrid,
  { filter, bias }: { readonly filter: FilterWidth; readonly bias: Bias },
  voxels: Voxels,
  p: Vec3,
  normal: Vec3 | undefined,
): number {
  const [sizeX, sizeY, sizeZ] = grid.size;
  const receiver = receiverAt(grid, bias, p, normal);
  const texelX = Math.floor(receiver.x / FIXED_ONE);
  const texelY = Math.floor(receiver.y / FIXED_ONE);
  const reach = filter >> 1;
  const left = Math.max(texelX - reach, 0);
  const top = Math.max(texelY - reach, 0);
  const right = Math.min(texelX + reach, sizeX - 1);
  const bottom = Math.min(texelY + reach, sizeY - 1);
  const all = filter * filter;
  // Texels beside the grid are lit.
  let shadowed = 0;
  // Go by blocks of 8 × 8 texels, which share the block that the voxels remember.
  for (let blockY = top; blockY <= bottom; blockY = blockEnd(blockY) + 1) {
    const endY = Math.min(blockEnd(blockY), bottom);
    for (let blockX = left; blockX <= right; blockX = blockEnd(blockX) + 1) {
      const endX = Math.min(blockEnd(blockX), right);
      for (let y = blockY; y <= endY; y++) {
        for (let x = blockX; x <= endX; x++) {
          const z = layerAt(receiver, x, y);
          if (z >= 0 && !voxels(x, y, Math.min(z, sizeZ - 1))) shadowed++;
        }
      }
    }
  }
  // Lit taps and their number are small, so this is the quotient of 32-bit floating point, correctly rounded.
  return Math.fround((all - shadowed) / all);
}

/** Returns the last texel of the block of eight that contains a texel. */
function blockEnd(texel: number): number {
  return (texel | 7) >>> 0;
}
