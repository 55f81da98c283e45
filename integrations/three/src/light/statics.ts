// Which objects are in a file and which ones move, according to the app.

import type { Object3D } from 'three';

/** Whether an object moves, even below a static root. A moving object is not part of a bake. */
export function moves(object: Object3D): boolean {
  const { userData } = object as { userData?: { adumbra?: { cast?: boolean } } | null };
  return userData?.adumbra?.cast === true || 'isSkinnedMesh' in object;
}

/** Whether an object is in no file, according to the roots of the objects in the files. */
export function isMover(object: Object3D, roots: readonly Object3D[]): boolean {
  for (let each: Object3D | null = object; each !== null; each = each.parent) {
    if (moves(each)) return true;
    if (roots.includes(each)) return false;
  }
  return roots.length > 0;
}
