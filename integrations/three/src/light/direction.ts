// The direction of a light.

import { Matrix4, Vector3 } from 'three';
import type { DirectionalLight, Light, Object3D, Quaternion } from 'three';

import type { Vec3 } from '../grid/vec3.js';

/** A light that shines in one direction: a `DirectionalLight`, from its position to its target, or a `SunLight`, to the origin. */
export type SunLike = Light & { readonly target?: Object3D } & Pick<DirectionalLight, 'shadow'>;

const from = new Vector3();
const to = new Vector3();
const inverse = new Matrix4();

/** Sets `direction` to the unit vector towards a light, in world space. Its matrices must be up to date. */
export function towardsLight(light: SunLike, direction: Vector3): Vector3 {
  from.setFromMatrixPosition(light.matrixWorld);
  return direction.subVectors(from, targetOf(light)).normalize();
}

/** Whether a light casts shadows where it is drawn, according to the app's settings. */
export function shines(light: SunLike): boolean {
  const { r, g, b } = light.color;
  return light.intensity * Math.max(r, g, b) !== 0 && light.shadow.intensity !== 0 && isShown(light);
}

function isShown(object: Object3D | null): boolean {
  return object === null || (object.visible && isShown(object.parent));
}

/** Whether an object is `root`, or below it. */
export function isIn(object: Object3D | null | undefined, root: Object3D): boolean {
  return object != null && (object === root || isIn(object.parent, root));
}

/** Keeps a light in the direction of a sun, and remembers what the app has set. */
export class Alignment {
  readonly #light: SunLike;
  /** The property that is changed, the value that the app set last, and the value that replaced it. */
  #part: 'position' | 'quaternion' = 'position';
  #theirs: Vector3 | Quaternion | undefined;
  #ours: Vector3 | Quaternion | undefined;
  /** The same for a matrix that the app sets itself. */
  #theirMatrix: Matrix4 | undefined;
  #ourMatrix: Matrix4 | undefined;
  /** The distance from the target, as the app set it. */
  #distance = 1;
  /** The sun that it was turned to last. */
  readonly #sun = new Vector3();

  /** Prepares it. Nothing is turned yet. */
  constructor(light: SunLike) {
    this.#light = light;
  }

  /** Turns the light to a sun. Returns whether somebody has turned it since the last time. */
  align(sun: Vec3): boolean {
    const light = this.#light;
    const isThere = (): boolean => towardsLight(light, new Vector3()).distanceTo(to.set(...sun)) < TURNED;
    let isTurned = !isThere();
    if (isTurned) {
      // Three may not have updated its matrices yet.
      light.updateWorldMatrix(true, false);
      light.target?.updateWorldMatrix(true, false);
      isTurned = !isThere();
    }
    const isSun = to.equals(this.#sun);
    this.#sun.copy(to);
    if (!isTurned) return false;
    // Below an object with zero scale, as during a pop-up animation, there is no direction.
    if (!isRegular(light.parent?.matrixWorld) || (isIn(light.target, light) && !isRegular(light.matrixWorld))) return false;
    const part = isIn(light.target, light) ? 'quaternion' : 'position';
    if (part !== this.#part) this.giveBack();
    this.#part = part;
    if (!isSame(light[part], this.#ours)) {
      this.#theirs = light[part].clone();
      this.#distance = from.setFromMatrixPosition(light.matrixWorld).distanceTo(targetOf(light)) || 1;
    }
    if (!light.matrixAutoUpdate && !isSame(light.matrix, this.#ourMatrix)) this.#theirMatrix = light.matrix.clone();
    alignLight(light, sun, this.#distance);
    this.#ours = light[part].clone();
    this.#ourMatrix = light.matrix.clone();
    return isSun;
  }

  /** Restores the light as the app set it last. */
  giveBack(): void {
    const light = this.#light;
    if (isSame(light[this.#part], this.#ours)) (light[this.#part] as Vector3).copy(this.#theirs as Vector3);
    if (light.matrixAutoUpdate) light.updateMatrix();
    else if (this.#theirMatrix && isSame(light.matrix, this.#ourMatrix)) light.matrix.copy(this.#theirMatrix);
    updateWorld(light);
    this.#ours = this.#ourMatrix = undefined;
  }
}

/** Whether a value equals a known one. */
function isSame<T extends Vector3 | Quaternion | Matrix4>(value: T, known: T | undefined): boolean {
  return known !== undefined && (value as Vector3).equals(known as Vector3);
}

/** Whether a matrix, if there is one, has an inverse. */
function isRegular(matrix: Matrix4 | undefined): boolean {
  return Number.isFinite(1 / (matrix?.determinant() ?? 1));
}

/** Directions that differ by less are the same, up to rounding. */
const TURNED = 1e-6;

/**
 * Turns a light to a sun. The light moves around its target, at a distance. A light that carries its target,
 * as those of glTF files do, rotates instead. Matrices must be up to date.
 */
function alignLight(light: SunLike, sun: Vec3, distance: number): void {
  if (isIn(light.target, light)) {
    // In the light's own space, and in its parent's, which may be stretched or mirrored.
    const target = light.worldToLocal(targetOf(light));
    from.copy(target).multiply(light.scale).negate().normalize();
    to.set(...sun);
    if (light.parent !== null) to.transformDirection(inverse.copy(light.parent.matrixWorld).invert());
    light.quaternion.setFromUnitVectors(from, to);
  } else {
    from.set(...sun).multiplyScalar(distance).add(targetOf(light));
    light.position.copy(light.parent === null ? from : light.parent.worldToLocal(from));
  }
  light.updateMatrix();
  updateWorld(light);
}

/**
 * Updates the matrices of a light and of all objects from it down to its target, even if the app has frozen
 * them.
 */
function updateWorld(light: SunLike): void {
  const objects: Object3D[] = [light];
  for (let each: Object3D | null = light.target ?? null; each; each = each.parent) objects.push(each);
  const settings = objects.map((each) => each.matrixWorldAutoUpdate);
  for (const each of objects) each.matrixWorldAutoUpdate = true;
  light.updateMatrixWorld(true);
  objects.forEach((each, i) => (each.matrixWorldAutoUpdate = settings[i]!));
}

function targetOf(light: SunLike): Vector3 {
  return light.target === undefined ? to.set(0, 0, 0) : to.setFromMatrixPosition(light.target.matrixWorld);
}
