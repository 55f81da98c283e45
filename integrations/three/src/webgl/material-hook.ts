// The hook in a material of WebGLRenderer, which changes its shader for one or several lights. Hooks of the
// app, earlier and later ones, are still called, before those changes.

import { Material } from 'three';
import type { WebGLProgramParametersWithUniforms, WebGLRenderer } from 'three';

import { wrap } from '../light/wrap.js';

/** A light's change to shaders. */
export interface ShaderChange {
  /** Distinguishes its shaders from others. */
  readonly key: string;
  /** Changes a shader, unless it was changed before. */
  apply(shader: WebGLProgramParametersWithUniforms, material: Material): void;
}

/** The hook of a material. */
interface Hook {
  readonly changes: Set<ShaderChange>;
  isInPlace(): boolean;
  end(): void;
}

const hooks = new WeakMap<Material, Hook>();

/** Whether a material's shader has a change, or will have it once it is compiled. */
export function hasChange(material: Material, change: ShaderChange): boolean {
  const hook = hooks.get(material);
  return hook !== undefined && hook.changes.has(change) && hook.isInPlace();
}

/** Adds a change to a material's shader. */
export function addChange(material: Material, change: ShaderChange): void {
  let hook = hooks.get(material);
  if (hook?.isInPlace() !== true) {
    hook?.end();
    hook = install(material, hook?.changes);
  }
  hook.changes.add(change);
  material.needsUpdate = true;
}

/**
 * Removes a change from a material's shader. After the last change is removed, the material is as the app
 * left it.
 */
export function removeChange(material: Material, change: ShaderChange): void {
  const hook = hooks.get(material);
  if (hook?.changes.delete(change) !== true) return;
  if (hook.changes.size === 0) hook.end();
  material.needsUpdate = true;
}

function install(material: Material, earlier: Iterable<ShaderChange> = []): Hook {
  const changes = new Set(earlier);
  const keys = (): string => [...changes].map(({ key }) => key).join(' ');
  // The app's hook may call the one before it, and then change three's text itself.
  let depth = 0;
  const compile = wrap(material, 'onBeforeCompile', (theirs) => {
    const hooked = function (this: Material | undefined, shader: WebGLProgramParametersWithUniforms, renderer: WebGLRenderer): void {
      depth += 1;
      try {
        theirs.call(this ?? material, shader, renderer);
      } finally {
        depth -= 1;
      }
      if (depth === 0) for (const change of changes) change.apply(shader, this ?? material);
    };
    // By default three tells programs apart by this text, in copies of the material too.
    return Object.assign(hooked, { toString: () => `${String(theirs)} ${keys()}` });
  });
  const key = wrap(material, 'customProgramCacheKey', (theirs) => {
    const isDefault = theirs === Material.prototype.customProgramCacheKey;
    return function (this: Material): string {
      return isDefault ? theirs.call(this) : `${theirs.call(this)} ${String(compile.theirs())} ${keys()}`;
    };
  });
  const hook = {
    changes,
    isInPlace: compile.isInPlace,
    end() {
      hooks.delete(material);
      compile.remove();
      key.remove();
    },
  };
  hooks.set(material, hook);
  return hook;
}
