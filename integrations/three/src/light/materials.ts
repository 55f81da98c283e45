// The materials of a part of the world.

import type { Material, Object3D } from 'three';

import { asList } from './options.js';

/** Visits the materials of an object and of all below it. */
export function forEachMaterial(object: Object3D, visit: (material: Material) => void): void {
  object.traverse((each) => {
    const { material } = each as { material?: Material | Material[] };
    for (const one of asList(material)) visit(one);
  });
}
