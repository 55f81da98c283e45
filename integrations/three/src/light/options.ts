// The options of baked shadows on a light, which all renderers share, and their checks.

import type { Object3D } from 'three';

import type { GpuLookUpOptions } from '../gpu/look-up-header.js';
import type { LookUp } from '../look-ups/look-up.js';
import type { Bias, FilterWidth } from '../settings.js';
import type { LightFile, PlacedFile } from './streamed.js';

/**
 * The file of a light, or several: tiles, suns, one file in several places. A streamed file must be the only
 * one.
 */
export type FileChoice = LightFile | PlacedFile | readonly (LightFile | PlacedFile)[];

/** Most files on one light. */
export const MAX_FILES = 8;

/** The options that may change at any time. `undefined` is the default. */
export interface ShadowOptions {
  /** Width of the filter in texels, by default 5; 1 is a hard edge. Not with `sunDegrees`. */
  filter?: FilterWidth | undefined;
  /** The bias; each file's own by default. */
  bias?: Bias | undefined;
  /** Angle of the sun's disc in degrees, 0.01 to 20; by default 0.53, the real one. Only with the look-up `soft`. */
  sunDegrees?: number | undefined;
}

/** The state of a light and its files. */
export interface ShadowStatus {
  /**
   * How many files are in use: those whose sun is where the light shines from. None while the light does not
   * shine.
   */
  readonly filesInUse: number;
  /** How many files cannot be in use, wherever the light is, because their root is stretched. */
  readonly missing: number;
  /** The angle between the light and the nearest sun of a file, degrees. Files are in use up to 0.08. */
  readonly degrees: number;
}

/** The shadow of a light from its files, with either renderer. */
export interface BakedShadow {
  /**
   * Whether the light shines, and from the sun of a file. Otherwise only three's own shadows are drawn, if
   * there are any.
   */
  readonly isActive: boolean;
  /** The state of the light and its files. */
  readonly status: ShadowStatus;
  /**
   * Changes options; options that are left out stay. Nothing is recompiled.
   *
   * @throws RangeError if an option is out of its range. Nothing is changed then.
   */
  setOptions(options: ShadowOptions): void;
  /**
   * Replaces the files, for example as tiles come and go. With `[]`, no file is in use. Cost: one copy of the
   * files' words, and their upload. The previous files need not be kept.
   *
   * @throws ShadowFileError of the kind `TooLarge`, if a file does not fit the GPU. Nothing is changed then.
   * @throws RangeError if they are too many, or need another look-up, as a sun path does. Nothing is changed then.
   */
  setFiles(file: FileChoice): void;
  /** Restores everything as the app set it last, and frees GPU resources. */
  dispose(): void;
}

/** Options of baked shadows on a light. */
export interface BakedShadowOptions extends ShadowOptions {
  /** The light's file, or several. */
  file: FileChoice;
  /** The shader text; `filtered` by default. */
  lookUp?: LookUp;
  /**
   * Keeps the light at the sun of its files, if they have one sun, and warns once if the app turns it away.
   * True by default. `dispose` restores the light as the app set it last.
   */
  align?: boolean;
  /**
   * The roots of the objects in the files. While a file is in use, no object below them casts in three's own
   * shadow maps, except skinned meshes, which a bake leaves out. Set `userData.adumbra = { cast: true }` on
   * other objects that move. `castShadow` of the objects stays the app's: it is false while three draws, and
   * a value that is written to it during that time is lost.
   */
  statics?: Object3D | readonly Object3D[];
  /** Largest side of a texture, texels. 8192 by default, which every device with WebGPU has. */
  maxTextureSize?: number;
}

/** The options apart from the file. */
export type LightSettings = Omit<BakedShadowOptions, 'file'>;

/**
 * What baked shadows use where their options are left out: `filter` with the look-up `filtered`, `sunDegrees`
 * with `soft`.
 */
export const BAKED_SHADOW_DEFAULTS = { filter: 5, sunDegrees: 0.53, align: true, maxTextureSize: 8192 } as const;

/** Returns the options as a look-up of a file takes them. */
export function gpuOptions({ filter, bias, sunDegrees }: ShadowOptions, lookUp: LookUp): GpuLookUpOptions {
  if (!lookUp.isSoft) {
    if (sunDegrees !== undefined) {
      throw new RangeError("sunDegrees needs lookUp: soft, from 'adumbra-three/look-ups'");
    }
    return { filter, bias };
  }
  /** The widest penumbra, texels: that of `voxel:soft` and of the plugin for Bevy. */
  const MAX_PENUMBRA_TEXELS = 32;
  if (filter !== undefined) throw new RangeError('soft has no filter; set sunDegrees');
  return { bias, penumbra: { sunDegrees: sunDegrees ?? BAKED_SHADOW_DEFAULTS.sunDegrees, maxRadiusTexels: MAX_PENUMBRA_TEXELS } };
}

/** Checks that files can be on one light. */
export function checkFiles(files: readonly LightFile[]): void {
  if (files.length > MAX_FILES) throw new RangeError(`a light takes up to ${MAX_FILES} files, not ${files.length}`);
  if (files.length > 1 && files.some((file) => 'openWords' in file)) {
    throw new RangeError('a streamed file must be the only one of its light');
  }
}

/** Returns files with their roots, without keeping the app's own objects. */
export function asPlaced(files: FileChoice): { file: LightFile; root?: Object3D }[] {
  return asList(files, 'file').map((each) => {
    const { file, root } = 'file' in each ? each : { file: each };
    if (!('settings' in there(file, 'file'))) throw new TypeError('no shadow file; await loadAsync');
    return 'root' in each ? { file, root: inScene(root, 'root') } : { file };
  });
}

/** Returns one or several values of an option as a new list. */
export function asList<T>(values: T | readonly T[] | undefined, name: string): readonly T[] {
  const list = values === undefined ? [] : Array.isArray(values) ? (values as readonly T[]) : [values as T];
  return list.map((each) => there(each, name));
}

/** Returns an object that the app gave, if it can be in a scene: a glTF file cannot. */
export function inScene(object: Object3D | null | undefined, name: string): Object3D {
  if (object?.isObject3D) return object;
  throw new TypeError(`${name} is ${object}; give an Object3D, such as gltf.scene`);
}

/**
 * Returns a value that the app gave, and throws if it is missing: a reference may not be set yet, or an
 * object was not found.
 */
function there<T>(value: T, name: string): T {
  if (value == null) throw new TypeError(`${name} is ${value}`);
  return value;
}

/**
 * Returns a copy of options, because the app may change its own object. Options that are left out stay so.
 */
export function copied<T extends ShadowOptions>(options: T): T {
  const { bias } = options;
  return bias ? { ...options, bias: { ...bias } } : { ...options };
}
