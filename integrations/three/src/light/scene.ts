// What is done around each drawing of a scene: lights follow the app, and what is in their files does not cast into shadow maps.
// The app's `castShadow` is borrowed while the scene is drawn, and is the app's own at any other time.

import type { Camera, Material, Object3D, Scene, Vector3 } from 'three';

import type { SunLike } from './direction.js';
import { forEachMaterial } from './materials.js';
import { moves } from './statics.js';
import type { AnyRenderer } from './streamed.js';
import { wrap } from './wrap.js';

/** One light's part in the drawing of a scene. */
export interface Part {
  readonly light: SunLike;
  /** Unit vector towards the light, world space, as of the last update. */
  readonly towards: Vector3;
  /** Follows the app, before a renderer draws. */
  update(renderer: AnyRenderer): void;
  /** Meets each material of the scene, after the update. */
  meet?(material: Material): void;
  /** The roots of what is in files in use, and of what is in the light's other files. None while the light does not shine. */
  casters(): { resting: readonly Object3D[]; needed: readonly Object3D[] };
}

/** What is done around the drawings of one scene. */
interface Around {
  readonly parts: Set<Part>;
  /** Goes on without a part. */
  lose(part: Part): void;
}

const arounds = new WeakMap<Object3D, Around>();

/** Returns the parts of a scene. */
export function partsOf(scene: Object3D): ReadonlySet<Part> {
  return arounds.get(scene)?.parts ?? new Set();
}

/** Gives a light its part in a scene. Returns what ends it; after the last end the scene is as the app left it. */
export function takePart(scene: Scene, part: Part): () => void {
  const around = arounds.get(scene) ?? install(scene);
  around.parts.add(part);
  return () => around.lose(part);
}

function install(scene: Scene): Around {
  const parts = new Set<Part>();
  /** What casts, but not now. */
  const borrowed: Object3D[] = [];
  /** What rested when shadow maps were drawn last. */
  let rested = '';
  let renderer: AnyRenderer | undefined;

  const giveBack = (): void => {
    for (const object of borrowed) object.castShadow = true;
    borrowed.length = 0;
  };
  const rest = (object: Object3D, needed: ReadonlySet<Object3D>): void => {
    if (moves(object) || needed.has(object)) return;
    // A light casts in another way.
    if (object.castShadow && !('isLight' in object)) {
      borrowed.push(object);
      object.castShadow = false;
    }
    for (const child of object.children) rest(child, needed);
  };
  /** Has shadow maps drawn anew that the app has frozen. */
  const thaw = (): void => {
    if (renderer?.isWebGLRenderer) renderer.shadowMap!.needsUpdate = true;
    scene.traverse((each) => {
      const { shadow } = each as SunLike;
      if ('isLight' in each && shadow?.autoUpdate === false) shadow.needsUpdate = true;
    });
  };
  const before = (now: AnyRenderer, camera: Camera): void => {
    giveBack();
    renderer = now;
    for (const part of parts) part.update(now);
    const meetings = [...parts].flatMap(({ meet }) => meet ?? []);
    const meet = meetings.length > 1 ? (material: Material): void => meetings.forEach((each) => each(material)) : meetings[0];
    if (meet) {
      forEachMaterial(scene, meet);
      if (scene.overrideMaterial) meet(scene.overrideMaterial);
    }
    const shown = [...parts].map((part) => ({ part, ...part.casters() }));
    const resting = shown.flatMap((each) => each.resting.map(({ id }) => id)).join();
    if (resting !== rested) thaw();
    rested = resting;
    // WebGLRenderer draws the maps of all lights meanwhile. Others draw each map by itself, from a camera that looks as the light shines.
    const drawn = now.isWebGLRenderer ? shown : shown.filter(({ part }) => looksAlong(camera, part.towards));
    const needed = new Set(drawn.flatMap((each) => each.needed));
    for (const root of drawn.flatMap((each) => each.resting)) if (!isBelow(root, needed)) rest(root, needed);
    // Whatever the drawing throws.
    if (borrowed.length > 0) queueMicrotask(giveBack);
  };

  const hooks = [
    wrap(scene, 'onBeforeRender', (theirs) => function (this: Scene, ...all) {
      // It may draw the scene itself.
      theirs.apply(this, all);
      before(all[0], all[2] as Camera);
    }),
    wrap(scene, 'onAfterRender', (theirs) => function (this: Scene, ...all) {
      giveBack();
      theirs.apply(this, all);
    }),
  ];
  const around = {
    parts,
    lose(part: Part) {
      if (!parts.delete(part)) return;
      if (rested !== '') thaw();
      if (parts.size > 0) return;
      giveBack();
      arounds.delete(scene);
      for (const hook of hooks) hook.remove();
    },
  };
  arounds.set(scene, around);
  return around;
}

/** Whether an object or one above it is in a set. */
function isBelow(object: Object3D | null, all: ReadonlySet<Object3D>): boolean {
  return object !== null && (all.has(object) || isBelow(object.parent, all));
}

/** Directions of a camera and of a light that differ by less are the same. */
const SAME_DIRECTION = 1e-3;

/** Whether a camera is one of a directional light's shadow, and looks away from a direction. */
function looksAlong(camera: Camera, { x, y, z }: Vector3): boolean {
  const { elements: e } = camera.matrixWorld;
  return 'isOrthographicCamera' in camera && Math.hypot(e[8]! - x, e[9]! - y, e[10]! - z) < SAME_DIRECTION;
}
