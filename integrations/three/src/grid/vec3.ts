// Vectors of three numbers. The order of additions is that of `crates/adumbra/src/grid/vec3.rs`, so that
// results have the same bits.

/** Three numbers along x, y, z. */
export type Vec3 = readonly [number, number, number];

/** Three vectors, such as the rows of a matrix. */
export type Mat3 = readonly [Vec3, Vec3, Vec3];

/** A point or direction with named coordinates, such as a `Vector3` of three.js. */
export interface PointLike {
  readonly x: number;
  readonly y: number;
  readonly z: number;
}

/** Returns the dot product. */
export function dot(a: Vec3, b: Vec3): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/** Returns the cross product. */
export function cross(a: Vec3, b: Vec3): Vec3 {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

/** Returns the vector with `change` applied to each number. */
export function map3<T>(v: readonly [T, T, T], change: (c: T, axis: 0 | 1 | 2) => number): Vec3 {
  return [change(v[0], 0), change(v[1], 1), change(v[2], 2)];
}
