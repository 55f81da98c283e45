// The hook in a material of WebGLRenderer, which changes its shader for one or several lights. Hooks of others, earlier
// and later ones, go on being called.

import { Material } from 'three';
import type { WebGLProgramParametersWithUniforms, WebGLRenderer } from 'three';

/** What a light does to shaders. */
export interface ShaderChange {
  /** Tells its shaders from others. */
  readonly key: string;
  /** Changes a shader. */
  apply(shader: WebGLProgramParametersWithUniforms, material: Material): void;
}

/** A hook in one material. */
export interface MaterialHook {
  /** Has a change made to the material's shader. */
  add(change: ShaderChange): void;
  /** Has a change made no more. After the last one the material is as it was before. */
  remove(change: ShaderChange): void;
  /** Whether three calls the hook itself. Otherwise whoever has hooked in since may call it, or not. */
  isInPlace(): boolean;
}

/** The hooks by the functions that three calls. */
const hooks = new WeakMap<Material['onBeforeCompile'], MaterialHook>();

/** Has a change made to a material's shader. Returns the hook that does it. */
export function hookIn(material: Material, change: ShaderChange): MaterialHook {
  // Whoever has hooked in since may not call what was here.
  const hook = hooks.get(material.onBeforeCompile) ?? install(material);
  hook.add(change);
  return hook;
}

function install(material: Material): MaterialHook {
  const { onBeforeCompile, customProgramCacheKey } = material;
  const changes = new Set<ShaderChange>();
  const compile = (shader: WebGLProgramParametersWithUniforms, renderer: WebGLRenderer): void => {
    onBeforeCompile.call(material, shader, renderer);
    for (const change of changes) change.apply(shader, material);
  };
  const key = (): string => {
    // By default the key is the text of `onBeforeCompile`, which is another function from now on.
    const parts = [String(onBeforeCompile)];
    if (customProgramCacheKey !== Material.prototype.customProgramCacheKey) parts.push(customProgramCacheKey.call(material));
    for (const change of changes) parts.push(change.key);
    // Whoever has hooked in since changes the program too.
    if (!isInPlace()) parts.push(String(material.onBeforeCompile));
    return parts.join(' ');
  };
  const isInPlace = (): boolean => material.onBeforeCompile === compile;
  material.onBeforeCompile = compile;
  material.customProgramCacheKey = key;
  const hook: MaterialHook = {
    add(change) {
      changes.add(change);
      material.needsUpdate = true;
    },
    remove(change) {
      changes.delete(change);
      if (changes.size === 0) {
        // Whoever has hooked in since goes on calling what is here, which does nothing any more.
        if (isInPlace()) material.onBeforeCompile = onBeforeCompile;
        if (material.customProgramCacheKey === key) material.customProgramCacheKey = customProgramCacheKey;
      }
      // Otherwise three keeps the program, with its uniforms, for the next one that has its key.
      material.dispose();
      material.needsUpdate = true;
    },
    isInPlace,
  };
  hooks.set(compile, hook);
  return hook;
}
