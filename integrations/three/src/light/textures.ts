// The files of one light as two textures, as `wgsl/words.wgsl` reads them: all words, and one row of
// parameters per file.

import { DataTexture, RedIntegerFormat, UnsignedIntType } from 'three';

import type { BakedShadowFile } from '../file/shadow-file.js';
import { HEADER_WORDS, lookUpHeader } from '../gpu/look-up-header.js';
import { textureSize, writeWords } from '../gpu/look-up-texture.js';
import { placedGrid } from '../grid/placement.js';
import type { WorldFromFile } from '../grid/placement.js';
import type { Vec3 } from '../grid/vec3.js';
import type { LookUp } from '../look-ups/look-up.js';
import { BAKED_SHADOW_DEFAULTS, MAX_FILES, checkFiles, gpuOptions } from './options.js';
import type { LightSettings, ShadowOptions } from './options.js';
import type { AnyRenderer, LightFile } from './streamed.js';

/** The textures of one light. */
export interface LightTextures {
  /** The files' words, one per texel. */
  readonly words: DataTexture;
  /** The files' parameters, one row per file. The files in use come first. */
  readonly headers: DataTexture;
  /** Whether the words are those of a streamed file, which writes them. */
  readonly isStreamed: boolean;
  /**
   * Changes options; options that are left out stay. Less than 1 KiB per file is uploaded.
   *
   * @throws RangeError if an option is out of its range. Nothing is changed then.
   */
  setOptions(changed: ShadowOptions): void;
  /**
   * Places a file's world in the app's, and returns its sun there.
   *
   * @throws RangeError if the matrix does anything but move, turn, and scale by one number. Nothing is changed then.
   */
  place(file: number, worldFromFile: WorldFromFile): Vec3;
  /** Puts the files with these numbers into use. With none, look-ups return 1. */
  use(now: readonly number[]): void;
  /** Makes the words follow a streamed file in a renderer. */
  follow(renderer: AnyRenderer): void;
  /** Frees GPU resources, except those that `later` textures use. */
  dispose(later?: LightTextures): void;
}

/**
 * Makes the textures, or reuses `earlier` ones if they have room and do not belong to a streamed file. Cost:
 * one copy of the files' words.
 *
 * @throws ShadowFileError of the kind `TooLarge`, if a file does not fit the texture.
 * @throws RangeError if an option is out of its range.
 */
export function lightTextures(files: readonly LightFile[], lookUp: LookUp, options: LightSettings, earlier?: LightTextures): LightTextures {
  checkFiles(files);
  let current: ShadowOptions = options;
  /** Where the app has placed the files' worlds. */
  const placements: (WorldFromFile | undefined)[] = [];
  const ofGpu = gpuOptions(options, lookUp);
  const maxSide = options.maxTextureSize ?? BAKED_SHADOW_DEFAULTS.maxTextureSize;
  // A streamed file is the only one.
  const first = files[0];
  const streamed = first && 'openWords' in first ? first.openWords(ofGpu, maxSide) : undefined;
  const lookUps = streamed?.lookUps ?? (files as readonly BakedShadowFile[]).map((file) => lookUpHeader(file, ofGpu));
  /** Numbers of the files in use. */
  let inUse: readonly number[] = [];
  let total = 0;
  const firstWords = lookUps.map(({ count }) => (streamed ? 0 : (total += count) - count));
  const words = streamed?.texture ?? allWords();
  // A level of a streamed file has a row as well.
  const headers = earlier?.headers ?? dataTexture(new Uint32Array(HEADER_WORDS * MAX_FILES), HEADER_WORDS, MAX_FILES);
  const rows = headers.image.data as Uint32Array;

  function allWords(): DataTexture {
    const [width, height] = textureSize(total, maxSide);
    const kept = earlier?.isStreamed === false ? earlier.words : undefined;
    const hasRoom = kept !== undefined && (kept.image.data as Uint32Array).length >= total;
    const texture = hasRoom ? kept : dataTexture(new Uint32Array(width * height), width, height);
    lookUps.forEach((each, i) => writeWords(each, texture.image.data as Uint32Array<ArrayBuffer>, firstWords[i]!));
    texture.needsUpdate = true;
    return texture;
  }

  /** Header word: the file's first word in the texture of words. */
  const FIRST_WORD = 104;
  /** Word of the first header: the number of files in use. */
  const FILE_COUNT = 105;
  const writeHeaders = (): void => {
    // All levels of a streamed file are in use with it.
    const shown = streamed && inUse.length > 0 ? [...lookUps.keys()] : inUse;
    shown.forEach((file, row) => {
      const at = HEADER_WORDS * row;
      rows.set(lookUps[file]!.words, at);
      rows[at + FIRST_WORD] = firstWords[file]!;
    });
    rows[FILE_COUNT] = inUse.length;
    headers.needsUpdate = true;
  };

  /** Sets options and placements of all look-ups. The levels of a streamed file have its placement. */
  const look = (all: ShadowOptions, places: typeof placements): ShadowOptions => {
    const each = gpuOptions(all, lookUp);
    lookUps.forEach((header, i) => header.setLookUp({ ...each, placement: places[streamed ? 0 : i] }));
    return all;
  };

  writeHeaders();
  return {
    words,
    headers,
    isStreamed: streamed !== undefined,
    setOptions(changed) {
      current = look({ ...current, ...changed }, placements);
      writeHeaders();
    },
    place(file, worldFromFile) {
      const { sun } = placedGrid(files[file]!.grid, worldFromFile);
      placements[file] = worldFromFile;
      look(current, placements);
      writeHeaders();
      return sun;
    },
    use(now) {
      if (now.join() === inUse.join()) return;
      inUse = now;
      writeHeaders();
    },
    follow: (renderer) => streamed?.follow(renderer),
    dispose(later) {
      if (later?.words !== words) (streamed ?? words).dispose();
      if (later?.headers !== headers) headers.dispose();
    },
  };
}

/** Makes a texture of words. */
export function dataTexture(words: Uint32Array<ArrayBuffer>, width: number, height: number): DataTexture {
  // The format that the GPU gets is left to the renderer: WebGPU and WebGL2 name it differently.
  const texture = new DataTexture(words, width, height, RedIntegerFormat, UnsignedIntType);
  texture.needsUpdate = true;
  return texture;
}
