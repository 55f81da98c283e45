// adumbra-three: baked sun shadows for three.js. This entry reads `.adumbra` files and looks points up on the
// CPU; the entries `./webgpu` and `./webgl` put a file's shadows into materials.

export { ShadowFileError } from './error.js';
export type { ShadowFileErrorDetails, ShadowFileErrorKind, ShadowFileFault } from './error.js';
export { BakedShadowFile, PARSE_DEFAULTS } from './file/shadow-file.js';
export type { ParseOptions } from './file/shadow-file.js';
export type { GpuLookUpOptions, Penumbra } from './gpu/look-up-header.js';
export { LookUpTexture } from './gpu/look-up-texture.js';
export type { Bounds, LightGrid } from './grid/light-grid.js';
export { placedGrid } from './grid/placement.js';
export type { WorldFromFile } from './grid/placement.js';
export type { Mat3, PointLike, Vec3 } from './grid/vec3.js';
export { MissingHookError } from './light/three.js';
export { ShadowFileLoader } from './loader.js';
export { Sampler } from './sampler/sampler.js';
export { FILTER_WIDTHS, LOOK_UP_DEFAULTS } from './settings.js';
export type { Bias, FileSettings, FilterWidth, LookUpOptions } from './settings.js';
