// The look-up texture: a file's words and the parameters of its look-up in rows of texels, one word each.
// `spec/look-up-texture.md` describes it. Counterpart of `crates/adumbra/src/gpu/texture.rs`.

import { ShadowFileError } from '../error.js';
import type { BakedShadowFile } from '../file/shadow-file.js';
import type { Vec3 } from '../grid/vec3.js';
import { HEADER_WORDS, lookUpHeader, wordCount } from './look-up-header.js';
import type { GpuLookUpOptions, LookUpHeader } from './look-up-header.js';


/**
 * A file as a texture, with the parameters of look-ups in its header.
 *
 * Positions in the shader are relative to `anchorWorld`, so nothing has to be uploaded per frame. If filter,
 * bias or penumbrae change, only the header does.
 */
export class LookUpTexture {
  /** Texels per row, a power of two, at least 128. */
  declare readonly width: number;
  /** Number of rows. */
  declare readonly height: number;
  /** All texels, row by row: word w is in column w mod width. */
  declare readonly words: Uint32Array<ArrayBuffer>;
  readonly #header: LookUpHeader;

  /**
   * Creates a texture of at most `maxSide` texels along each side, as square as a power of two allows. Cost:
   * one copy of the file's words.
   *
   * @throws ShadowFileError of the kind `TooLarge` if the file needs more texels, or if its grid is too large for GPUs.
   * @throws RangeError if an option is out of its range.
   */
  constructor(file: BakedShadowFile, maxSide: number, options: GpuLookUpOptions) {
    [this.width, this.height] = textureSize(wordCount(file), maxSide);
    this.words = new Uint32Array(this.width * this.height);
    this.#header = lookUpHeader(file, options, this.words);
    writeWords(this.#header, this.words, HEADER_WORDS);
  }

  /** World position that positions in the shader are relative to; each coordinate is a 32-bit floating-point number. */
  get anchorWorld(): Vec3 {
    return this.#header.anchorWorld;
  }

  /** The header: the first 128 words. This is all that {@link LookUpTexture.setLookUp} changes. */
  get header(): Uint32Array<ArrayBuffer> {
    return this.#header.words;
  }

  /**
   * Changes filter, bias and penumbrae of look-ups in the header.
   *
   * @throws RangeError if an option is out of its range.
   */
  setLookUp(options: GpuLookUpOptions): void {
    this.#header.setLookUp(options);
  }
}

/** Writes a file's words from a place of `words` on. */
export function writeWords({ parts }: LookUpHeader, words: Uint32Array, from: number): void {
  let at = from;
  for (const part of parts) {
    words.set(part, at);
    at += part.length;
  }
}

/**
 * Returns width and height of the texture with the least area, and among equals the widest, whose width is a
 * power of two.
 *
 * @throws ShadowFileError of the kind `TooLarge` if a side would be longer than `maxSide`.
 */
export function textureSize(fileWords: number, maxSide: number): [width: number, height: number] {
  // The first row of the narrowest texture is the header.
  const MIN_WIDTH = HEADER_WORDS;
  const texels = HEADER_WORDS + fileWords;
  let square = MIN_WIDTH;
  while (square * square < texels) square *= 2;
  // If the square is too wide, half the width with twice the rows may fit.
  for (const width of [square, square / 2]) {
    const height = Math.ceil(texels / width);
    if (width >= MIN_WIDTH && width <= maxSide && height <= maxSide) return [width, height];
  }
  throw new ShadowFileError(
    'TooLarge',
    `the file needs ${texels} texels, but a texture of ${maxSide} × ${maxSide} has ${maxSide * maxSide}; bake at a lower resolution`,
    { texels, maxSide },
  );
}
