// adumbra-three/stream: shadow files of any size, of which a limited part is held. The rules are in
// `spec/streaming.md`.

export type { LevelStats, StreamEvents, StreamOptions, StreamStats } from './streamed-shadow-file.js';
export { STREAM_DEFAULTS, StreamedShadowFile } from './streamed-shadow-file.js';
export { StreamedSampler } from './sampler.js';
export type { FetchOptions } from './source.js';
