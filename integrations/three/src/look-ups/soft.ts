// The look-up `soft`.

import glsl from '../generated/soft.glsl.js';
import wgsl from '../generated/soft.wgsl.js';
import type { LookUp } from './look-up.js';

/** Looks up with the penumbrae of a sun that is a disc. */
export const soft: LookUp = { name: 'soft', isSoft: true, wgsl, glsl };
