// The look-up `depths`.

import glsl from '../generated/depths.glsl.js';
import wgsl from '../generated/depths.wgsl.js';
import type { LookUp } from './look-up.js';

/** Looks up files of the layout `depths`. */
export const depths: LookUp = { name: 'depths', layout: 'depths', isSoft: false, wgsl, glsl };
