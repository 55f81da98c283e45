// What is done before WebGLRenderer draws a scene: one hook in each scene, for all its lights.

import type { Scene, WebGLRenderer } from 'three';

/** What is done before a renderer draws a scene. */
type Update = (renderer: WebGLRenderer) => void;

/** The hooks by the functions that three calls. */
const hooks = new WeakMap<Scene['onBeforeRender'], { updates: Set<Update>; remove(): void }>();

/** Has something done before each time a scene is drawn. Returns what ends it; after the last end the scene is as it was. */
export function beforeRender(scene: Scene, update: Update): () => void {
  const { updates, remove } = hooks.get(scene.onBeforeRender) ?? install(scene);
  updates.add(update);
  return () => {
    updates.delete(update);
    if (updates.size === 0) remove();
  };
}

function install(scene: Scene) {
  const updates = new Set<Update>();
  const before = scene.onBeforeRender;
  const now: Scene['onBeforeRender'] = (...args) => {
    for (const update of updates) update(args[0]);
    before.apply(scene, args);
  };
  const remove = (): void => {
    if (scene.onBeforeRender === now) scene.onBeforeRender = before;
  };
  scene.onBeforeRender = now;
  hooks.set(now, { updates, remove });
  return { updates, remove };
}
