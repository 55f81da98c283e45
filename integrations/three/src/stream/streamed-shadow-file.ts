// A shadow file of any size. A pool of limited size holds the parts that cameras need.

import { EventDispatcher } from 'three';
import type { Camera } from 'three';

import type { ShadowFileError } from '../error.js';
import { LEVEL_STEP } from '../file/directory.js';
import { HEADER_BYTES } from '../file/faults.js';
import type { GpuLookUpOptions } from '../gpu/look-up-header.js';
import type { LightGrid } from '../grid/light-grid.js';
import { asList } from '../light/options.js';
import type { StreamedFile, StreamedWords } from '../light/streamed.js';
import { warnOnce } from '../light/warn.js';
import { checkOption, checkRange, withDefaults } from '../settings.js';
import type { FileSettings, LookUpOptions } from '../settings.js';
import { bundlesOf } from './bundles.js';
import type { Bundle } from './bundles.js';
import { choose } from './choose.js';
import { Decoder } from './decoder.js';
import { Fetching } from './fetching.js';
import { poolHeaders } from './headers.js';
import { poolLayout } from './layout.js';
import { readFront, withUrl } from './opening.js';
import type { Front } from './opening.js';
import { Pool } from './pool.js';
import { Residency } from './residency.js';
import { StreamedSampler } from './sampler.js';
import { Source } from './source.js';
import type { FetchOptions } from './source.js';
import { viewOf } from './views.js';
import { PoolWords } from './words.js';

/** How a file is streamed. */
export interface StreamOptions {
  /** Bytes of the pool, 4 KiB to 256 MiB; 32 MiB by default. Each light with the file takes as many on the GPU. */
  readonly budgetBytes?: number;
  /** Largest number of pixels that a texel may cover before a finer level is fetched; 1 by default. */
  readonly detailPixels?: number;
  /** Ends the opening, and later the streaming, once it aborts. */
  readonly signal?: AbortSignal;
  /** Options of `fetch` besides the range, such as `credentials`. */
  readonly fetch?: FetchOptions;
  /** Seconds after which a request without an answer has failed; 30 by default. */
  readonly timeoutSeconds?: number;
  /**
   * The approximate limit of bytes that an update copies into the pool, and so to the GPU; 256 KiB by
   * default.
   */
  readonly uploadBytesPerFrame?: number;
  /**
   * Number of updates over which pages fade in and out, so that shadows do not jump; 0, the default, switches
   * them at once.
   */
  readonly fadeFrames?: number;
  /**
   * Whether a worker decodes, if one is available: true by default. Otherwise the page decodes, in slices of
   * ten milliseconds.
   */
  readonly worker?: boolean;
}

/** How a file is streamed where options are left out. */
export const STREAM_DEFAULTS = {
  budgetBytes: 32 * 1024 * 1024,
  detailPixels: 1,
  timeoutSeconds: 30,
  uploadBytesPerFrame: 256 * 1024,
  fadeFrames: 0,
  worker: true,
} as const;

/** All options of a stream. */
type Settled = Required<Omit<StreamOptions, 'signal' | 'fetch'>> & Pick<StreamOptions, 'signal' | 'fetch'>;

/** The events of a {@link StreamedShadowFile}. */
export interface StreamEvents {
  /**
   * Bundles have arrived. The next {@link StreamedShadowFile.update} uses them, so a page that draws on
   * demand should draw.
   */
  arrived: object;
  /**
   * Parts could not be fetched, or are damaged. A coarser level is shown there, and they are requested again
   * later.
   */
  error: { readonly error: ShadowFileError; readonly parts: readonly string[] };
  /**
   * The file on the server has changed since it was opened. Nothing more is fetched, and resident parts stay.
   */
  changed: { readonly error: ShadowFileError };
}

/** A level in use. */
export interface LevelStats {
  /** Its number in the file, 0 for the finest. */
  readonly level: number;
  /** Edge of a texel, world units. */
  readonly texel: number;
  /** Number of its bundles, which are squares of 2048 × 2048 texels. */
  readonly bundles: number;
  /** How many of them are resident. */
  readonly resident: number;
}

/** Statistics of fetched and resident data. */
export interface StreamStats {
  /** Number of requests so far. */
  readonly requests: number;
  /** Number of requests that are under way. */
  readonly underWay: number;
  /** Bytes that have arrived so far. */
  readonly fetchedBytes: number;
  /** Bytes of the pool. */
  readonly poolBytes: number;
  /** Bytes of the pool that are in use. */
  readonly usedBytes: number;
  /** Number of bundles that the last update chose. */
  readonly chosen: number;
  /** How many of these are not resident. */
  readonly missing: number;
  /** Number of bundles that fade. As long as there are any, a page that draws on demand should go on. */
  readonly fading: number;
  /** The levels in use, the finest first. */
  readonly levels: readonly LevelStats[];
}

/**
 * A `.adumbra` file on a server with range requests. Lights take it as they take a whole file. The coarsest
 * level is resident from the beginning. {@link StreamedShadowFile.update}, called before each frame, fetches
 * the parts of finer levels that cameras need.
 */
export class StreamedShadowFile extends EventDispatcher<StreamEvents> implements StreamedFile {
  /** Where the file is. */
  readonly url: string;
  /** Length of the whole file, bytes. */
  readonly byteLength: number;
  /** Placement of the finest level that the budget allows. */
  readonly grid: LightGrid;
  /** Settings of the bake, of that level. */
  readonly settings: FileSettings;
  readonly #source: Source;
  readonly #decoder: Decoder;
  readonly #pool: Pool;
  /** Placement of the levels in use, the finest first. */
  readonly #grids: readonly LightGrid[];
  /** Their bundles. */
  readonly #levels: readonly (readonly Bundle[])[];
  readonly #residency: Residency;
  readonly #fetching: Fetching;
  readonly #detail: number;
  readonly #wordsPerUpdate: number;
  readonly #signal: AbortSignal | undefined;
  readonly #onAbort = (): void => this.dispose();
  /** The words of the lights with this file. */
  readonly #lights = new Set<PoolWords>();
  #chosen: readonly Bundle[] = [];
  /** Number of the last choice. */
  #choice = 0;
  #isDisposed = false;

  /**
   * Opens the file at `url` with two requests. After that every point has an answer.
   *
   * @throws ShadowFileError if the file cannot be fetched, is not valid, or has a coarsest level that does not fit the budget.
   * @throws RangeError if an option is out of its range.
   * @throws the reason of `signal`, once it aborts.
   */
  static async open(url: string | URL, options: StreamOptions = {}): Promise<StreamedShadowFile> {
    const all: Settled = withDefaults(STREAM_DEFAULTS, options);
    checkOptions(all);
    const { signal, budgetBytes, fadeFrames, worker, timeoutSeconds, fetch = {} } = all;
    signal?.throwIfAborted();
    const source = new Source(String(url), fetch, 1000 * timeoutSeconds);
    const decoder = new Decoder(worker);
    const abort = (): void => {
      source.abort();
      decoder.dispose();
    };
    signal?.addEventListener('abort', abort);
    try {
      const front = await readFront(source);
      const pool = new Pool(poolLayout(budgetBytes, front.entries, front.tables, fadeFrames > 1));
      const file = new StreamedShadowFile(source, decoder, pool, front, all);
      await file.#settleCoarsest(front);
      signal?.throwIfAborted();
      signal?.addEventListener('abort', file.#onAbort);
      return file;
    } catch (error) {
      abort();
      signal?.throwIfAborted();
      throw withUrl(error, source.url);
    } finally {
      signal?.removeEventListener('abort', abort);
    }
  }

  private constructor(source: Source, decoder: Decoder, pool: Pool, { header, entries, tables, bytes }: Front, options: Settled) {
    super();
    const { layout } = pool;
    this.#source = source;
    this.#decoder = decoder;
    this.#pool = pool;
    this.#grids = layout.levels.map(({ level }) => entries[level]!.grid);
    this.#levels = layout.levels.map((place, rank) => bundlesOf(rank, place, entries, tables[place.level]!));
    this.#residency = new Residency(pool, this.#levels, options.fadeFrames);
    this.#detail = options.detailPixels;
    this.#wordsPerUpdate = options.uploadBytesPerFrame / 4;
    this.#signal = options.signal;
    this.url = source.url;
    this.byteLength = header.fileBytes;
    this.grid = this.#grids[0]!;
    this.settings = { ...header.settings, resolution: Math.ceil(header.settings.resolution / LEVEL_STEP ** layout.levels[0]!.level) };
    const fetched = { source, decoder, header: bytes.slice(0, HEADER_BYTES), isCoded: header.isCoded, entries, layout, levels: this.#levels };
    this.#fetching = new Fetching(fetched, {
      onCommon: (rank, words) => pool.setCommon(layout.levels[rank]!, words),
      onBundle: (bundle, words) => {
        this.#residency.arrive(bundle, words);
        this.dispatchEvent({ type: 'arrived' });
      },
      onError: (error, parts) => {
        warnOnce(`${error.message}; a coarser level is shown`, `stream ${this.url}`);
        this.dispatchEvent({ type: 'error', error, parts });
      },
      onChanged: (error) => {
        warnOnce(error.message, `stream ${this.url}`);
        this.dispatchEvent({ type: 'changed', error });
      },
    });
  }

  /** Statistics of fetched and resident data. */
  get stats(): StreamStats {
    const { words, pageWords, layout } = this.#pool;
    const isResident = ({ state }: Bundle): boolean => state === 'resident';
    return {
      requests: this.#source.requests,
      underWay: this.#fetching.underWay,
      fetchedBytes: this.#source.bytes,
      poolBytes: words.byteLength,
      usedBytes: words.byteLength - 4 * pageWords.free,
      chosen: this.#chosen.length,
      missing: this.#chosen.filter((bundle) => !isResident(bundle)).length,
      fading: this.#residency.fading,
      levels: this.#levels.map((bundles, rank) => ({
        level: layout.levels[rank]!.level,
        texel: this.#grids[rank]!.voxelSize,
        bundles: bundles.length,
        resident: bundles.filter(isResident).length,
      })),
    };
  }

  /**
   * Chooses the bundles that cameras need, copies arrived ones into the pool, and requests more. Call it
   * before each frame, outside of the renderer's own work. Cost: a pass over the bundles of the file, and the
   * copies.
   *
   * @param cameras One camera, or all that see the world in this frame. Of a camera array, name its cameras.
   * @param rows Rows of pixels of the picture; those of the page's window by default.
   */
  update(cameras: Camera | readonly Camera[], rows: number = windowRows()): void {
    if (this.#isDisposed) return;
    const { all } = this.#pool.pageWords;
    const coarsest = this.#levels.at(-1)!.reduce((sum, { words }) => sum + words, 0);
    /** The share of the words for pages that the chosen bundles may take. */
    const CHOSEN_SHARE = 0.9;
    this.#choice += 1;
    const placements = this.#lights.size === 0 ? [undefined] : [...this.#lights].map(({ lookUps }) => lookUps[0]!.placement);
    const views = placements.flatMap((placement) => asList(cameras, 'cameras').map((camera) => viewOf(camera, rows, placement)));
    this.#chosen = choose(this.#residency.comers, views, {
      coarserTexel: ({ rank }) => this.#grids[rank + 1]!.voxelSize,
      detail: this.#detail,
      words: CHOSEN_SHARE * all - coarsest,
    });
    for (const bundle of this.#chosen) bundle.chosenAt = this.#choice;
    this.#residency.bringIn(this.#wordsPerUpdate, this.#choice);
    this.#fetching.request(this.#chosen, ({ chosenAt, blockedAt }) => chosenAt === this.#choice && blockedAt !== this.#pool.givenUp);
    for (const light of this.#lights) light.upload();
  }

  /** Lets the next update request failed parts again, without waiting any longer. */
  retry(): void {
    this.#fetching.retry();
  }

  /**
   * Returns look-ups on the CPU in the resident parts.
   *
   * @throws RangeError if the width of the filter is not 1, 3, 5, 9 or 17.
   */
  sampler(options: LookUpOptions = {}): StreamedSampler {
    return new StreamedSampler({ pool: this.#pool, grids: this.#grids, bias: this.settings.bias }, options);
  }

  /** For lights: a texture that follows the pool. */
  openWords(options: GpuLookUpOptions, maxSide: number): StreamedWords {
    const headers = poolHeaders(this.#pool.layout, this.#grids, this.settings, options);
    const words = new PoolWords(this.#pool, headers, maxSide, () => this.#lights.delete(words));
    this.#lights.add(words);
    return words;
  }

  /** Ends requests and the worker. Lights go on with the resident parts. */
  dispose(): void {
    this.#isDisposed = true;
    this.#signal?.removeEventListener('abort', this.#onAbort);
    this.#fetching.end();
    this.#source.abort();
    this.#decoder.dispose();
  }

  /** Takes the coarsest level in, which is part of the beginning of the file. */
  async #settleCoarsest({ header: { isCoded }, entries, bytes }: Front): Promise<void> {
    const place = this.#pool.layout.levels.at(-1)!;
    const { level } = place;
    const { common, commonRawBytes: rawBytes } = entries[level]!;
    const part = (offset: number, length: number): Uint8Array => bytes.slice(offset, offset + length);
    const { name, checksum } = common;
    const stored = part(common.offset, common.length);
    this.#pool.setCommon(place, await this.#decoder.decode({ kind: 'common', level, isCoded, stored, name, checksum, rawBytes }));
    for (const bundle of this.#levels.at(-1)!) {
      const { entry, offset, state } = bundle;
      if (state === 'resident') continue;
      this.#residency.settle(bundle, await this.#decoder.decode({ kind: 'bundle', level, stored: part(offset, entry.storedBytes), entry }));
    }
  }
}

/** Rows of pixels of the page's window, or of a common screen if there is no window. */
function windowRows(): number {
  const { innerHeight = 1080, devicePixelRatio = 1 } = globalThis as { innerHeight?: number; devicePixelRatio?: number };
  return innerHeight * devicePixelRatio;
}

function checkOptions(all: Settled): void {
  checkRange('budgetBytes', all.budgetBytes, 4096, 256 * 1024 * 1024);
  for (const name of ['detailPixels', 'timeoutSeconds', 'uploadBytesPerFrame'] as const) checkOption(all[name] > 0, name, all[name], 'above 0');
  checkOption(all.fadeFrames >>> 0 === all.fadeFrames, 'fadeFrames', all.fadeFrames, 'whole, 0 or more');
}
