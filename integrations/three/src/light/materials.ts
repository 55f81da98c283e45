// The materials of a part of the world.

import type { Material, Object3D } from 'three';

/** Visits the materials of an object and of all below it. Some may be missing. */
export function forEachMaterial(object: Object3D, visit: (material: Material) => void): void {
  const { material } = object as { material?: Material | (Material | undefined)[] | null };
  if (Array.isArray(material)) for (const one of material) visitOne(one, visit);
  else visitOne(material, visit);
  for (const child of object.children) forEachMaterial(child, visit);
}

function visitOne(material: Material | null | undefined, visit: (material: Material) => void): void {
  if (material?.isMaterial) visit(material);
}
