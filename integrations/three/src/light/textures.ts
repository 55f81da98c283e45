// The files of one light as two textures, as `wgsl/words.wgsl` reads them: all words, and one row of parameters per file.

import { DataTexture, RedIntegerFormat, UnsignedIntType } from 'three';
import type { Vector3 } from 'three';

import type { BakedShadowFile } from '../file/shadow-file.js';
import { HEADER_WORDS, LookUpHeader } from '../gpu/look-up-header.js';
import { textureSize, writeSections } from '../gpu/look-up-texture.js';
import type { LookUp } from '../look-ups/look-up.js';
import { checkFiles, gpuOptions } from './options.js';
import type { BakedShadowOptions, ShadowSettings } from './options.js';

/** Header word: the file's first word in the texture of words. */
const FIRST_WORD = 104;
/** Word of the first header: the number of files in use. */
const FILE_COUNT = 105;

/** Files whose sun is farther than this from the light are not in use: the distance of two unit vectors. */
export const SAME_SUN = 1.5e-3;

/** The textures of one light. */
export class LightTextures {
  /** The files' words, one per texel. */
  readonly words: DataTexture;
  /** The files' parameters, one row per file. The files in use come first. */
  readonly headers: DataTexture;
  readonly #files: readonly BakedShadowFile[];
  readonly #lookUp: LookUp;
  #settings: ShadowSettings;
  readonly #lookUps: readonly LookUpHeader[];
  readonly #firstWords: number[] = [];
  /** Numbers of the files in use. */
  #inUse: readonly number[] = [];

  /**
   * Makes the textures. Cost: one copy of the files' words.
   *
   * @throws ShadowFileError of the kind `Layout` or `TooLarge`, if a file does not fit the look-up or the texture.
   * @throws RangeError if an option is out of its range.
   */
  constructor(files: readonly BakedShadowFile[], lookUp: LookUp, options: BakedShadowOptions) {
    checkFiles(files, lookUp);
    this.#files = files;
    this.#lookUp = lookUp;
    this.#settings = options;
    const ofGpu = gpuOptions(options, lookUp);
    this.#lookUps = files.map((file) => new LookUpHeader(file, ofGpu));
    let total = 0;
    for (const { count } of this.#lookUps) {
      this.#firstWords.push(total);
      total += count;
    }
    const [width, height] = textureSize(total, options.maxTextureSize ?? 8192);
    const words = new Uint32Array(width * height);
    this.#lookUps.forEach((lookUp, i) => writeSections(lookUp, words, this.#firstWords[i]!));
    this.words = dataTexture(words, width, height);
    this.headers = dataTexture(new Uint32Array(HEADER_WORDS * files.length), HEADER_WORDS, files.length);
    this.#writeHeaders();
  }

  /**
   * Changes filter, bias or softness; what is left out stays. Less than 1 KiB per file is uploaded.
   *
   * @throws RangeError if a setting is out of its range. Nothing is changed then.
   */
  setLookUp(changed: ShadowSettings): void {
    const settings = { ...this.#settings, ...changed };
    const ofGpu = gpuOptions(settings, this.#lookUp);
    for (const lookUp of this.#lookUps) lookUp.setLookUp(ofGpu);
    this.#settings = settings;
    this.#writeHeaders();
  }

  /**
   * Puts the files into use whose sun is in this direction, a unit vector in world space.
   *
   * @returns How many there are. With 0, look-ups return 1.
   */
  use(towardsLight: Vector3): number {
    const inUse: number[] = [];
    this.#files.forEach(({ grid: { sun } }, i) => {
      const away = Math.hypot(sun[0] - towardsLight.x, sun[1] - towardsLight.y, sun[2] - towardsLight.z);
      if (away <= SAME_SUN) inUse.push(i);
    });
    if (inUse.join() !== this.#inUse.join()) {
      this.#inUse = inUse;
      this.#writeHeaders();
    }
    return inUse.length;
  }

  /** Frees what the GPU holds. */
  dispose(): void {
    this.words.dispose();
    this.headers.dispose();
  }

  #writeHeaders(): void {
    const rows = this.headers.image.data as Uint32Array;
    this.#inUse.forEach((file, row) => {
      const at = HEADER_WORDS * row;
      rows.set(this.#lookUps[file]!.words, at);
      rows[at + FIRST_WORD] = this.#firstWords[file]!;
    });
    rows[FILE_COUNT] = this.#inUse.length;
    this.headers.needsUpdate = true;
  }
}

function dataTexture(words: Uint32Array<ArrayBuffer>, width: number, height: number): DataTexture {
  // The format that the GPU gets is left to the renderer: WebGPU and WebGL2 name it differently.
  const texture = new DataTexture(words, width, height, RedIntegerFormat, UnsignedIntType);
  texture.needsUpdate = true;
  return texture;
}
