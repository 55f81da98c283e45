// The way of the camera over the city: a closed curve, low between houses and high above them.

import { CatmullRomCurve3, Vector3 } from 'three';
import type { PerspectiveCamera } from 'three';

/** Metres per second. */
const SPEED = 30;
/** Metres from the camera to the point on its way that it looks at. */
const AHEAD = 90;

const WAY = new CatmullRomCurve3(
  [
    [-700, 60, 700],
    [-300, 35, 500],
    [100, 90, 600],
    [600, 45, 300],
    [750, 140, -300],
    [300, 60, -700],
    [-100, 40, -350],
    [-500, 110, -650],
    [-800, 50, -100],
  ].map(([x, y, z]) => new Vector3(x, y, z)),
  true,
);
const LENGTH = WAY.getLength();

/**
 * Puts a camera where the flight is after `seconds`, and returns the point on the ground that it looks at.
 */
export function fly(camera: PerspectiveCamera, seconds: number): Vector3 {
  const at = (metres: number): Vector3 => WAY.getPointAt((((metres / LENGTH) % 1) + 1) % 1);
  camera.position.copy(at(SPEED * seconds));
  const ahead = at(SPEED * seconds + AHEAD).setY(0);
  camera.lookAt(ahead);
  return ahead;
}

/** Seconds of a whole round. */
export const ROUND = LENGTH / SPEED;
