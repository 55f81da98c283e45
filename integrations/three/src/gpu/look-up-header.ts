// The header of a look-up texture: the parameters of look-ups in a file. `spec/look-up-texture.md` describes
// it. Counterpart of `crates/adumbra/src/gpu/parameters.rs`.

import type { BakedShadowFile } from '../file/shadow-file.js';
import { circleAcrossLight, coneTexelsPerVoxel, middle } from '../grid/light-grid.js';
import type { LightGrid } from '../grid/light-grid.js';
import { placedGrid } from '../grid/placement.js';
import type { Vec3 } from '../grid/vec3.js';
import { LOOK_UP_DEFAULTS, checkFilter, checkRange } from '../settings.js';
import type { LookUpOptions } from '../settings.js';
import type { WorldFromFile } from '../grid/placement.js';
import { writeGridParameters } from './grid-parameters.js';
import type { WordViews } from './grid-parameters.js';

/** Number of words of the header, which precede the file's words. */
export const HEADER_WORDS = 128;
/** First word of the parameter block. */
export const PARAMETERS_AT = 16;

/** The penumbrae of a sun that is a disc, in place of a filter. */
export interface Penumbra {
  /** Full angle of the sun, degrees, 0.01 to 20. */
  readonly sunDegrees: number;
  /** Largest radius of a penumbra, texels, 1 to 64; in the oblique frame the shorter radius. */
  readonly maxRadiusTexels: number;
}

/** Settings of look-ups on a GPU. */
export interface GpuLookUpOptions extends LookUpOptions {
  /** Penumbrae, for which the filter must be 1 or left out. */
  readonly penumbra?: Penumbra;
}

/** The header of a file. Its words change only with the settings of look-ups. */
export interface LookUpHeader {
  /** The 128 words. */
  readonly words: Uint32Array<ArrayBuffer>;
  /** The file's words, in two parts one after the other. */
  readonly parts: readonly Uint32Array[];
  /** Number of words of both. */
  readonly count: number;
  /** World position that positions in the shader are relative to; each coordinate is a 32-bit floating-point number. */
  readonly anchorWorld: Vec3;
  /** Where the app has placed the file's world. */
  readonly placement: WorldFromFile | undefined;
  /**
   * Changes filter, bias and penumbrae of look-ups, and the placement with the anchor.
   *
   * @throws RangeError if an option is out of its range. Nothing is changed then.
   */
  setLookUp(options: GpuLookUpOptions): void;
}

/** The parts of a file, or of one of its levels, that a header needs. */
export type LookedUpFile = Pick<BakedShadowFile, 'grid' | 'settings' | 'top' | 'code' | 'topDims' | 'rootLevel'>;

/**
 * Creates the header in the first 128 words of `all`. Positions in the shader are relative to the middle of
 * the grid `middleOf`, the file's own by default.
 *
 * @throws ShadowFileError of the kind `TooLarge` if the file's grid is too large for GPUs.
 * @throws RangeError if an option is out of its range.
 */
export function lookUpHeader(
  file: LookedUpFile,
  options: GpuLookUpOptions,
  all: Uint32Array<ArrayBuffer> = new Uint32Array(HEADER_WORDS),
  middleOf: LightGrid = file.grid,
): LookUpHeader {
  /** First word of a look-up texture: "ADUT". */
  const MAGIC = 0x54554441;
  /** Version of the look-up texture that is made. */
  const VERSION = 3;
  /** The layout: a quadtree of switch depths. */
  const QUADTREE = 2;
  const { grid, settings, top, code, topDims, rootLevel } = file;
  const count = wordCount(file);
  const header = viewsOf(all, 0, HEADER_WORDS);
  header.words.set([MAGIC, VERSION, QUADTREE, count]);

  const parameters = viewsOf(header.words, PARAMETERS_AT, 88);
  const { words, floats } = parameters;
  words.set([...topDims, 1, rootLevel], 68);
  words[79] = top.length;
  floats.set(circleAcrossLight(grid), 84);

  let anchorWorld: Vec3;
  let placement: WorldFromFile | undefined;
  const setLookUp = (next: GpuLookUpOptions): void => {
    const { bias = settings.bias, penumbra, placement: place } = next;
    const filter = next.filter ?? (penumbra === undefined ? LOOK_UP_DEFAULTS.filter : 1);
    checkFilter(filter);
    const terms = [bias.constantTexels, bias.slopeTexels, bias.normalOffsetTexels];
    for (const texels of terms) checkRange('a term of the bias in texels', texels, 0, 16);
    if (penumbra !== undefined) {
      if (filter !== 1) throw new RangeError(`penumbrae need a filter of width 1, but it is ${filter}`);
      checkRange("the sun's angular diameter in degrees", penumbra.sunDegrees, 0.01, 20);
      checkRange('the largest radius of a penumbra in texels', penumbra.maxRadiusTexels, 1, 64);
    }
    const placed = placedGrid(grid, place);
    placement = place;
    anchorWorld = middle(placedGrid(middleOf, place));
    writeGridParameters(parameters, placed, anchorWorld);
    header.floats.set(anchorWorld, 4);
    header.floats.set(placed.sun, 8);
    floats.set([...terms, 1], 72);
    words[80] = filter;
    floats[81] = penumbra === undefined ? 0 : coneTexelsPerVoxel(grid, penumbra.sunDegrees);
    floats[82] = penumbra?.maxRadiusTexels ?? 0;
  };
  setLookUp(options);
  return {
    words: header.words,
    parts: [top, code],
    count,
    get anchorWorld() {
      return anchorWorld;
    },
    get placement() {
      return placement;
    },
    setLookUp,
  };
}

/** Returns the number of a file's words. */
export function wordCount({ top, code }: LookedUpFile): number {
  return top.length + code.length;
}

function viewsOf(all: Uint32Array<ArrayBuffer>, from: number, count: number): WordViews {
  const words = all.subarray(from, from + count);
  return {
    words,
    ints: new Int32Array(words.buffer, words.byteOffset, count),
    floats: new Float32Array(words.buffer, words.byteOffset, count),
  };
}
