// The files of one light as two textures, as `wgsl/words.wgsl` reads them: all words, and one row of parameters per file.

import { DataTexture, RedIntegerFormat, UnsignedIntType } from 'three';

import type { BakedShadowFile } from '../file/shadow-file.js';
import { HEADER_WORDS, lookUpHeader } from '../gpu/look-up-header.js';
import { textureSize, writeWords } from '../gpu/look-up-texture.js';
import type { LookUp } from '../look-ups/look-up.js';
import { checkFiles, gpuOptions } from './options.js';
import type { BakedShadowOptions, ShadowOptions } from './options.js';
import type { AnyRenderer, LightFile } from './streamed.js';

/** The textures of one light. */
export interface LightTextures {
  /** The files' words, one per texel. */
  readonly words: DataTexture;
  /** The files' parameters, one row per file. The files in use come first. */
  readonly headers: DataTexture;
  /**
   * Changes options; what is left out stays. Less than 1 KiB per file is uploaded.
   *
   * @throws RangeError if an option is out of its range. Nothing is changed then.
   */
  setOptions(changed: ShadowOptions): void;
  /** Puts the files with these numbers into use. With none, look-ups return 1. */
  use(now: readonly number[]): void;
  /** Has the words follow a streamed file in a renderer. */
  follow(renderer: AnyRenderer): void;
  /** Frees what the GPU holds. */
  dispose(): void;
}

/**
 * Makes the textures. Cost: one copy of the files' words.
 *
 * @throws ShadowFileError of the kind `TooLarge`, if a file does not fit the texture.
 * @throws RangeError if an option is out of its range.
 */
export function lightTextures(files: readonly LightFile[], lookUp: LookUp, options: BakedShadowOptions): LightTextures {
  checkFiles(files);
  let current: ShadowOptions = options;
  const ofGpu = gpuOptions(options, lookUp);
  const maxSide = options.maxTextureSize ?? 8192;
  // A streamed file is alone.
  const first = files[0]!;
  const streamed = 'openWords' in first ? first.openWords(ofGpu, maxSide) : undefined;
  const lookUps = streamed?.lookUps ?? (files as readonly BakedShadowFile[]).map((file) => lookUpHeader(file, ofGpu));
  /** Numbers of the files in use. */
  let inUse: readonly number[] = [];
  let total = 0;
  const firstWords = lookUps.map(({ count }) => (streamed ? 0 : (total += count) - count));
  const words = streamed?.texture ?? allWords();
  const rows = new Uint32Array(HEADER_WORDS * lookUps.length);
  const headers = dataTexture(rows, HEADER_WORDS, lookUps.length);

  function allWords(): DataTexture {
    const [width, height] = textureSize(total, maxSide);
    const all = new Uint32Array(width * height);
    lookUps.forEach((each, i) => writeWords(each, all, firstWords[i]!));
    return dataTexture(all, width, height);
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

  writeHeaders();
  return {
    words,
    headers,
    setOptions(changed) {
      const all = { ...current, ...changed };
      const changedOfGpu = gpuOptions(all, lookUp);
      for (const each of lookUps) each.setLookUp(changedOfGpu);
      current = all;
      writeHeaders();
    },
    use(now) {
      if (now.join() === inUse.join()) return;
      inUse = now;
      writeHeaders();
    },
    follow: (renderer) => streamed?.follow(renderer),
    dispose() {
      (streamed ?? words).dispose();
      headers.dispose();
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
