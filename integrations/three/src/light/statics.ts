// What is in the files does not cast in three's own shadow maps while a file is in use.

import type { Object3D } from 'three';

/** How many lights have a caster in their files, and how many of these do without it in shadow maps. */
interface Uses {
  lights: number;
  resting: number;
}

/** The uses of casters, over all lights. */
const usesOf = new WeakMap<Object3D, Uses>();

/** Whether an object moves, whatever root it is below. What moves is no part of a bake. */
function moves(object: Object3D): boolean {
  const { adumbra } = object.userData as { adumbra?: { cast?: boolean } };
  return adumbra?.cast === true || 'isSkinnedMesh' in object;
}

/** Whether an object is in no file, as far as the roots of what is in the files tell. */
export function isMover(object: Object3D, roots: readonly Object3D[]): boolean {
  for (let each: Object3D | null = object; each !== null; each = each.parent) {
    if (moves(each)) return true;
    if (roots.includes(each)) return false;
  }
  return roots.length > 0;
}

/** What takes the casters of one light out of shadow maps. */
export interface Statics {
  /**
   * Takes the casters out of shadow maps, or puts them back. A caster that several lights have in their files casts as
   * soon as one of them needs it. Cost: nothing without a change.
   */
  rest(rests: boolean): void;
  /** Gives the casters back; they are as they were if no other light has them. */
  release(): void;
}

/** Finds the casters below some roots that are in the files of one light. */
export function staticsOf(roots: readonly Object3D[]): Statics {
  /** What is in the files; each cast before. */
  const casters: Object3D[] = [];
  let isResting = false;

  const find = (object: Object3D): void => {
    if (moves(object)) return;
    const uses = usesOf.get(object) ?? { lights: 0, resting: 0 };
    // What another light has taken out of shadow maps casts as well.
    if (object.castShadow || uses.lights > 0) {
      uses.lights += 1;
      usesOf.set(object, uses);
      casters.push(object);
    }
    object.children.forEach(find);
  };
  const change = (lights: number, resting: number): void => {
    for (const caster of casters) {
      const uses = usesOf.get(caster)!;
      uses.lights += lights;
      uses.resting += resting;
      caster.castShadow = uses.resting < uses.lights || uses.lights === 0;
      if (uses.lights === 0) usesOf.delete(caster);
    }
  };
  const rest = (rests: boolean): void => {
    if (rests !== isResting) change(0, rests ? 1 : -1);
    isResting = rests;
  };

  roots.forEach(find);
  return {
    rest,
    release() {
      rest(false);
      change(-1, 0);
      casters.length = 0;
    },
  };
}
