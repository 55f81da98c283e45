// adumbra-three/webgl: baked shadows for WebGLRenderer.

export { attachBakedShadow } from './attach.js';
export type { AttachedShadow } from './attach.js';
