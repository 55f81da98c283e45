// The shadow map of moving objects, beside a file: a small map around the bus.

import type { DirectionalLight, Object3D, Vector3 } from 'three';

/** Half the side of the map, metres: the bus in any direction. */
const REACH = 7;
/** Metres from the bus to the light. */
const DISTANCE = 30;

/** Sets a light's shadow map up for one mover. */
export function fitToMover({ shadow }: DirectionalLight): void {
  const { camera } = shadow;
  camera.left = camera.bottom = -REACH;
  camera.right = camera.top = REACH;
  camera.near = 1;
  // The shadow of the bus may fall on surfaces far behind it.
  camera.far = DISTANCE + 80;
  shadow.mapSize.set(1024, 1024);
  shadow.normalBias = 0.02;
  camera.updateProjectionMatrix();
}

/** Moves a light along with a mover. Its direction stays. */
export function follow({ position, target }: DirectionalLight, mover: Object3D, towardsSun: Vector3): void {
  target.position.copy(mover.position);
  position.copy(mover.position).addScaledVector(towardsSun, DISTANCE);
}
