// Where a light is.

import { Quaternion, Vector3 } from 'three';
import type { DirectionalLight, Light, Object3D } from 'three';

import type { Vec3 } from '../grid/vec3.js';

/** A light that shines in one direction: a `DirectionalLight`, from its position to its target, or a `SunLight`, to the origin. */
export type SunLike = Light & { readonly target?: Object3D } & Pick<DirectionalLight, 'shadow'>;

const from = new Vector3();
const to = new Vector3();

/** Sets `direction` to the unit vector towards a light, in world space. Its matrices must be up to date. */
export function towardsLight(light: SunLike, direction: Vector3): Vector3 {
  from.setFromMatrixPosition(light.matrixWorld);
  return direction.subVectors(from, targetOf(light)).normalize();
}

/**
 * Makes a light shine from the direction of a sun. It moves around its target, at its distance; a light that carries its
 * target, as those of glTF files do, turns.
 */
export function alignLight(light: SunLike, sun: Vec3): void {
  light.updateWorldMatrix(true, false);
  light.target?.updateWorldMatrix(true, false);
  if (light.target?.parent === light) {
    const world = new Quaternion();
    light.parent?.getWorldQuaternion(world);
    to.set(...sun).applyQuaternion(world.invert());
    light.quaternion.setFromUnitVectors(from.copy(light.target.position).negate().normalize(), to);
  } else {
    const target = targetOf(light);
    const distance = from.setFromMatrixPosition(light.matrixWorld).distanceTo(target) || 1;
    from.set(...sun).multiplyScalar(distance).add(target);
    light.position.copy(light.parent === null ? from : light.parent.worldToLocal(from));
  }
  light.updateMatrixWorld();
}

function targetOf(light: SunLike): Vector3 {
  return light.target === undefined ? to.set(0, 0, 0) : to.setFromMatrixPosition(light.target.matrixWorld);
}
