// Baked shadows for the materials of a scene that WebGLRenderer draws.

import { Vector3 } from 'three';
import type { IUniform, Material, Object3D, Scene, WebGLProgramParametersWithUniforms, WebGLRenderer } from 'three';

import type { BakedShadowFile } from '../file/shadow-file.js';
import { alignLight, towardsLight } from '../light/direction.js';
import type { SunLike } from '../light/direction.js';
import { asList, checkFiles, gpuOptions } from '../light/options.js';
import type { BakedShadowOptions, ShadowSettings } from '../light/options.js';
import { Statics } from '../light/statics.js';
import { LightTextures } from '../light/textures.js';
import { depths } from '../look-ups/depths.js';
import { isLit, withLookUp } from './shader.js';

/** Baked shadows that are attached to a scene. */
export interface AttachedShadow {
  /** Whether the light shines from the sun of a file. Otherwise shadows are those of three's shadow map, if it has one. */
  readonly isActive: boolean;
  /** Names of materials that are lit by no light of three's, and were left alone. */
  readonly skipped: readonly string[];
  /** Gives the materials below an object that was added later the shadows too. */
  attach(object: Object3D): void;
  /**
   * Changes filter, bias or softness. Nothing is compiled anew.
   *
   * @throws RangeError if a setting is out of its range.
   */
  setLookUp(settings: ShadowSettings): void;
  /** Gives materials and casters back as they were, and frees what the GPU holds. */
  dispose(): void;
}

/** The functions of a material that make its program. */
type Hooks = Pick<Material, 'onBeforeCompile' | 'customProgramCacheKey'>;

/** Numbers in use, which tell the look-ups of several lights apart in a shader. A number that is free is used again. */
const inUse = new Set<number>();

/**
 * Gives all materials of a scene the shadows of a light from its files. Three's own shadow map goes on working beside
 * them, for what moves. The light need not cast for the baked shadows alone. Objects must have `receiveShadow`.
 *
 * @throws ShadowFileError of the kind `Layout` or `TooLarge`, if a file does not fit the look-up or the GPU.
 * @throws RangeError if an option is out of its range.
 */
export function attachBakedShadow(
  scene: Scene,
  light: SunLike,
  file: BakedShadowFile | readonly BakedShadowFile[],
  options: BakedShadowOptions = {},
): AttachedShadow {
  const files = asList(file);
  const lookUp = options.lookUp ?? depths;
  checkFiles(files, lookUp);
  const textures = new LightTextures(files, options.maxTextureSize ?? 8192, gpuOptions(options, lookUp));
  if (options.align ?? true) alignLight(light, files[0]!.grid.sun);

  let number = 1;
  while (inUse.has(number)) number += 1;
  inUse.add(number);
  const prefix = `adumbra${number}`;
  const towards = new Vector3();
  const intensity: IUniform<number> = { value: light.shadow.intensity };
  const uniforms: Record<string, IUniform> = {
    [`${prefix}_words`]: { value: textures.words },
    [`${prefix}_headers`]: { value: textures.headers },
    [`${prefix}_towards_light`]: { value: towards },
    [`${prefix}_intensity`]: intensity,
  };
  /** The materials, with what they had before and what they have now. */
  const materials = new Map<Material, { before: Hooks; now: Hooks }>();
  const skipped = new Set<string>();
  const statics = new Statics(asList(options.statics));
  let isDisposed = false;

  const attachMaterial = (material: Material): void => {
    if (materials.has(material)) return;
    const before: Hooks = {
      onBeforeCompile: material.onBeforeCompile,
      customProgramCacheKey: material.customProgramCacheKey,
    };
    // By default the key is the text of `onBeforeCompile`, which is another function from now on.
    const keyBefore = Object.hasOwn(material, 'customProgramCacheKey')
      ? () => before.customProgramCacheKey.call(material)
      : () => before.onBeforeCompile.toString();
    const now: Hooks = {
      onBeforeCompile(shader: WebGLProgramParametersWithUniforms, renderer: WebGLRenderer) {
        before.onBeforeCompile.call(material, shader, renderer);
        if (isDisposed) return;
        if (!isLit(shader.fragmentShader)) {
          skipped.add(material.name || material.type);
          return;
        }
        Object.assign(shader.uniforms, uniforms);
        shader.fragmentShader = withLookUp(shader.fragmentShader, lookUp.glsl, prefix);
      },
      customProgramCacheKey: () => (isDisposed ? keyBefore() : `${keyBefore()} ${prefix} ${lookUp.name}`),
    };
    materials.set(material, { before, now });
    Object.assign(material, now);
    material.needsUpdate = true;
  };
  const attach = (object: Object3D): void => {
    object.traverse((each) => {
      const { material } = each as { material?: Material | Material[] };
      for (const one of asList(material)) attachMaterial(one);
    });
  };
  const update = (): void => {
    if (isDisposed) return;
    const count = textures.use(towardsLight(light, towards));
    statics.rest(count > 0);
    intensity.value = light.shadow.intensity;
  };

  const { onBeforeRender } = scene;
  const followLight: Scene['onBeforeRender'] = (...args) => {
    update();
    onBeforeRender.apply(scene, args);
  };
  scene.onBeforeRender = followLight;
  attach(scene);
  update();

  return {
    get isActive() {
      return textures.use(towardsLight(light, towards)) > 0;
    },
    get skipped() {
      return [...skipped];
    },
    attach,
    setLookUp: (settings) => textures.setLookUp(gpuOptions(settings, lookUp)),
    dispose() {
      if (isDisposed) return;
      isDisposed = true;
      for (const [material, { before, now }] of materials) {
        // Whoever has hooked in since goes on calling what is here, which does nothing any more.
        if (material.onBeforeCompile === now.onBeforeCompile) Object.assign(material, before);
        // Otherwise three keeps the program, with these uniforms, for the next one that has its key.
        material.dispose();
        material.needsUpdate = true;
      }
      materials.clear();
      if (scene.onBeforeRender === followLight) scene.onBeforeRender = onBeforeRender;
      statics.rest(false);
      textures.dispose();
      inUse.delete(number);
    },
  };
}
