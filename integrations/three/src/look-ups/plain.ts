// The look-up `plain`.

import glsl from '../generated/plain.glsl.js';
import wgsl from '../generated/plain.wgsl.js';
import type { LookUp } from './look-up.js';

/** Looks up files of the layout `plain`. */
export const plain: LookUp = { name: 'plain', layout: 'plain', isSoft: false, wgsl, glsl };
