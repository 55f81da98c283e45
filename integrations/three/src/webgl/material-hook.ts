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

/** The hooks by the functions that three calls. */
const hooks = new WeakMap<Material['onBeforeCompile'], MaterialHook>();

/** A hook in one material. */
export class MaterialHook {
  readonly #material: Material;
  readonly #changes = new Set<ShaderChange>();
  readonly #before: Pick<Material, 'onBeforeCompile' | 'customProgramCacheKey'>;
  readonly #now: Pick<Material, 'onBeforeCompile' | 'customProgramCacheKey'>;

  private constructor(material: Material) {
    const { onBeforeCompile, customProgramCacheKey } = material;
    this.#material = material;
    this.#before = { onBeforeCompile, customProgramCacheKey };
    this.#now = {
      onBeforeCompile: (shader: WebGLProgramParametersWithUniforms, renderer: WebGLRenderer) => {
        onBeforeCompile.call(material, shader, renderer);
        for (const change of this.#changes) change.apply(shader, material);
      },
      customProgramCacheKey: () => this.#key(),
    };
    Object.assign(material, this.#now);
    hooks.set(material.onBeforeCompile, this);
  }

  /** Has a change made to a material's shader. Returns the hook that does it. */
  static add(material: Material, change: ShaderChange): MaterialHook {
    // Whoever has hooked in since may not call what was here.
    const hook = hooks.get(material.onBeforeCompile) ?? new MaterialHook(material);
    hook.#changes.add(change);
    material.needsUpdate = true;
    return hook;
  }

  /** Whether three calls the hook itself. Otherwise whoever has hooked in since may call it, or not. */
  get isInPlace(): boolean {
    return hooks.get(this.#material.onBeforeCompile) === this;
  }

  /** Has a change made no more. After the last one the material is as it was before. */
  remove(change: ShaderChange): void {
    this.#changes.delete(change);
    const material = this.#material;
    if (this.#changes.size === 0) {
      // Whoever has hooked in since goes on calling what is here, which does nothing any more.
      const { onBeforeCompile, customProgramCacheKey } = this.#before;
      if (this.isInPlace) material.onBeforeCompile = onBeforeCompile;
      if (material.customProgramCacheKey === this.#now.customProgramCacheKey) {
        material.customProgramCacheKey = customProgramCacheKey;
      }
    }
    // Otherwise three keeps the program, with its uniforms, for the next one that has its key.
    material.dispose();
    material.needsUpdate = true;
  }

  #key(): string {
    const { onBeforeCompile, customProgramCacheKey } = this.#before;
    // By default the key is the text of `onBeforeCompile`, which is another function from now on.
    const parts = [onBeforeCompile.toString()];
    if (customProgramCacheKey !== Material.prototype.customProgramCacheKey) parts.push(customProgramCacheKey.call(this.#material));
    for (const { key } of this.#changes) parts.push(key);
    // Whoever has hooked in since changes the program too.
    const { onBeforeCompile: latest } = this.#material;
    if (latest !== this.#now.onBeforeCompile) parts.push(latest.toString());
    return parts.join(' ');
  }
}
