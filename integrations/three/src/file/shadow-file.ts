// The `.adumbra` file: parses its bytes into the placement, the settings and the words of its voxels. The format is in
// `spec/adumbra-file.md`. Counterpart of `crates/adumbra/src/file/read.rs`.

import type { LightGrid } from '../grid/light-grid.js';
import type { Vec3 } from '../grid/vec3.js';
import type { Quadtree } from '../quadtree/quadtree.js';
import { validate } from '../quadtree/validate.js';
import type { FileSettings } from '../settings.js';
import { parseHeader } from './header.js';
import { split } from './sections.js';

/** What is checked when a file is read. */
export interface ParseOptions {
  /**
   * `true`, the default: everything that the specification demands, so that no bytes but those of a valid file are taken.
   * `'header'`: the header with its checksum, the length of the file and the places of its sections. For files that you
   * trust: one that is damaged elsewhere gives wrong answers, but every look-up still ends.
   */
  readonly verify?: true | 'header';
}

/** The contents of a `.adumbra` file. Its words are views of the bytes that it was made from. */
export class BakedShadowFile implements Quadtree {
  /** Version of the format, 1 to 3. */
  declare readonly version: number;
  /** Placement of the voxels in the world, and the sun. */
  declare readonly grid: LightGrid;
  /** Settings of the bake. */
  declare readonly settings: FileSettings;
  /** A root spans 2^rootLevel columns along each side; 5, 7 or 9. */
  declare readonly rootLevel: number;
  /** Number of roots along x, y, z. Only x and y count. */
  declare readonly topDims: Vec3;
  /** The section `top`: two words per root, an address and a base. */
  declare readonly top: Uint32Array;
  /** The section `nodes`: the code, two half-words per word. */
  declare readonly nodes: Uint32Array;
  /** The section `leaf_masks`: two words per wide entry, a difference and an address. */
  declare readonly leafMasks: Uint32Array;
  /** Length of the file, bytes. */
  declare readonly byteLength: number;

  /**
   * Parses and checks a whole file. Cost: one pass over the bytes; half their size in memory while it checks.
   *
   * The file goes on using the buffer of `bytes`, which must not be changed. Bytes that are not at a multiple of 4 in
   * their buffer are copied.
   *
   * @throws ShadowFileError if `bytes` are not exactly one valid file.
   */
  constructor(bytes: ArrayBufferLike | Uint8Array, { verify = true }: ParseOptions = {}) {
    let whole = bytes instanceof Uint8Array ? bytes : new Uint8Array(bytes);
    if (whole.byteOffset % 4 !== 0) whole = new Uint8Array(whole);
    const { sections, fileBytes: byteLength, ...header } = parseHeader(whole);
    const [top, nodes, leafMasks] = split(whole, sections, verify === true);
    Object.freeze(Object.assign(this, header, { top, nodes, leafMasks, byteLength }));
    if (verify === true) validate(this);
  }
}
