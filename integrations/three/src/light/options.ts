// The options of baked shadows on a light, which all renderers share, and their checks.

import type { Object3D } from 'three';

import type { GpuLookUpOptions } from '../gpu/look-up-header.js';
import type { LookUp } from '../look-ups/look-up.js';
import type { Bias, FilterWidth } from '../settings.js';
import type { LightFile } from './streamed.js';

/** Most files on one light. */
export const MAX_FILES = 8;

/** The options that may change at any time. `undefined` is the default. */
export interface ShadowOptions {
  /** Width of the filter in texels, by default 5; 1 is a hard edge. Not with `softnessDegrees`. */
  filter?: FilterWidth | undefined;
  /** The bias; each file's own by default. */
  bias?: Bias | undefined;
  /** Angle of the sun's disc in degrees, 0.01 to 20; by default 0.53, the real one. Only with the look-up `soft`. */
  softnessDegrees?: number | undefined;
}

/** The shadow of a light from its files, with either renderer. */
export interface BakedShadow {
  /** Whether the light shines from the sun of a file. Otherwise shadows are those of three's own, if there are any. */
  readonly isActive: boolean;
  /**
   * Changes options; what is left out stays. Nothing is compiled anew.
   *
   * @throws RangeError if an option is out of its range. Nothing is changed then.
   */
  setOptions(options: ShadowOptions): void;
  /** Gives all back as it was, and frees what the GPU holds. */
  dispose(): void;
}

/** Options of baked shadows on a light. */
export interface BakedShadowOptions extends ShadowOptions {
  /** The shader text; `filtered` by default. */
  lookUp?: LookUp;
  /** Turns the light to the sun of the first file. True by default. */
  align?: boolean;
  /**
   * The roots of what the files hold. While a file is in use, nothing below them casts in three's own shadow maps but
   * skinned meshes, which a bake leaves out. Set `userData.adumbra = { cast: true }` on what else moves. What is added below
   * them later rests from the next frame on, and what is removed casts again.
   */
  statics?: Object3D | readonly Object3D[];
  /** Largest side of a texture, texels. 8192 by default, which every device with WebGPU has. */
  maxTextureSize?: number;
}

/** Returns the options as a look-up of a file takes them. */
export function gpuOptions({ filter, bias, softnessDegrees }: ShadowOptions, lookUp: LookUp): GpuLookUpOptions {
  if (!lookUp.isSoft) {
    if (softnessDegrees !== undefined) {
      throw new RangeError("softnessDegrees needs lookUp: soft, from 'adumbra-three/look-ups'");
    }
    return { filter: filter ?? 5, bias };
  }
  /** The widest penumbra, texels: that of `voxel:soft` and of the plugin for Bevy. */
  const MAX_PENUMBRA_TEXELS = 32;
  if (filter !== undefined) throw new RangeError('the look-up soft has no filter; set softnessDegrees');
  return { filter: 1, bias, penumbra: { angleDegrees: softnessDegrees ?? 0.53, maxRadiusTexels: MAX_PENUMBRA_TEXELS } };
}

/** Checks that files can be on one light. */
export function checkFiles(files: readonly LightFile[]): void {
  if (files.length === 0 || files.length > MAX_FILES) {
    throw new RangeError(`a light takes 1 to ${MAX_FILES} files, but got ${files.length}`);
  }
  if (files.length > 1 && files.some((file) => 'openWords' in file)) {
    throw new RangeError('a streamed file must be the only one of its light; give the other files to a light of their own');
  }
}

/** Returns one or several values as a list. */
export function asList<T>(values: T | readonly T[] | undefined): readonly T[] {
  if (values === undefined) return [];
  return Array.isArray(values) ? (values as readonly T[]) : [values as T];
}
