// adumbra-three/webgl: baked shadows for WebGLRenderer.

import { checkRevision } from '../revision.js';

export { attachBakedShadow } from './attach.js';
export type { AttachedShadow } from './attach.js';

checkRevision();
