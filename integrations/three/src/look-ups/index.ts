// adumbra-three/look-ups: the shader texts. The other entries use `filtered` by default. A page that names
// `soft` loads that text too.

export { filtered } from './filtered.js';
export type { LookUp } from './look-up.js';
export { soft } from './soft.js';
