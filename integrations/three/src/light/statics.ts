// What is in the files does not cast in three's own shadow maps while a file is in use.

import type { Object3D } from 'three';

/** The casters below some roots that are in the files. */
export class Statics {
  /** What is in the files; each cast before. */
  readonly #casters: Object3D[] = [];
  #rests = false;

  /** Finds the casters below the roots. */
  constructor(roots: readonly Object3D[]) {
    for (const root of roots) this.#find(root);
  }

  /** Takes the casters out of shadow maps, or puts them back. Cost: nothing without a change. */
  rest(rests: boolean): void {
    if (rests === this.#rests) return;
    this.#rests = rests;
    for (const caster of this.#casters) caster.castShadow = !rests;
  }

  #find(object: Object3D): void {
    const { adumbra } = object.userData as { adumbra?: { cast?: boolean } };
    // What moves is no part of a bake.
    if (adumbra?.cast === true || 'isSkinnedMesh' in object) return;
    if (object.castShadow) this.#casters.push(object);
    for (const child of object.children) this.#find(child);
  }
}
