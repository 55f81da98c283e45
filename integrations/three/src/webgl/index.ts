// adumbra-three/webgl: baked shadows for WebGLRenderer.

export { attachBakedShadow } from './attach.js';
export { BAKED_SHADOW_DEFAULTS } from '../light/options.js';
export type { BakedShadow, BakedShadowOptions, ShadowOptions, ShadowStatus } from '../light/options.js';
export type { AttachedShadow } from './attach.js';
