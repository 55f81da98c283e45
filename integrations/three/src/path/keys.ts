// The keys of a path that are in memory: wanted keys are loaded, and keys that are no longer wanted are
// dropped.

import { ShadowFileError } from '../error.js';
import { BakedShadowFile } from '../file/shadow-file.js';
import { wordCount } from '../gpu/look-up-header.js';
import { withUrl } from '../stream/opening.js';
import { putOff, putOffNoMore } from '../stream/retry.js';
import type { Waiting } from '../stream/retry.js';
import type { Source } from '../stream/source.js';
import type { KeyPlace } from './front.js';

/** The most keys in memory. */
const MAX_RESIDENT = 3;
/** The most keys that are being loaded at a time. */
const MAX_LOADS = 2;
/** The most bytes of a request. */
const REQUEST_BYTES = 2 ** 20;

/** Callbacks for keys that arrive, and for keys that fail. */
export interface KeyListener {
  onKey(): void;
  onError(key: number, error: ShadowFileError): void;
}

/** The keys of a path. */
export class Keys {
  /** The listener to loaded and failed keys. */
  listener: KeyListener | undefined;
  readonly #source: Source;
  readonly #places: readonly KeyPlace[];
  readonly #over = new AbortController();
  readonly #resident = new Map<number, BakedShadowFile>();
  readonly #loads = new Map<number, Promise<BakedShadowFile>>();
  /** The keys that have failed. */
  readonly #failed = new Map<number, Waiting>();
  /** The keys that are wanted, the most urgent first. */
  #wanted: readonly number[] = [];
  #revision = 0;

  /** Loads from a source. */
  constructor(source: Source, places: readonly KeyPlace[]) {
    this.#source = source;
    this.#places = places;
  }

  /** The keys in memory, by number. */
  get resident(): ReadonlyMap<number, BakedShadowFile> {
    return this.#resident;
  }

  /** The numbers of the keys that are being loaded. */
  get loading(): readonly number[] {
    return [...this.#loads.keys()];
  }

  /** Changes when keys are added or dropped. */
  get revision(): number {
    return this.#revision;
  }

  /** Sets the wanted keys, at most three, the most urgent first. Keys that are not in memory are loaded. */
  want(wanted: readonly number[]): void {
    this.#wanted = wanted;
    const now = performance.now();
    for (const key of wanted) {
      if (this.#over.signal.aborted || this.#loads.size >= MAX_LOADS) return;
      if (this.#resident.has(key) || this.#loads.has(key) || (this.#failed.get(key)?.notBefore ?? now) > now) continue;
      this.#start(key).catch(() => {});
    }
  }

  /**
   * Loads a key, at once.
   *
   * @throws ShadowFileError if it cannot be fetched or is not valid.
   */
  load(key: number): Promise<BakedShadowFile> {
    const resident = this.#resident.get(key);
    if (resident !== undefined) return Promise.resolve(resident);
    return this.#loads.get(key) ?? this.#start(key);
  }

  /** Lets keys that failed be loaded again at once. */
  retry(): void {
    for (const waiting of this.#failed.values()) putOffNoMore(waiting);
  }

  /** Loads nothing more. */
  end(): void {
    this.#over.abort();
  }

  /** Begins to load a key, and reports the result to the listener. */
  #start(key: number): Promise<BakedShadowFile> {
    const load = this.#load(key);
    this.#loads.set(key, load);
    load.then(
      () => this.listener?.onKey(),
      (error: unknown) => {
        if (error instanceof ShadowFileError) this.listener?.onError(key, error);
      },
    );
    return load;
  }

  async #load(key: number): Promise<BakedShadowFile> {
    try {
      const place = this.#places[key]!;
      const file = await BakedShadowFile.parseAsync(await this.#read(place), { signal: this.#over.signal });
      const words = wordCount(file);
      if (words !== place.words) {
        const message = `words of key ${key} is ${place.words}, but its file has ${words}; bake the path again`;
        throw new ShadowFileError('HeaderField', message, { key, words });
      }
      this.#failed.delete(key);
      this.#resident.set(key, file);
      this.#dropFrom(key);
      this.#revision += 1;
      return file;
    } catch (error) {
      throw this.#over.signal.aborted ? error : this.#fail(key, error);
    } finally {
      this.#loads.delete(key);
      this.want(this.#wanted);
    }
  }

  /** Reads the bytes of a key. */
  async #read({ offset, bytes }: KeyPlace): Promise<Uint8Array> {
    const all = new Uint8Array(bytes);
    for (let at = 0; at < bytes; at += REQUEST_BYTES) {
      this.#over.signal.throwIfAborted();
      all.set(await this.#source.read(offset + at, Math.min(REQUEST_BYTES, bytes - at)), at);
    }
    return all;
  }

  /**
   * Drops unwanted keys until few are left: first the keys farthest in number from the one that has arrived.
   */
  #dropFrom(come: number): void {
    const far = [...this.#resident.keys()].filter((key) => !this.#wanted.includes(key)).sort((a, b) => Math.abs(b - come) - Math.abs(a - come));
    for (const key of far.slice(0, Math.max(this.#resident.size - MAX_RESIDENT, 0))) this.#resident.delete(key);
  }

  /** Notes that a key has failed. Returns the error with the address of the file. */
  #fail(key: number, error: unknown): unknown {
    const waiting = this.#failed.get(key) ?? { failures: 0, notBefore: -Infinity };
    putOff(waiting, performance.now());
    this.#failed.set(key, waiting);
    const { message } = error as Error;
    const known = error instanceof ShadowFileError ? error : new ShadowFileError('Io', `key ${key} cannot be read: ${message}; bake the path again`, { key }, { cause: error });
    // If the file has changed, its keys do not fit the front that was read.
    if (known.kind === 'Changed') this.end();
    return withUrl(known, this.#source.url);
  }
}
