// Work around each drawing of a scene: lights follow the app, and objects in their files do not cast into
// shadow maps. The app's `castShadow` is changed while the scene is drawn, and restored afterwards.

import type { Camera, Material, Object3D, Scene, Vector3 } from 'three';

import { isIn } from './direction.js';
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
  /** Follows the app, before a renderer draws from a camera. */
  update(renderer: AnyRenderer, camera: Camera): void;
  /** Is called with each material of the scene, after the update. */
  meet?(material: Material): void;
  /** Is called once the drawing of the scene has ended, with all drawings that began within it. */
  end?(): void;
  /**
   * The roots of the objects in files in use, and of the objects in the light's other files. None while the
   * light does not shine in the scene.
   */
  casters(scene: Object3D): { resting: readonly Object3D[]; needed: readonly Object3D[] };
}

/** The work around the drawings of one scene. */
interface Around {
  readonly parts: Set<Part>;
  /** Puts back hooks that somebody has deleted. */
  keep(): void;
  /** Removes a part. */
  lose(part: Part): void;
}

const arounds = new WeakMap<Object3D, Around>();

/**
 * Gives a light its part in a scene. Returns the function that ends the part. After the last part has ended,
 * the scene is as the app left it.
 */
export function takePart(scene: Scene, part: Part): () => void {
  const around = arounds.get(scene) ?? install(scene);
  around.parts.add(part);
  around.keep();
  return () => around.lose(part);
}

function install(scene: Scene): Around {
  const parts = new Set<Part>();
  /** The objects whose `castShadow` is changed, and its values before. */
  let [borrowed, castShadows]: [Object3D[], boolean[]] = [[], []];
  /** The resting roots when each renderer drew its shadow maps last. */
  const rested = new Map<AnyRenderer, string>();

  /** Nesting depth of the drawings. */
  let depth = 0;
  const giveBack = (): void => {
    const [objects, values] = [borrowed, castShadows];
    [borrowed, castShadows] = [[], []];
    for (let i = 0; i < objects.length; i += 1) objects[i]!.castShadow = values[i]!;
  };
  const end = (): void => {
    giveBack();
    for (const part of depth > 0 ? [] : parts) part.end?.();
  };
  const rest = (object: Object3D, needed: ReadonlySet<Object3D>): void => {
    if (moves(object) || needed.has(object)) return;
    // Leave lights alone: their `castShadow` has another meaning.
    const { castShadow } = object;
    if (castShadow && !('isLight' in object)) {
      try {
        object.castShadow = false;
        borrowed.push(object);
        castShadows.push(castShadow);
      } catch {
        // `castShadow` has no setter: the object casts in addition to its file.
      }
    }
    for (const child of object.children) rest(child, needed);
  };
  /** Makes a renderer redraw shadow maps that the app has frozen. */
  const thaw = (renderer: AnyRenderer): void => {
    if (renderer.isWebGLRenderer) renderer.shadowMap!.needsUpdate = true;
    for (const shadow of shadowsIn(scene)) if (!shadow.autoUpdate) shadow.needsUpdate = true;
  };
  const before = (now: AnyRenderer, camera: Camera): void => {
    giveBack();
    depth += 1;
    for (const part of parts) part.update(now, camera);
    const meetings = [...parts].flatMap(({ meet }) => meet ?? []);
    const meet = meetings.length > 1 ? (material: Material): void => meetings.forEach((each) => each(material)) : meetings[0];
    if (meet) {
      forEachMaterial(scene, meet);
      if (scene.overrideMaterial) meet(scene.overrideMaterial);
    }
    const shown = [...parts].map((part) => ({ part, ...part.casters(scene) }));
    const resting = shown.flatMap((each) => each.resting.map(({ id }) => id)).join();
    if (resting !== (rested.get(now) ?? '')) thaw(now);
    rested.set(now, resting);
    // During this drawing, WebGLRenderer draws the maps of all lights that the camera sees. Other renderers
    // draw each map separately, from a camera that looks as the light shines.
    const drawn = shown.filter(({ part }) => (now.isWebGLRenderer ? part.light.layers.test(camera.layers) : isMapOf(camera, part, scene)));
    const needed = new Set(drawn.flatMap((each) => each.needed));
    const roots = drawn.flatMap((each) => each.resting);
    // Clean up even if the drawing throws.
    if (depth === 1) {
      queueMicrotask(() => {
        depth = 0;
        end();
      });
    }
    for (const root of roots) if (!drawn.some((each) => each.needed.some((other) => isIn(root, other)))) rest(root, needed);
  };

  const makers = [
    () => wrap(scene, 'onBeforeRender', (theirs) => function (this: Scene, ...all) {
      // The app's hook may draw the scene itself.
      theirs.apply(this, all);
      before(all[0], all[2] as Camera);
      keep();
    }),
    () => wrap(scene, 'onAfterRender', (theirs) => function (this: Scene, ...all) {
      depth = Math.max(0, depth - 1);
      end();
      theirs.apply(this, all);
      keep();
    }),
  ];
  let hooks = makers.map((make) => make());
  const keep = (): void => {
    if (parts.size > 0) hooks = hooks.map((hook, i) => (hook.isInPlace() ? hook : makers[i]!()));
  };
  const around = {
    parts,
    keep,
    lose(part: Part) {
      if (!parts.delete(part)) return;
      for (const [renderer, resting] of rested) if (resting !== '') thaw(renderer);
      if (parts.size > 0) return;
      giveBack();
      arounds.delete(scene);
      for (const hook of hooks) hook.remove();
    },
  };
  arounds.set(scene, around);
  return around;
}

/** Directions of a camera and of a light that differ by less are the same. */
const SAME_DIRECTION = 1e-3;

/**
 * Whether a camera belongs to a light's shadow: it is the shadow's camera, or it looks as the light shines
 * and belongs to no other light. CSM has several such cameras.
 */
function isMapOf(camera: Camera, { light, towards: { x, y, z } }: Part, scene: Object3D): boolean {
  if (camera === light.shadow.camera) return true;
  const { elements: e } = camera.matrixWorld;
  if (!('isOrthographicCamera' in camera) || Math.hypot(e[8]! - x, e[9]! - y, e[10]! - z) >= SAME_DIRECTION) return false;
  return !shadowsIn(scene).some((shadow) => shadow.camera === camera);
}

/** Returns the shadows of the lights in a scene. */
function shadowsIn(scene: Object3D): SunLike['shadow'][] {
  const shadows: SunLike['shadow'][] = [];
  scene.traverse((each) => {
    const { isLight, shadow } = each as SunLike;
    if (isLight && shadow) shadows.push(shadow);
  });
  return shadows;
}
