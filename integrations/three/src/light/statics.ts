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
   * Takes the casters out of shadow maps, or puts them back, those too that have come since. A caster that several lights
   * have in their files casts as soon as one of them needs it. Cost: nothing without a change.
   */
  rest(rests: boolean): void;
  /** Gives the casters back; they are as they were if no other light has them. */
  release(): void;
}

/** Follows what is below some roots, which is in the files of one light. */
export function staticsOf(roots: readonly Object3D[]): Statics {
  /** What is followed below the roots, and whether it casts. */
  const found = new Map<Object3D, boolean>();
  /** What has come since. It may be given its `castShadow` after it was added, so it is looked at before a frame. */
  const added = new Set(roots);
  let isResting = false;

  const change = (caster: Object3D, lights: number, resting: number): void => {
    const uses = usesOf.get(caster) ?? { lights: 0, resting: 0 };
    uses.lights += lights;
    uses.resting += resting;
    caster.castShadow = uses.resting < uses.lights || uses.lights === 0;
    if (uses.lights === 0) usesOf.delete(caster);
    else usesOf.set(caster, uses);
  };
  const find = (object: Object3D): void => {
    if (moves(object) || found.has(object)) return;
    // What another light has taken out of shadow maps casts as well.
    const casts = object.castShadow || usesOf.has(object);
    found.set(object, casts);
    if (casts) change(object, 1, Number(isResting));
    object.addEventListener('childadded', onAdded);
    object.addEventListener('childremoved', onRemoved);
    object.children.forEach(find);
  };
  const lose = (object: Object3D): void => {
    if (found.get(object)) change(object, -1, -Number(isResting));
    found.delete(object);
    added.delete(object);
    object.removeEventListener('childadded', onAdded);
    object.removeEventListener('childremoved', onRemoved);
  };
  const loseAll = (object: Object3D): void => {
    if (roots.includes(object)) return;
    lose(object);
    object.children.forEach(loseAll);
  };
  const onAdded = ({ child }: { child: Object3D }): void => void added.add(child);
  const onRemoved = ({ child }: { child: Object3D }): void => loseAll(child);

  return {
    rest(rests) {
      if (rests !== isResting) {
        isResting = rests;
        for (const [object, casts] of found) if (casts) change(object, 0, rests ? 1 : -1);
      }
      added.forEach(find);
      added.clear();
    },
    release() {
      for (const object of [...added, ...found.keys()]) lose(object);
    },
  };
}
