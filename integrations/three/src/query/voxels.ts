// The voxels of a file for look-ups on the CPU, whatever their layout.

/**
 * Returns whether voxel (x, y, z), which must be in the grid, is lit. It remembers the block of its last look-up, so that
 * look-ups close to each other cost less.
 */
export type Voxels = (x: number, y: number, z: number) => boolean;
