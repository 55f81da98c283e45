// Baked shadows for the materials of a scene that WebGLRenderer draws.

import { Material } from 'three';
import type { IUniform, Object3D, Scene, WebGLRenderer } from 'three';

import { bakedLight } from '../light/baked-light.js';
import type { SunLike } from '../light/direction.js';
import { forEachMaterial } from '../light/materials.js';
import type { BakedShadow, BakedShadowOptions } from '../light/options.js';
import type { LightFile } from '../light/streamed.js';
import { checkThree } from '../light/three.js';
import { hookIn } from './material-hook.js';
import type { MaterialHook, ShaderChange } from './material-hook.js';
import { beforeRender } from './scene-hook.js';
import { shaderHooks, withLookUp } from './shader.js';

/** Baked shadows that are attached to a scene. */
export interface AttachedShadow extends BakedShadow {
  /** Names of materials that are not lit as three's own are, and were left alone. Known once they were drawn. */
  readonly skipped: readonly string[];
  /** Gives the materials below an object that was added later the shadows too, or gives them back to what lost them. */
  attach(object: Object3D): void;
  /** Takes the shadows from the materials below an object, which are held until then: for parts of the world that go. */
  detach(object: Object3D): void;
  /** Gives materials and casters back as they were, and frees what the GPU holds. What is attached afterwards stays as it is. */
  dispose(): void;
}

/** The first revision of three with all that is needed. */
const OLDEST = 166;

/**
 * Gives all materials of a scene the shadows of a light from its files. Three's own shadow map goes on working beside
 * them, for what moves. The light need not cast for the baked shadows alone. Objects must have `receiveShadow`.
 *
 * @throws MissingHookError if this version of three lacks what is needed.
 * @throws ShadowFileError of the kind `TooLarge`, if a file does not fit the GPU.
 * @throws RangeError if an option is out of its range.
 */
export function attachBakedShadow(
  scene: Scene,
  light: SunLike,
  file: LightFile | readonly LightFile[],
  options: BakedShadowOptions = {},
): AttachedShadow {
  const { onBeforeCompile, customProgramCacheKey } = Material.prototype;
  checkThree(OLDEST, {
    'Material.onBeforeCompile': onBeforeCompile,
    'Material.customProgramCacheKey': customProgramCacheKey,
    'Scene.onBeforeRender': scene.onBeforeRender,
    'LightShadow.intensity': 'intensity' in light.shadow,
    ...shaderHooks(),
  });
  const baked = bakedLight(light, file, options);
  const { lookUp, prefix } = baked;
  const intensity: IUniform<number> = { value: 1 };
  const uniforms: Record<string, IUniform> = {
    [`${prefix}_words`]: { value: baked.words },
    [`${prefix}_headers`]: { value: baked.headers },
    [`${prefix}_towards_light`]: { value: baked.towards },
    [`${prefix}_intensity`]: intensity,
  };
  /** The hooks of the materials that have the shadows. */
  const hooks = new Map<Material, MaterialHook>();
  const skipped = new Set<string>();
  let isDisposed = false;

  const change: ShaderChange = {
    key: `${prefix} ${lookUp.name}`,
    apply(shader, material) {
      const text = withLookUp(shader.fragmentShader, lookUp.glsl, prefix);
      if (text === null) {
        skipped.add(material.name || material.type);
        return;
      }
      Object.assign(shader.uniforms, uniforms);
      shader.fragmentShader = text;
    },
  };
  const attach = (object: Object3D): void => {
    if (isDisposed) return;
    baked.warnOfMovers(object);
    forEachMaterial(object, (material) => {
      const hook = hooks.get(material);
      if (hook?.isInPlace() === true) return;
      hook?.remove(change);
      hooks.set(material, hookIn(material, change));
    });
  };
  const update = (renderer?: WebGLRenderer): void => {
    baked.update(renderer);
    intensity.value = light.shadow.intensity;
  };

  const stopFollowing = beforeRender(scene, update);
  attach(scene);
  update();

  return {
    get isActive() {
      return baked.isActive();
    },
    get skipped() {
      return [...skipped];
    },
    attach,
    detach(object) {
      forEachMaterial(object, (material) => {
        hooks.get(material)?.remove(change);
        hooks.delete(material);
      });
    },
    setOptions: baked.setOptions,
    dispose() {
      isDisposed = true;
      if (!baked.dispose()) return;
      for (const hook of hooks.values()) hook.remove(change);
      stopFollowing();
    },
  };
}
