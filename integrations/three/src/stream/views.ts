// The view of a camera, as far as the choice of pages needs it.

import { Matrix4, Vector3 } from 'three';
import type { Camera } from 'three';

import type { WorldFromFile } from '../grid/placement.js';
import { dot } from '../grid/vec3.js';
import type { Vec3 } from '../grid/vec3.js';
import type { Box } from './box.js';

/** A plane: points with normal · p + offset below 0 are not seen. */
export interface Plane {
  readonly normal: Vec3;
  readonly offset: number;
}

/** A view of the world. */
export interface View {
  readonly position: Vec3;
  /** The planes that bound the view. */
  readonly planes: readonly Plane[];
  /** Size of a pixel in the world at distance 0. A parallel projection has this size at every distance. */
  readonly pixel: number;
  /** By how much it grows per unit of distance. */
  readonly pixelPerDistance: number;
}

/**
 * Returns the view of a camera whose picture has `rows` rows of pixels, in the coordinates of a file that the
 * app may have placed. It is computed from the product of the camera's matrices, because map libraries have
 * the view in the projection.
 */
export function viewOf(camera: Camera, rows: number, placement?: WorldFromFile): View {
  camera.updateWorldMatrix(true, false);
  const matrix = new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse);
  if (placement !== undefined) matrix.multiply(new Matrix4().fromArray(placement));
  const m = matrix.elements;
  /** A row of the matrix added to its last row, or taken from it: a side of the picture. */
  const side = (row: number, sign: number): Plane => {
    const sum = (column: number): number => m[4 * column + 3]! + sign * m[4 * column + row]!;
    return { normal: [sum(0), sum(1), sum(2)], offset: sum(3) };
  };
  const planes = [side(0, 1), side(0, -1), side(1, 1), side(1, -1)];
  // The last row of a perspective is the distance from the camera, of a parallel projection a number.
  const ahead = new Vector3(m[3], m[7], m[11]);
  const up = new Vector3(m[1], m[5], m[9]).projectOnPlane(ahead);
  const size = (2 * (ahead.length() || m[15]!)) / (up.length() * rows);
  // Where the lines of sight meet. Those of a parallel projection do not.
  const [x, y, z, w] = matrix.clone().invert().elements.slice(8, 12) as [number, number, number, number];
  return w === 0
    ? { position: [0, 0, 0], planes, pixel: size, pixelPerDistance: 0 }
    : { position: [x / w, y / w, z / w], planes, pixel: 0, pixelPerDistance: size };
}

/** Whether a box touches the inner sides of all planes of a view. */
export function isSeen({ corner, edges }: Box, { planes }: View): boolean {
  return planes.every(({ normal, offset }) => {
    let most = offset + dot(normal, corner);
    for (const edge of edges) most += Math.max(dot(normal, edge), 0);
    return most >= 0;
  });
}
