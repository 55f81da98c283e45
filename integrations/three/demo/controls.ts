// Ways to move the camera: around a point, or on foot; by pointer, touch and keys.

import { Euler, Raycaster, Vector3 } from 'three';
import type { Box3, Object3D, PerspectiveCamera } from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

import { element } from './dom.js';

/** How the camera moves. */
export type Way = 'orbit' | 'walk';

/** Metres from the ground to the eyes. */
const EYES = 1.7;
/** Metres from a wall to someone who walks along it. */
const ELBOWS = 0.6;
/** Metres per second on foot. */
const PACE = 4;
/** Radians per pixel of a drag on foot, and per key press around a point. */
const LOOK = 0.004;
const TURN = Math.PI / 36;

/** Steps on foot by key and by the name of a button: right and forward. */
const STEPS: Record<string, [right: number, forward: number]> = {
  KeyW: [0, 1],
  KeyA: [-1, 0],
  KeyS: [0, -1],
  KeyD: [1, 0],
  ArrowUp: [0, 1],
  ArrowDown: [0, -1],
};
/** Keys that turn the head on foot. */
const TURNS: Record<string, number> = { ArrowLeft: 1, ArrowRight: -1 };

/** Moves a camera. */
export class Controls {
  readonly #camera: PerspectiveCamera;
  readonly #orbit: OrbitControls;
  readonly #held = new Set<string>();
  readonly #ray = new Raycaster();
  readonly #pad = element('pad', HTMLElement);
  #way: Way = 'orbit';
  #solids: Object3D | null = null;
  #onFoot: readonly [from: Vector3, to: Vector3] | null = null;
  #look: { id: number; x: number; y: number } | null = null;

  constructor(camera: PerspectiveCamera, canvas: HTMLCanvasElement) {
    this.#camera = camera;
    this.#orbit = new OrbitControls(camera, canvas);
    this.#orbit.enableDamping = !matchMedia('(prefers-reduced-motion: reduce)').matches;
    this.#orbit.maxPolarAngle = 0.49 * Math.PI;
    canvas.addEventListener('keydown', (event) => this.#onKey(event));
    canvas.addEventListener('keyup', (event) => this.#held.delete(event.code));
    canvas.addEventListener('blur', () => this.#held.clear());
    canvas.addEventListener('pointerdown', ({ pointerId, clientX, clientY }) => {
      if (this.#way !== 'walk' || this.#look !== null) return;
      canvas.setPointerCapture(pointerId);
      this.#look = { id: pointerId, x: clientX, y: clientY };
    });
    canvas.addEventListener('pointermove', ({ pointerId, clientX, clientY }) => {
      if (this.#look?.id !== pointerId) return;
      this.#turnHead(LOOK * (clientX - this.#look.x), LOOK * (clientY - this.#look.y));
      this.#look = { id: pointerId, x: clientX, y: clientY };
    });
    for (const end of ['pointerup', 'pointercancel'] as const) {
      canvas.addEventListener(end, ({ pointerId }) => {
        if (this.#look?.id === pointerId) this.#look = null;
      });
    }
    for (const button of this.#pad.querySelectorAll('button')) this.#holdable(button);
  }

  /** The objects that one walks on and cannot walk through. */
  set solids(solids: Object3D) {
    this.#solids = solids;
  }

  /**
   * Where a walk begins, and the point that one looks at there. Without it, a walk begins on top of the point
   * that the camera orbits.
   */
  set onFoot(places: readonly [from: Vector3, to: Vector3] | null) {
    this.#onFoot = places;
  }

  /** Whether the camera orbits or walks. */
  get way(): Way {
    return this.#way;
  }

  /** Changes the way. */
  set way(way: Way) {
    if (way === this.#way) return;
    this.#way = way;
    this.#orbit.enabled = way === 'orbit';
    this.#pad.hidden = way === 'orbit';
    this.#held.clear();
    const { position } = this.#camera;
    const ahead = this.#camera.getWorldDirection(new Vector3()).setY(0).normalize();
    if (way === 'orbit') {
      this.look(position.clone().addScaledVector(ahead, -20).add(new Vector3(0, 15, 0)), position.clone());
    } else if (this.#onFoot !== null) {
      position.copy(this.#onFoot[0]);
      this.#camera.lookAt(this.#onFoot[1]);
    } else {
      const above = this.#orbit.target.clone().setY(this.#orbit.target.y + this.#camera.far);
      position.copy(this.#orbit.target);
      position.y = (this.#ground(above, Infinity) ?? position.y) + EYES;
      this.#camera.lookAt(position.clone().add(ahead));
    }
  }

  /** Puts the camera somewhere and turns it to a point, which it goes around. */
  look(from: Vector3, to: Vector3): void {
    this.#camera.position.copy(from);
    this.#orbit.target.copy(to);
    this.#camera.lookAt(to);
    this.#orbit.update();
  }

  /** Lets the camera see all of a box, and not go much farther away. */
  fit(box: Box3): void {
    const size = box.getSize(new Vector3()).length();
    this.#orbit.minDistance = 0.005 * size;
    this.#orbit.maxDistance = 1.2 * size;
    this.#camera.near = Math.min(0.3, 0.001 * size);
    this.#camera.far = 3 * size;
    this.#camera.updateProjectionMatrix();
  }

  /** Moves on by a frame. */
  update(seconds: number): void {
    if (this.#way === 'orbit') this.#orbit.update();
    else this.#walk(Math.min(seconds, 0.1));
  }

  #onKey(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { code, key } = event;
    if (this.#way === 'walk') {
      if (!(code in STEPS || code in TURNS)) return;
      this.#held.add(code);
    } else if (key === '+' || key === '-') this.#goRound(0, 0, key === '+' ? 0.9 : 1 / 0.9);
    else if (code === 'ArrowLeft' || code === 'ArrowRight') this.#goRound(code === 'ArrowLeft' ? -TURN : TURN, 0, 1);
    else if (code === 'ArrowUp' || code === 'ArrowDown') this.#goRound(0, code === 'ArrowUp' ? -TURN : TURN, 1);
    else return;
    event.preventDefault();
  }

  /** Goes around the point by angles, and nearer or farther by a factor. */
  #goRound(across: number, down: number, factor: number): void {
    const { target, minDistance, maxDistance, maxPolarAngle } = this.#orbit;
    const away = this.#camera.position.clone().sub(target);
    const polar = Math.acos(away.y / away.length());
    const distance = Math.min(Math.max(away.length() * factor, minDistance), maxDistance);
    const tilted = Math.min(Math.max(polar + down, 0.01), maxPolarAngle);
    const around = Math.atan2(away.x, away.z) + across;
    away.setFromSphericalCoords(distance, tilted, around);
    this.#camera.position.copy(target).add(away);
    this.#orbit.update();
  }

  #turnHead(across: number, down: number): void {
    const angles = new Euler().setFromQuaternion(this.#camera.quaternion, 'YXZ');
    angles.y += across;
    angles.x = Math.min(Math.max(angles.x + down, -1.5), 1.5);
    this.#camera.quaternion.setFromEuler(angles);
  }

  #walk(seconds: number): void {
    let [right, forward] = [0, 0];
    for (const name of this.#held) {
      const step = STEPS[name];
      if (step !== undefined) [right, forward] = [right + step[0], forward + step[1]];
      else this.#turnHead((TURNS[name] ?? 0) * 1.5 * seconds, 0);
    }
    if (right === 0 && forward === 0) return;
    const ahead = this.#camera.getWorldDirection(new Vector3()).setY(0).normalize();
    const aside = new Vector3(-ahead.z, 0, ahead.x);
    const way = ahead.multiplyScalar(forward).addScaledVector(aside, right).normalize();
    const { position } = this.#camera;
    // Move along each axis separately, so that one slides along a wall.
    for (const step of [new Vector3(way.x, 0, 0), new Vector3(0, 0, way.z)]) {
      const length = PACE * seconds * step.length();
      if (length > 0 && !this.#isBlocked(step.normalize(), length + ELBOWS)) position.addScaledVector(step, length);
    }
    const ground = this.#ground(position, EYES + 3);
    if (ground !== null) position.y = ground + EYES;
  }

  #isBlocked(direction: Vector3, metres: number): boolean {
    // Test at the height of the hips, so that steps do not block.
    const hips = this.#camera.position.clone();
    hips.y -= EYES - 0.9;
    return this.#hit(hips, direction, metres) !== null;
  }

  /** Height of the ground below a point, or `null` if there is none within some metres. */
  #ground(below: Vector3, metres: number): number | null {
    const from = below.clone();
    const distance = this.#hit(from, new Vector3(0, -1, 0), metres);
    return distance === null ? null : from.y - distance;
  }

  #hit(from: Vector3, direction: Vector3, metres: number): number | null {
    if (this.#solids === null) return null;
    this.#ray.set(from, direction);
    this.#ray.far = metres;
    return this.#ray.intersectObject(this.#solids)[0]?.distance ?? null;
  }

  /** Makes a button of the pad act like its key while it is held. */
  #holdable(button: HTMLButtonElement): void {
    const code = button.dataset['code']!;
    button.addEventListener('pointerdown', (event) => {
      button.setPointerCapture(event.pointerId);
      this.#held.add(code);
    });
    for (const end of ['pointerup', 'pointercancel', 'blur'] as const) {
      button.addEventListener(end, () => this.#held.delete(code));
    }
    button.addEventListener('keydown', ({ key }) => {
      if (key === ' ' || key === 'Enter') this.#held.add(code);
    });
    button.addEventListener('keyup', () => this.#held.delete(code));
  }
}
