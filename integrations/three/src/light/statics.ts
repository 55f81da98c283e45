// What is in a file, and what moves, as far as the app says.

import type { Object3D } from 'three';

/** Whether an object moves, even below a static root. It is no part of a bake then. */
export function moves(object: Object3D): boolean {
  const { userData } = object as { userData?: { adumbra?: { cast?: boolean } } | null };
  return userData?.adumbra?.cast === true || 'isSkinnedMesh' in object;
}

/** Whether an object is in no file, as far as the roots of what is in the files tell. */
export function isMover(object: Object3D, roots: readonly Object3D[]): boolean {
  for (let each: Object3D | null = object; each !== null; each = each.parent) {
    if (moves(each)) return true;
    if (roots.includes(each)) return false;
  }
  return roots.length > 0;
}
