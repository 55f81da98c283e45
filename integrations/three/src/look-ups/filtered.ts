// The look-up `filtered`.

import glsl from '../generated/filtered.glsl.js';
import wgsl from '../generated/filtered.wgsl.js';
import type { LookUp } from './look-up.js';

/** Looks up with a filter of K × K taps. */
export const filtered: LookUp = { name: 'filtered', isSoft: false, wgsl, glsl };
