// Baked shadows for the materials of a scene that WebGLRenderer draws.

import { GLSL3, Material, Object3D } from 'three';
import type { IUniform, RawShaderMaterial, Scene, WebGLRenderer } from 'three';

import { bakedLight } from '../light/baked-light.js';
import { isIn, shines } from '../light/direction.js';
import type { SunLike } from '../light/direction.js';
import { forEachMaterial } from '../light/materials.js';
import type { BakedShadow, BakedShadowOptions } from '../light/options.js';
import { takePart } from '../light/scene.js';
import type { Part } from '../light/scene.js';
import { checkThree } from '../light/three.js';
import { warnOnce } from '../light/warn.js';
import { addChange, hasChange, removeChange } from './material-hook.js';
import type { ShaderChange } from './material-hook.js';
import { isLit, shaderHooks, withLookUp } from './shader.js';

/** Baked shadows that are attached to a scene. */
export interface AttachedShadow extends BakedShadow {
  /** Names of lit materials that are not lit as three's own are, and were left alone. Known once they were drawn. */
  readonly skipped: readonly string[];
}

/** The function that ends the shadow attached to a light, in any scene. */
const attached = new WeakMap<SunLike, () => void>();

type Uniforms = Record<string, IUniform>;

/** A material that was met in none of this many drawings is released. */
const LONG_DRAWINGS = 100;

const NO_PART = 'attach shadows to the Scene that is drawn';

/** The first revision of three with all that is needed. */
const OLDEST = 166;

/**
 * Gives all materials of a scene, also those that are added later, the shadows of a light from its files:
 * `attachBakedShadow(scene, light, { file })`.
 * Three's own shadow map goes on working beside them, for objects that move. For the baked shadows alone, the
 * light need not cast. Objects must have `receiveShadow`. A shadow that was attached to the light before, in
 * any scene, is disposed.
 *
 * @throws MissingHookError if this version of three lacks what is needed.
 * @throws TypeError if `scene` is not a scene, or comes from another copy of three.
 * @throws ShadowFileError of the kind `TooLarge`, if a file does not fit the GPU.
 * @throws RangeError if an option is out of its range.
 */
export function attachBakedShadow(scene: Scene, light: SunLike, options: BakedShadowOptions): AttachedShadow {
  const { onBeforeCompile, customProgramCacheKey } = Material.prototype;
  if (!(scene instanceof Object3D)) throw new TypeError("the scene comes from another copy of three; have 'three' resolve to one");
  if (scene.isScene !== true) throw new TypeError(NO_PART);
  if (scene.parent !== null) warnOnce(NO_PART, `part ${scene.id}`);
  checkThree(OLDEST, {
    'Material.onBeforeCompile': onBeforeCompile,
    'Material.customProgramCacheKey': customProgramCacheKey,
    'Scene.onBeforeRender': scene.onBeforeRender,
    'LightShadow.intensity': !light.shadow || 'intensity' in light.shadow,
    ...shaderHooks(),
  });
  const baked = bakedLight(light, options);
  attached.get(light)?.();
  const { lookUp, prefix } = baked;
  const intensity: IUniform<number> = { value: 1 };
  const words: IUniform = { value: null };
  const headers: IUniform = { value: null };
  const wordsName = `${prefix}_words`;
  const uniforms: Uniforms = {
    [wordsName]: words,
    [`${prefix}_headers`]: headers,
    [`${prefix}_towards_light`]: { value: baked.towards },
    [`${prefix}_intensity`]: intensity,
  };
  /** The materials that have the shadows, with the drawing that met them last. */
  const materials = new Map<Material, number>();
  const skipped = new Set<string>();
  let drawings = 0;

  /**
   * Returns uniforms of a material with those of the light. Uniforms that a `ShaderMaterial` was given stay
   * as they are.
   */
  const withUniforms = (theirs: Uniforms, material: Material): Uniforms => {
    const isGiven = theirs === (material as { uniforms?: Uniforms }).uniforms;
    return Object.assign(isGiven ? (Object.create(theirs) as Uniforms) : theirs, uniforms);
  };
  const change: ShaderChange = {
    key: `${prefix} ${lookUp.name}`,
    apply(shader, material) {
      if (shader.fragmentShader.includes(`${prefix}_visibility`) || !isLit(shader.fragmentShader)) return;
      const { isRawShaderMaterial, glslVersion } = material as RawShaderMaterial;
      // The texts of look-ups are GLSL 3.
      const text = isRawShaderMaterial && glslVersion !== GLSL3 ? null : withLookUp(shader, lookUp.glsl, prefix);
      if (text === null) {
        const name = material.name || material.type;
        skipped.add(name);
        warnOnce(`the material '${name}' is not lit as three's own are, and has no baked shadows`, `skipped ${name}`);
        return;
      }
      Object.assign(shader, text);
      shader.uniforms = withUniforms(shader.uniforms, material);
    },
  };
  const forget = ({ target }: { target: Material }): void => {
    if (!materials.delete(target)) return;
    target.removeEventListener('dispose', forget);
    removeChange(target, change);
  };
  const meet = (material: Material): void => {
    const last = materials.get(material);
    if (last === drawings) return;
    if (last === undefined) material.addEventListener('dispose', forget);
    materials.set(material, drawings);
    if (!hasChange(material, change)) addChange(material, change);
  };
  /** Three keeps all programs of a material, but only the uniforms of the program that it compiled last. */
  const giveUniforms = (properties: WebGLRenderer['properties']): void => {
    for (const material of materials.keys()) {
      const kept = properties.get(material) as { uniforms?: Uniforms; uniformsList?: unknown };
      if (kept.uniforms === undefined || kept.uniforms[wordsName] === words) continue;
      kept.uniforms = withUniforms(kept.uniforms, material);
      kept.uniformsList = null;
    }
  };
  const bind = (): void => {
    const textures = baked.textures();
    words.value = textures.words;
    headers.value = textures.headers;
  };

  const part: Part = {
    ...baked,
    update(renderer, camera) {
      if (drawings === 0) baked.warnOfMovers(scene);
      drawings += 1;
      baked.update(renderer);
      baked.warnOfMoved(scene);
      bind();
      // The intensity of this shadow in a mask of all shadows.
      intensity.value = shines(light) && isIn(light, scene) && light.layers.test(camera.layers) ? light.shadow.intensity : 0;
      if (renderer.isWebGLRenderer !== true) {
        warnOnce('attachBakedShadow is for WebGLRenderer; with WebGPURenderer, use BakedShadowNode', 'renderer');
        return;
      }
      giveUniforms((renderer as unknown as WebGLRenderer).properties);
      if (drawings % LONG_DRAWINGS !== 0) return;
      for (const [target, last] of materials) if (drawings - last > LONG_DRAWINGS) forget({ target });
    },
    meet,
    // Another scene may draw the materials too.
    end: () => void (intensity.value = 0),
  };
  const leave = takePart(scene, part);
  const detach = (): void => {
    leave();
    if (!baked.dispose()) return;
    if (attached.get(light) === detach) attached.delete(light);
    for (const target of [...materials.keys()]) forget({ target });
    // Drop the textures, because three keeps the uniforms.
    words.value = headers.value = null;
  };
  attached.set(light, detach);
  // Update only after the previous shadow has restored the light. Materials that are compiled before the
  // first drawing then have the shadows as well.
  baked.update();
  bind();
  forEachMaterial(scene, meet);

  return {
    get isActive() {
      return baked.status().filesInUse > 0;
    },
    get status() {
      return baked.status();
    },
    get skipped() {
      return [...skipped];
    },
    setOptions: baked.setOptions,
    setFiles(choice) {
      baked.setFiles(choice);
      bind();
    },
    dispose: detach,
  };
}
