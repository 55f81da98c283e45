// adumbra-three/look-ups: the shader texts. `filtered` is what the other entries use by default. A page that names `soft`
// carries that text too.

export { filtered } from './filtered.js';
export type { LookUp } from './look-up.js';
export { soft } from './soft.js';
