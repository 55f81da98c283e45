// A light with its files: the part that both renderers share.

import { Matrix4, Vector3 } from 'three';
import type { Object3D } from 'three';

import type { Vec3 } from '../grid/vec3.js';
import { filtered } from '../look-ups/filtered.js';
import type { LookUp } from '../look-ups/look-up.js';
import { Alignment, isIn, shines, towardsLight } from './direction.js';
import type { SunLike } from './direction.js';
import { lookUpOf, openFiles } from './files.js';
import { BAKED_SHADOW_DEFAULTS, asList, asPlaced, copied, inScene } from './options.js';
import type { BakedShadowOptions, FileChoice, ShadowOptions, ShadowStatus } from './options.js';
import type { Part } from './scene.js';
import { isMover } from './statics.js';
import type { AnyRenderer } from './streamed.js';
import type { LightTextures } from './textures.js';
import { warnOnce } from './warn.js';

/** A light with its files. */
export interface BakedLight extends Part {
  readonly lookUp: LookUp;
  /** The prefix of the names in its shader texts, which distinguishes them from those of other lights. */
  readonly prefix: string;
  /** The files' words and parameters. They may be others after `setFiles`. */
  textures(): Pick<LightTextures, 'words' | 'headers'>;
  /** Changes options; options that are left out stay. Nothing is changed if it throws a RangeError. */
  setOptions(options: ShadowOptions): void;
  /** Replaces the files. Nothing is changed if it throws. */
  setFiles(file: FileChoice): void;
  /** The current state of the light and its files. */
  status(): ShadowStatus;
  /** Sets whether updates do nothing for a while, because three may draw another shadow of the light. */
  setIdle(isIdle: boolean): void;
  /** Follows the light and the roots, before a renderer draws. Does nothing after `dispose`. */
  update(renderer?: AnyRenderer | null): void;
  /** Warns once if a scene, or a static root, is moved and no file follows one. Cost: one comparison for each static root. */
  warnOfMoved(scene: Object3D): void;
  /** Warns once if something below `object` gets wrong answers from a file that is for static surfaces only. */
  warnOfMovers(object: Object3D): void;
  /** Restores the light as the app set it, and frees GPU resources. Returns false after the first time. */
  dispose(): boolean;
}

/**
 * Files whose sun is farther than this from the light are not in use. It is the distance of two unit vectors.
 */
const SAME_SUN = 1.5e-3;

const IDENTITY = new Matrix4();

/** Numbers in use. A free number is used again, so that its shaders can be reused. */
const inUse = new Set<number>();

/** Reads the options of a light, and prepares its files. The light stays as it is until the first update. */
export function bakedLight(light: SunLike, { file, ...first }: BakedShadowOptions): BakedLight {
  if (!file || 'root' in first) throw new TypeError('give file, or file: { file, root }');
  if (!('isDirectionalLight' in light || 'isSunLight' in light)) throw new TypeError(`a ${(light as SunLike).type} has no baked shadow; give a DirectionalLight`);
  let options = copied(first);
  const statics = asList(options.statics, 'statics').map((each) => inScene(each, 'statics'));
  const lookUp = lookUpOf(file) ?? options.lookUp ?? filtered;
  let files = openFiles(file, lookUp, options);
  const alignment = (options.align ?? BAKED_SHADOW_DEFAULTS.align) && new Alignment(light);
  const align = (): void => {
    const [sun, ...others] = files.suns().filter((each) => each !== undefined);
    // Do not align a light whose files have several suns: the app moves it between them.
    if (!alignment || !sun || others.some((other) => distance(other, sun) > SAME_SUN)) return;
    if (!alignment.align(sun)) return;
    const towardsSun = sun.map((each) => each.toFixed(4)).join(', ');
    warnOnce(
      `'${light.name || light.type}' was turned, but align keeps it at the sun of its file; set its position to its target's + distance × (${towardsSun}), or align: false`,
      `turned ${light.id}`,
    );
  };
  const towards = new Vector3();
  let [isDisposed, isIdle] = [false, false];
  let number = 1;
  while (inUse.has(number)) number += 1;
  inUse.add(number);
  /** How far the files' suns are from a direction, as the distance of two unit vectors. */
  const distancesTo = ({ x, y, z }: Vector3): number[] => files.suns().map((sun) => (sun ? distance(sun, [x, y, z]) : Infinity));
  /** The numbers of the files whose sun is in a direction. */
  const filesTowards = (direction: Vector3): number[] => distancesTo(direction).flatMap((each, i) => (each <= SAME_SUN ? i : []));
  const update = (renderer?: AnyRenderer | null): void => {
    if (isDisposed || isIdle) return;
    files.follow(renderer);
    align();
    files.textures.use(filesTowards(towardsLight(light, towards)));
  };
  return {
    light,
    lookUp,
    prefix: `adumbra${number}`,
    towards,
    textures: () => files.textures,
    setOptions(theirs) {
      const changed = copied(theirs);
      files.textures.setOptions(changed);
      options = { ...options, ...changed };
    },
    setFiles(choice) {
      if (isDisposed) return;
      const needed = lookUpOf(choice) ?? first.lookUp ?? filtered;
      if (needed !== lookUp && asPlaced(choice).length > 0) throw new RangeError('these files need another look-up');
      const next = openFiles(choice, lookUp, options, files);
      if (files.textures !== next.textures) files.textures.dispose(next.textures);
      files = next;
      update();
    },
    status() {
      // The app may have moved the light since the last drawing.
      light.updateWorldMatrix(true, false);
      light.target?.updateWorldMatrix(true, false);
      const distances = distancesTo(towardsLight(light, new Vector3()));
      return {
        filesInUse: isDisposed || isIdle || !shines(light) ? 0 : distances.filter((each) => each <= SAME_SUN).length,
        missing: distances.filter((each) => each === Infinity).length,
        degrees: (Math.asin(Math.min(1, Math.min(...distances) / 2)) * 360) / Math.PI,
      };
    },
    update,
    setIdle(value) {
      isIdle = value;
    },
    casters(scene) {
      const [resting, needed]: [Object3D[], Object3D[]] = [[], []];
      if (isDisposed || isIdle || !shines(light) || !isIn(light, scene)) return { resting, needed };
      const now = filesTowards(towards);
      (now.length > 0 ? resting : needed).push(...statics);
      files.roots.forEach((root, i) => root && (now.includes(i) ? resting : needed).push(root));
      return { resting, needed };
    },
    warnOfMoved(scene) {
      if (!files.roots.includes(undefined)) return;
      const moved = [scene, ...statics].find((root) => !('geometry' in root) && !root.matrixWorld.equals(IDENTITY));
      if (!moved) return;
      const name = moved === scene ? 'the scene' : `'${moved.name || moved.type}' in statics`;
      warnOnce(`${name} is moved, turned or scaled; if its file was baked from what is below, give file: { file, root }`, 'at rest');
    },
    warnOfMovers(object) {
      if (!files.isForStatics) return;
      const roots = [...statics, ...files.roots.filter((root) => root !== undefined)];
      object.traverse((each) => {
        if (!each.receiveShadow || !isMover(each, roots)) return;
        warnOnce(
          `'${each.name || each.type}' moves, and a file baked with --receivers static is wrong at 1 to 3 % of it`,
          'movers',
        );
      });
    },
    dispose() {
      if (isDisposed) return false;
      isDisposed = true;
      if (alignment) alignment.giveBack();
      files.textures.dispose();
      inUse.delete(number);
      return true;
    },
  };
}

function distance(a: Vec3, b: Vec3): number {
  return Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}
