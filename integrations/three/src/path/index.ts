// adumbra-three/path: sun paths, one file with the shadows of a day. The rules are in `spec/sun-path.md`.

export { PathSampler } from './sampler.js';
export { SUN_PATH_DEFAULTS, SunPathFile } from './sun-path-file.js';
export type { SunPathEvents, SunPathOptions, SunPathStats } from './sun-path-file.js';
export { sunPath } from './look-up.js';
