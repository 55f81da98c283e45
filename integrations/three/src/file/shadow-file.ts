// The `.adumbra` file: parses its bytes into the placement, the settings and the words of its voxels. The
// format is in `spec/adumbra-file.md`. Counterpart of `crates/adumbra/src/file/mod.rs` and `read.rs`.

import type { LightGrid } from '../grid/light-grid.js';
import type { Dims } from '../quadtree/pages.js';
import type { Quadtree } from '../quadtree/quadtree.js';
import type { FileSettings } from '../settings.js';
import { LEVEL_STEP, partsOf } from './directory.js';
import { trailing, truncated } from './faults.js';
import { parseEntries, parseTables } from './front.js';
import { parseHeader } from './header.js';
import { readLevel } from './level.js';
import { checkMemory } from './memory.js';
import { run, runInSlices } from './steps.js';
import type { Steps } from './steps.js';

/** How a file is checked when it is read. */
export interface ParseOptions {
  /**
   * `true`, the default: everything that the specification demands, so that only valid files are accepted.
   * `'header'`: header, directory and tables with their checksums, the length of the file and the places of
   * its parts. Use it for files that you trust: a file that is damaged elsewhere is refused or gives wrong
   * answers, but every look-up still ends.
   */
  readonly verify?: true | 'header';
  /**
   * The most bytes of memory that a file may take while it is parsed, including the file itself; no limit by
   * default. Set it for files from others: a file of a few megabytes is often five times as large in memory,
   * and a forged one can be 600 times as large. Header, directory and tables say how large a file can be, so
   * a file that is too large is refused before it is decoded.
   */
  readonly limitBytes?: number;
}

/** How a file is checked where options are left out. */
export const PARSE_DEFAULTS = { verify: true, limitBytes: Infinity } as const;

/**
 * The contents of a `.adumbra` file. Look-ups use its finest level of detail; {@link BakedShadowFile.level}
 * gives the others. It does not keep the bytes that it was made from.
 */
export class BakedShadowFile implements Quadtree {
  /** Version of the format. */
  declare readonly version: number;
  /** Placement of the voxels in the world, and the sun. */
  declare readonly grid: LightGrid;
  /** Settings of the bake. */
  declare readonly settings: FileSettings;
  /** The blocks at which look-ups begin span 2^rootLevel columns along each side; 5, 7 or 9. */
  declare readonly rootLevel: number;
  /** Number of these blocks along x and y. */
  declare readonly topDims: Dims;
  /** Two words per block, x fastest: the address of its node in the code, or 0xFFFFFFFF, and its base. */
  declare readonly top: Uint32Array;
  /** The code, two half-words per word: the common section, then the pages. */
  declare readonly code: Uint32Array;
  /** Length of the whole file, with all levels, bytes. */
  declare readonly byteLength: number;
  /** Levels of less detail, the finest first. */
  private declare readonly coarser: readonly BakedShadowFile[];

  /**
   * Parses and checks a whole file. Cost: one pass over the bytes, and memory for the words.
   *
   * @throws ShadowFileError if `bytes` are not exactly one valid file, or one that takes more memory than is allowed.
   */
  constructor(bytes: ArrayBufferLike | Uint8Array, options: ParseOptions = {}) {
    fill(this, run(readContents(bytes, options)));
  }

  /**
   * Parses and checks a whole file as the constructor does, in slices of about ten milliseconds, so that the
   * page stays responsive. The bytes must not change before the promise settles.
   *
   * @throws ShadowFileError if `bytes` are not exactly one valid file.
   * @throws the reason of `signal`, once it aborts.
   */
  static async parseAsync(bytes: ArrayBufferLike | Uint8Array, { signal, ...options }: ParseOptions & { readonly signal?: AbortSignal | undefined } = {}): Promise<BakedShadowFile> {
    return fill(Object.create(BakedShadowFile.prototype), await runInSlices(readContents(bytes, options), signal));
  }

  /** Number of levels of detail, at least 1. Each has voxels four times as large as those of the one before it. */
  get levelCount(): number {
    return 1 + this.coarser.length;
  }

  /**
   * Returns a level as a separate file, with the levels coarser than it; `undefined` if there is no such
   * level. Level 0 is the file itself, the finest.
   */
  level(level: number): BakedShadowFile | undefined {
    return level === 0 ? this : this.coarser[level - 1];
  }
}

/** The contents of a file and its coarser levels. */
interface Contents {
  readonly version: number;
  readonly byteLength: number;
  readonly settings: FileSettings;
  /** Placement of each level. */
  readonly grids: readonly LightGrid[];
  /** Voxels of each level. */
  readonly trees: readonly Quadtree[];
}

/** Reads and checks a whole file. */
function* readContents(bytes: ArrayBufferLike | Uint8Array, { verify = PARSE_DEFAULTS.verify, limitBytes = PARSE_DEFAULTS.limitBytes }: ParseOptions): Steps<Contents> {
  const whole = bytes instanceof Uint8Array ? bytes : new Uint8Array(bytes);
  const header = parseHeader(whole);
  const { version, settings, isCoded, fileBytes: byteLength } = header;
  const have = whole.length;
  const entries = parseEntries(whole, header);
  const cut = partsOf(entries).find(({ offset, length }) => offset + length > have);
  if (cut !== undefined) throw truncated(cut.name, cut.offset + cut.length, have);
  if (have > byteLength) throw trailing(byteLength);
  const tables = parseTables(whole, entries, isCoded);
  checkMemory(byteLength, entries, tables, limitBytes);
  const trees: Quadtree[] = [];
  for (const [level, entry] of entries.entries()) {
    trees.push(yield* readLevel(whole, level, entry, tables[level], isCoded, verify === true));
  }
  return { version, byteLength, settings, grids: entries.map(({ grid }) => grid), trees };
}

/** Gives a file its contents, and a file to each level that is coarser. */
function fill(finest: BakedShadowFile, { version, byteLength, settings, grids, trees }: Contents): BakedShadowFile {
  let coarser: readonly BakedShadowFile[] = [];
  for (let level = grids.length - 1; level >= 0; level--) {
    const file: BakedShadowFile = level === 0 ? finest : Object.create(BakedShadowFile.prototype);
    const resolution = Math.ceil(settings.resolution / LEVEL_STEP ** level);
    const contents = { version, grid: grids[level], settings: { ...settings, resolution }, ...trees[level], byteLength, coarser };
    coarser = [Object.freeze(Object.assign(file, contents)), ...coarser];
  }
  return finest;
}
