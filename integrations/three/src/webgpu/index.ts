// adumbra-three/webgpu: baked shadows for WebGPURenderer, on WebGPU and on its WebGL2 fallback.

export { BakedShadowNode } from './baked-shadow-node.js';
export { BAKED_SHADOW_DEFAULTS } from '../light/options.js';
export type { BakedShadow, BakedShadowOptions, ShadowOptions, ShadowStatus } from '../light/options.js';
export type { BakedShadowNodeOptions, Movers } from './baked-shadow-node.js';
