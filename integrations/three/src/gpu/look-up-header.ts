// The header of a look-up texture: the parameters of look-ups in a file. `spec/look-up-texture.md` describes it.
// Counterpart of `crates/adumbra/src/gpu/parameters.rs`.

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

/** The header of a file. Its words change with the settings of look-ups, and with nothing else. */
export class LookUpHeader {
  /** The 128 words. */
  readonly words: Uint32Array<ArrayBuffer>;
  /** The file's sections in the order of the texture. */
  readonly sections: readonly Uint32Array[];
  /** Number of words of the sections. */
  readonly count: number;
  /** World position that positions in the shader are relative to; each coordinate is a 32-bit floating-point number. */
  readonly anchorWorld: Vec3;
  readonly #file: BakedShadowFile;
  readonly #parameters: WordViews;

  /**
   * Creates the header in the first 128 words of `words`.
   *
   * @throws ShadowFileError of the kind `TooLarge` if the file's grid is too large for GPUs.
   * @throws RangeError if an option is out of its range.
   */
  constructor(file: BakedShadowFile, options: GpuLookUpOptions, words = new Uint32Array(HEADER_WORDS)) {
    const { layout, grid, top, nodes, leafMasks } = file;
    this.#file = file;
    this.words = words.subarray(0, HEADER_WORDS);
    this.sections = sectionsOf(file);
    this.count = wordCount(file);
    this.anchorWorld = middle(grid);
    const header = viewsOf(this.words, 0, PARAMETERS_AT);
    header.words.set([MAGIC, VERSION, LAYOUTS.indexOf(layout), this.count]);
    header.floats.set(this.anchorWorld, 4);
    header.floats.set(grid.sun, 8);

    const parameters = viewsOf(this.words, PARAMETERS_AT, 88);
    this.#parameters = parameters;
    writeGridParameters(parameters, grid, this.anchorWorld);
    const [rootsX, rootsY, rootsZ] = file.topDims;
    parameters.words.set([rootsX, rootsY, layout === 'depths' ? 1 : rootsZ, file.rootLevel], 68);
    const second = top.length;
    const third = second + (layout === 'depths' ? leafMasks : nodes).length;
    parameters.words.set([second, third], layout === 'depths' ? 78 : 76);
    parameters.floats.set(circleAcrossLight(grid), 84);
    this.setLookUp(options);
  }

  /**
   * Changes filter, bias and penumbrae of look-ups.
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

/** Returns a file's sections in the order of the texture. */
function sectionsOf({ layout, top, nodes, leafMasks }: BakedShadowFile): readonly Uint32Array[] {
  return layout === 'depths' ? [top, leafMasks, nodes] : [top, nodes, leafMasks];
}

/** Returns the number of words of a file's sections. */
export function wordCount({ top, nodes, leafMasks }: BakedShadowFile): number {
  return top.length + nodes.length + leafMasks.length;
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
