// What is in the files does not cast in three's own shadow maps while a file is in use.

import type { Object3D } from 'three';

/** How many lights have a caster in their files, and how many of these do without it in shadow maps. */
interface Uses {
  lights: number;
  resting: number;
}

/** The uses of casters, over all lights. */
const usesOf = new WeakMap<Object3D, Uses>();

/** The casters below some roots that are in the files of one light. */
export class Statics {
  /** What is in the files; each cast before. */
  readonly #casters: Object3D[] = [];
  #rests = false;

  /** Finds the casters below the roots. */
  constructor(roots: readonly Object3D[]) {
    for (const root of roots) this.#find(root);
  }

  /**
   * Takes the casters out of shadow maps, or puts them back. A caster that several lights have in their files casts as
   * soon as one of them needs it. Cost: nothing without a change.
   */
  rest(rests: boolean): void {
    if (rests === this.#rests) return;
    this.#rests = rests;
    this.#change({ lights: 0, resting: rests ? 1 : -1 });
  }

  /** Gives the casters back; they are as they were if no other light has them. */
  release(): void {
    this.rest(false);
    this.#change({ lights: -1, resting: 0 });
    this.#casters.length = 0;
  }

  #change({ lights, resting }: Uses): void {
    for (const caster of this.#casters) {
      const uses = usesOf.get(caster)!;
      uses.lights += lights;
      uses.resting += resting;
      caster.castShadow = uses.resting < uses.lights || uses.lights === 0;
      if (uses.lights === 0) usesOf.delete(caster);
    }
  }

  #find(object: Object3D): void {
    const { adumbra } = object.userData as { adumbra?: { cast?: boolean } };
    // What moves is no part of a bake.
    if (adumbra?.cast === true || 'isSkinnedMesh' in object) return;
    const uses = usesOf.get(object) ?? { lights: 0, resting: 0 };
    // What another light has taken out of shadow maps casts as well.
    if (object.castShadow || uses.lights > 0) {
      uses.lights += 1;
      usesOf.set(object, uses);
      this.#casters.push(object);
    }
    for (const child of object.children) this.#find(child);
  }
}
