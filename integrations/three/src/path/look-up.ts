// The look-up of sun paths.

import glsl from '../generated/path.glsl.js';
import wgsl from '../generated/path.wgsl.js';
import type { LookUp } from '../look-ups/look-up.js';

/** Looks up with a filter, for the sun of a moment. Lights with a sun path use it. */
export const sunPath: LookUp = { name: 'path', isSoft: false, wgsl, glsl };
