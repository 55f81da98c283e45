// The look-up texture: a file's words and the parameters of its look-up in rows of texels, one word each.
// `spec/look-up-texture.md` describes it. Counterpart of `crates/adumbra/src/gpu/texture.rs` and `parameters.rs`.

import { ShadowFileError } from '../error.js';
import type { BakedShadowFile } from '../file/shadow-file.js';
import { circleAcrossLight, coneTexelsPerVoxel, middle } from '../grid/light-grid.js';
import type { Vec3 } from '../grid/vec3.js';
import { LAYOUTS, checkFilter } from '../settings.js';
import type { Bias, LookUpOptions } from '../settings.js';
import { writeGridParameters } from './grid-parameters.js';
import type { WordViews } from './grid-parameters.js';

/** First word of a look-up texture: "ADUT". */
const MAGIC = 0x54554441;
/** Version of the look-up texture that is made. */
const VERSION = 2;
/** Number of words of the header, which precede the file's words. */
export const HEADER_WORDS = 128;
/** First word of the parameter block. */
export const PARAMETERS_AT = 16;
/** Width of the narrowest texture: its first row is the header. */
const MIN_WIDTH = HEADER_WORDS;

/** The penumbrae of a sun that is a disc, in place of a filter. */
export interface Penumbra {
  /** Full angle of the sun, degrees, 0.01 to 20. */
  readonly angleDegrees: number;
  /** Largest radius of a penumbra, texels, 1 to 64; in the oblique frame its short one. */
  readonly maxRadiusTexels: number;
}

/** Settings of look-ups on a GPU. */
export interface GpuLookUpOptions extends LookUpOptions {
  /** Penumbrae, for which the filter must be 1; in files of the layout `depths` only. */
  readonly penumbra?: Penumbra;
}

/**
 * A file as a texture, with the parameters of look-ups in its header.
 *
 * Positions in the shader are relative to `anchorWorld`, so nothing has to be uploaded per frame. If filter, bias or
 * penumbrae change, only the header does.
 */
export class LookUpTexture {
  /** Texels per row, a power of two, at least 128. */
  readonly width: number;
  /** Number of rows. */
  readonly height: number;
  /** All texels, row by row: word w is in column w mod width. */
  readonly words: Uint32Array<ArrayBuffer>;
  /** World position that positions in the shader are relative to; each coordinate is a 32-bit floating-point number. */
  readonly anchorWorld: Vec3;
  readonly #file: BakedShadowFile;
  readonly #parameters: WordViews;

  /**
   * Creates a texture of at most `maxSide` texels along each side, as square as a power of two allows. Cost: one copy of
   * the file's words.
   *
   * @throws ShadowFileError of the kind `TooLarge` if the file needs more texels, or if its grid is too large for GPUs.
   * @throws RangeError if an option is out of its range.
   */
  constructor(file: BakedShadowFile, maxSide: number, options: GpuLookUpOptions) {
    const { layout, grid, top, nodes, leafMasks } = file;
    const parts = layout === 'depths' ? [top, leafMasks, nodes] : [top, nodes, leafMasks];
    const count = top.length + nodes.length + leafMasks.length;
    [this.width, this.height] = textureSize(count, maxSide);
    this.words = new Uint32Array(this.width * this.height);
    const starts = [0, 0, 0];
    let at = HEADER_WORDS;
    parts.forEach((part, i) => {
      starts[i] = at - HEADER_WORDS;
      this.words.set(part, at);
      at += part.length;
    });

    this.#file = file;
    this.anchorWorld = middle(grid);
    const header = viewsOf(this.words, 0, PARAMETERS_AT);
    header.words.set([MAGIC, VERSION, LAYOUTS.indexOf(layout), count]);
    header.floats.set(this.anchorWorld, 4);
    header.floats.set(grid.sun, 8);

    const parameters = viewsOf(this.words, PARAMETERS_AT, 88);
    this.#parameters = parameters;
    writeGridParameters(parameters, grid, this.anchorWorld);
    const [rootsX, rootsY, rootsZ] = file.topDims;
    parameters.words.set([rootsX, rootsY, layout === 'depths' ? 1 : rootsZ, file.rootLevel], 68);
    parameters.words.set([starts[1], starts[2]], layout === 'depths' ? 78 : 76);
    parameters.floats.set(circleAcrossLight(grid), 84);
    this.setLookUp(options);
  }

  /** The header: the first 128 words. This is all that {@link LookUpTexture.setLookUp} changes. */
  get header(): Uint32Array<ArrayBuffer> {
    return this.words.subarray(0, HEADER_WORDS);
  }

  /**
   * Changes filter, bias and penumbrae of look-ups in the header.
   *
   * @throws RangeError if an option is out of its range.
   */
  setLookUp({ filter, bias = this.#file.settings.bias, penumbra }: GpuLookUpOptions): void {
    checkFilter(filter);
    checkBias(bias);
    const { words, floats } = this.#parameters;
    const { grid, layout } = this.#file;
    if (penumbra !== undefined) {
      if (layout !== 'depths') throw new RangeError(`penumbrae need a file of the layout depths, but this is ${layout}`);
      if (filter !== 1) throw new RangeError(`penumbrae replace the filter, so its width must be 1, but it is ${filter}`);
      checkRange("the sun's angle in degrees", penumbra.angleDegrees, 0.01, 20);
      checkRange('the largest radius of a penumbra in texels', penumbra.maxRadiusTexels, 1, 64);
    }
    floats.set([bias.constantTexels, bias.slopeTexels, bias.normalOffsetTexels, 1], 72);
    words[80] = filter;
    floats[81] = penumbra === undefined ? 0 : coneTexelsPerVoxel(grid, penumbra.angleDegrees);
    floats[82] = penumbra?.maxRadiusTexels ?? 0;
  }
}

function checkBias(bias: Bias): void {
  for (const texels of [bias.constantTexels, bias.slopeTexels, bias.normalOffsetTexels]) {
    checkRange('a term of the bias in texels', texels, 0, 16);
  }
}

function checkRange(name: string, value: number, low: number, high: number): void {
  if (!(value >= low && value <= high)) throw new RangeError(`${name} is ${value}, but must be from ${low} to ${high}`);
}

function viewsOf(all: Uint32Array<ArrayBuffer>, from: number, count: number): WordViews {
  const words = all.subarray(from, from + count);
  return {
    words,
    ints: new Int32Array(words.buffer, words.byteOffset, count),
    floats: new Float32Array(words.buffer, words.byteOffset, count),
  };
}

/**
 * Returns width and height of the texture with the least area, and among equals the widest, whose width is a power of two.
 *
 * @throws ShadowFileError of the kind `TooLarge` if a side would be longer than `maxSide`.
 */
export function textureSize(fileWords: number, maxSide: number): [width: number, height: number] {
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
