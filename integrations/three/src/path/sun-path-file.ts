// A sun path on a server: a few keys of it are in memory, and answer for the sun of a moment.

import { EventDispatcher } from 'three';

import type { ShadowFileError } from '../error.js';
import type { BakedShadowFile } from '../file/shadow-file.js';
import { wordCount } from '../gpu/look-up-header.js';
import type { GpuLookUpOptions } from '../gpu/look-up-header.js';
import type { LightGrid } from '../grid/light-grid.js';
import type { Vec3 } from '../grid/vec3.js';
import type { StreamedFile, StreamedWords } from '../light/streamed.js';
import { warnOnce } from '../light/warn.js';
import { checkOption, withDefaults } from '../settings.js';
import type { FileSettings, LookUpOptions } from '../settings.js';
import { withUrl } from '../stream/opening.js';
import { Source } from '../stream/source.js';
import type { FetchOptions } from '../stream/source.js';
import { answeringAt } from './answering.js';
import type { Answering } from './answering.js';
import { STEP_NUMBERS } from './front.js';
import type { PathFront } from './front.js';
import { Keys } from './keys.js';
import { sunPath } from './look-up.js';
import { readPathFront } from './opening.js';
import { PathSampler } from './sampler.js';
import { keysAt, sunAt, wantedAt } from './sun.js';
import { PathWords } from './words.js';

/** How a sun path is loaded. */
export interface SunPathOptions {
  /** The moment to begin with, seconds; that of the first key by default. */
  readonly seconds?: number;
  /** Ends the opening, and later the loading of keys, once it aborts. */
  readonly signal?: AbortSignal;
  /** Options of `fetch` besides the range, such as `credentials`. */
  readonly fetch?: FetchOptions;
  /** Seconds after which a request without an answer has failed; 30 by default. */
  readonly timeoutSeconds?: number;
}

/** How a sun path is loaded where options are left out. */
export const SUN_PATH_DEFAULTS = { timeoutSeconds: 30 } as const;

/** The events of a {@link SunPathFile}. */
export interface SunPathEvents {
  /**
   * A key has arrived. The next {@link SunPathFile.update} uses it, so a page that draws on demand should
   * draw.
   */
  arrived: object;
  /**
   * A key could not be fetched, or is damaged. Other keys stand in for it, and it is requested again later.
   */
  error: { readonly error: ShadowFileError; readonly key: number };
  /**
   * The file on the server has changed since it was opened. Nothing more is loaded, and keys in memory stay.
   */
  changed: { readonly error: ShadowFileError };
}

/** Statistics of fetched and resident data. */
export interface SunPathStats {
  /** Number of requests so far. */
  readonly requests: number;
  /** Bytes that have arrived so far. */
  readonly fetchedBytes: number;
  /** The numbers of the keys in memory, at most three. */
  readonly resident: readonly number[];
  /** The numbers of the keys that are being loaded. */
  readonly loading: readonly number[];
  /** Bytes of the words of the keys in memory. */
  readonly residentBytes: number;
  /** The numbers of the keys that answer, in the order in which they are looked up; none at night. */
  readonly answering: readonly number[];
  /**
   * Whether these are the keys of the moment. Otherwise not all of those are in memory, and others stand in
   * for them.
   */
  readonly isExact: boolean;
}

/**
 * A `day.adumbra` file: the suns of a day, and shadows for every moment of it. Lights take it as they take a
 * shadow file. At least one key is in memory from the beginning. {@link SunPathFile.update}, called before
 * each frame, loads the keys of the moment, and the next key.
 */
export class SunPathFile extends EventDispatcher<SunPathEvents> implements StreamedFile {
  /** Where the file is. */
  readonly url: string;
  /** Length of the whole file, bytes. */
  readonly byteLength: number;
  /** Latitude and longitude in degrees, north and east positive; `null` if the path has no place. */
  readonly placeDegrees: readonly [latitude: number, longitude: number] | null;
  /** How far the local clock is ahead of UTC, seconds. */
  readonly utcOffsetSeconds: number;
  /**
   * The first and the last moment with a sun that the path knows: seconds since 1970-01-01 00:00 UTC, or
   * since any moment if the path has no place.
   */
  readonly spanSeconds: readonly [first: number, last: number];
  /** The moments of the keys, seconds. */
  readonly keySeconds: readonly number[];
  /** Settings of the bake, from the first key that was loaded. */
  readonly settings: FileSettings;
  /** For lights: the shader text. */
  readonly lookUp = sunPath;
  readonly #front: PathFront;
  readonly #source: Source;
  readonly #keys: Keys;
  /** The words of the lights with this file. */
  readonly #lights = new Set<PathWords>();
  readonly #signal: AbortSignal | undefined;
  readonly #onAbort = (): void => this.dispose();
  #seconds: number;
  /** Whether time goes forward, rather than back. */
  #isForward = true;
  #answering: Answering | undefined;
  /** The revision of the keys at the last update. */
  #revision = -1;
  /** The grid of the key that is looked up first, with the sun of the moment; at night with the last sun. */
  #grid: LightGrid;

  /**
   * Opens the file at `url`, and loads a key of the moment. After that every moment has an answer.
   *
   * @throws ShadowFileError if the file cannot be fetched or is not valid.
   * @throws RangeError if an option is out of its range.
   * @throws the reason of `signal`, once it aborts.
   */
  static async open(url: string | URL, options: SunPathOptions = {}): Promise<SunPathFile> {
    const { signal, fetch = {}, timeoutSeconds } = withDefaults(SUN_PATH_DEFAULTS, options);
    checkOption(timeoutSeconds > 0, 'timeoutSeconds', timeoutSeconds, 'above 0');
    signal?.throwIfAborted();
    const source = new Source(String(url), fetch, 1000 * timeoutSeconds);
    let keys: Keys | undefined;
    const abort = (): void => {
      source.abort();
      keys?.end();
    };
    signal?.addEventListener('abort', abort);
    try {
      const front = await readPathFront(source);
      const seconds = options.seconds ?? front.keys[0]!.seconds;
      checkSeconds(seconds);
      keys = new Keys(source, front.keys);
      const first = await keys.load(wantedAt(front, seconds, true)[0]!);
      signal?.throwIfAborted();
      return new SunPathFile(source, front, keys, first, seconds, signal);
    } catch (error) {
      abort();
      signal?.throwIfAborted();
      throw withUrl(error, source.url);
    } finally {
      signal?.removeEventListener('abort', abort);
    }
  }

  private constructor(source: Source, front: PathFront, keys: Keys, first: BakedShadowFile, seconds: number, signal: AbortSignal | undefined) {
    super();
    const { steps } = front;
    this.#source = source;
    this.#front = front;
    this.#keys = keys;
    this.#signal = signal;
    this.#seconds = seconds;
    this.#grid = first.grid;
    this.url = source.url;
    this.byteLength = front.fileBytes;
    this.placeDegrees = front.placeDegrees;
    this.utcOffsetSeconds = front.utcOffsetSeconds;
    this.spanSeconds = [steps[0]!, steps[steps.length - STEP_NUMBERS]!];
    this.keySeconds = front.keys.map((key) => key.seconds);
    this.settings = first.settings;
    keys.listener = {
      onKey: () => this.dispatchEvent({ type: 'arrived' }),
      onError: (key, error) => {
        warnOnce(`${error.message}; another key is shown until it comes`, `path ${this.url}`);
        this.dispatchEvent(error.kind === 'Changed' ? { type: 'changed', error } : { type: 'error', error, key });
      },
    };
    signal?.addEventListener('abort', this.#onAbort);
    this.update(seconds);
  }

  /** The moment of the last update, seconds. */
  get seconds(): number {
    return this.#seconds;
  }

  /**
   * For lights: placement of the key that is looked up first, with the sun of the moment; at night with the
   * last sun.
   */
  get grid(): LightGrid {
    return this.#grid;
  }

  /** Statistics of fetched and resident data. */
  get stats(): SunPathStats {
    const { resident, loading } = this.#keys;
    const bytesOf = (file: BakedShadowFile): number => Array.from({ length: file.levelCount }, (_, level) => 4 * wordCount(file.level(level)!)).reduce((a, b) => a + b);
    return {
      requests: this.#source.requests,
      fetchedBytes: this.#source.bytes,
      resident: [...resident.keys()].sort((a, b) => a - b),
      loading,
      residentBytes: [...resident.values()].reduce((sum, file) => sum + bytesOf(file), 0),
      answering: (this.#answering?.parts ?? []).map((part) => part.key),
      isExact: this.#answering?.isExact ?? true,
    };
  }

  /**
   * Returns the unit vector towards the sun at a moment, world space. `undefined` at night, and where the
   * path has no sun: before its first moment and after its last.
   */
  sunAt(seconds: number): Vec3 | undefined {
    return sunAt(this.#front, seconds);
  }

  /**
   * Goes to a moment: uses the keys that have arrived, and loads missing keys and the next key in the
   * direction of time. Call it before each frame, outside of the renderer's own work.
   *
   * @throws RangeError if `seconds` is not finite.
   */
  update(seconds: number): void {
    checkSeconds(seconds);
    if (seconds !== this.#seconds) this.#isForward = seconds > this.#seconds;
    this.#keys.want(wantedAt(this.#front, seconds, this.#isForward));
    if (seconds === this.#seconds && this.#keys.revision === this.#revision) return;
    this.#seconds = seconds;
    this.#revision = this.#keys.revision;
    this.#answering = answeringAt(this.#front, this.#keys.resident, seconds);
    if (this.#answering !== undefined) this.#grid = { ...this.#answering.parts[0].file.grid, sun: this.#answering.towardsSun };
    for (const light of this.#lights) light.show(this.#answering);
  }

  /**
   * Goes to a moment, and waits for its keys.
   *
   * @throws ShadowFileError if one cannot be fetched or is not valid.
   * @throws RangeError if `seconds` is not finite.
   */
  async load(seconds: number): Promise<void> {
    this.update(seconds);
    await Promise.all((keysAt(this.#front, seconds) ?? []).map((key) => this.#keys.load(key)));
    if (this.#seconds === seconds) this.update(seconds);
  }

  /** Lets the next update load failed keys again, without waiting any longer. */
  retry(): void {
    this.#keys.retry();
  }

  /**
   * Returns look-ups on the CPU for a moment, by default that of the last update, in the keys that are in
   * memory now. They equal those of the Rust crate bit for bit if all keys of the moment are in memory.
   *
   * @throws RangeError if the width of the filter is not 1, 3, 5, 9 or 17.
   */
  sampler(options: LookUpOptions = {}, seconds: number = this.#seconds): PathSampler {
    return new PathSampler(answeringAt(this.#front, this.#keys.resident, seconds), options);
  }

  /** For lights: a texture that follows the moment. */
  openWords(options: GpuLookUpOptions, maxSide: number): StreamedWords {
    const slotWords = Math.max(...this.#front.keys.map((key) => key.words));
    const words = new PathWords(this.#answering, slotWords, options, maxSide, () => this.#lights.delete(words));
    this.#lights.add(words);
    return words;
  }

  /** Ends requests. Lights go on with the keys in memory. */
  dispose(): void {
    this.#signal?.removeEventListener('abort', this.#onAbort);
    this.#keys.end();
    this.#source.abort();
  }
}

function checkSeconds(seconds: number): void {
  if (!Number.isFinite(seconds)) throw new RangeError(`the moment is ${seconds} seconds, but must be finite`);
}
