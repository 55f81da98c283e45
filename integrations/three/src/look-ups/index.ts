// adumbra-three/look-ups: the shader texts for each layout. `depths`, the layout that `adumbra bake` writes, is what the
// other entries use by default. A page that names another one carries that text too.

export { depths } from './depths.js';
export type { LookUp } from './look-up.js';
export { packed } from './packed.js';
export { plain } from './plain.js';
export { soft } from './soft.js';
