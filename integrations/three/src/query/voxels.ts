// The voxels of a file for look-ups on the CPU, whatever their layout.

/** Looks up voxels. It remembers the block of its last look-up, so that look-ups close to each other cost less. */
export interface Voxels {
  /** Whether voxel (x, y, z) is lit. It must be in the grid. */
  isLit(x: number, y: number, z: number): boolean;
}
