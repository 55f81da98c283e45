// The look-up `packed`.

import glsl from '../generated/packed.glsl.js';
import wgsl from '../generated/packed.wgsl.js';
import type { LookUp } from './look-up.js';

/** Looks up files of the layout `packed`. */
export const packed: LookUp = { name: 'packed', layout: 'packed', isSoft: false, wgsl, glsl };
