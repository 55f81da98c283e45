// The interface of a streamed file for lights. The implementation is in `adumbra-three/stream`, so that pages
// without streaming do not load it.

import type { Box2, DataTexture, Object3D, Texture, Vector2 } from 'three';

import type { BakedShadowFile } from '../file/shadow-file.js';
import type { GpuLookUpOptions, LookUpHeader } from '../gpu/look-up-header.js';
import type { LookUp } from '../look-ups/look-up.js';

/** A WebGLRenderer or a WebGPURenderer. */
export interface AnyRenderer {
  /** Copies part of a texture to a place in another. */
  copyTextureToTexture(source: Texture, target: Texture, region?: Box2 | null, place?: Vector2 | null): void;
  /** Uploads a texture. */
  initTexture?(texture: Texture): void;
  /** Members that only a WebGLRenderer has. */
  readonly isWebGLRenderer?: boolean;
  readonly state?: { activeTexture(unit?: number): void };
  readonly shadowMap?: { enabled: boolean; needsUpdate?: boolean };
}

/** The words of a streamed file for one light, whose texture follows the file. */
export interface StreamedWords {
  /** The words, one per texel. */
  readonly texture: DataTexture;
  /** The header of each level, the finest first. The rows of coarser levels are in them. */
  readonly lookUps: readonly LookUpHeader[];
  /** Makes the texture follow the file in a renderer too. */
  follow(renderer: AnyRenderer): void;
  /** Frees GPU resources. */
  dispose(): void;
}

/** A file whose pages come and go while it is in use. */
export interface StreamedFile extends Pick<BakedShadowFile, 'grid' | 'settings'> {
  /** The shader text that reads its words, in place of all others. */
  readonly lookUp?: LookUp;
  /**
   * For lights: gives the words of the file to a light.
   *
   * @throws ShadowFileError of the kind `TooLarge`, if a side of the texture would be longer than `maxSide`.
   */
  openWords(options: GpuLookUpOptions, maxSide: number): StreamedWords;
}

/** A file that a light can have. */
export type LightFile = BakedShadowFile | StreamedFile;

/** A file that follows an object, which the app may move, turn, and scale by one number: the root of the scene that was baked. */
export interface PlacedFile {
  readonly file: LightFile;
  /**
   * The object whose local coordinates are the file's. Objects below it rest while the file is in use, see
   * `statics` of `BakedShadowOptions`.
   */
  readonly root: Object3D;
}
