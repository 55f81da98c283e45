// Fixed-point grid positions, in which the CPU and shaders agree on every tap. `spec/adumbra-file.md`,
// "Look-up bias and filters".

/** Units of a fixed-point grid position per voxel. */
export const FIXED_ONE = 4096;
/** Most voxels along a side of the grid with which positions and depths in fixed point fit 32 bits. */
export const MAX_FIXED_SIDE = 516096;
/** A slope of 1 in fixed point. */
export const GRADIENT_ONE = 256;
/** The steepest plane that look-ups follow from texel to texel. */
export const MAX_PLANE_SLOPE = 120;
