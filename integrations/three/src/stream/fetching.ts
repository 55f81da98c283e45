// Fetches the chosen common sections and bundles, a few requests at a time. Parts that fail are requested
// again after a delay.

import { ShadowFileError } from '../error.js';
import type { GridEntry } from '../file/directory.js';
import type { Bundle } from './bundles.js';
import type { Decoder } from './decoder.js';
import type { PoolLayout } from './layout.js';
import { isSameHeader, withUrl } from './opening.js';
import { MAX_REQUESTS, runAround } from './requests.js';
import { putOff, putOffNoMore } from './retry.js';
import type { Waiting } from './retry.js';
import { changed } from './source.js';
import type { Source } from './source.js';

/** The most words that are requested, or are being decoded, at a time: 8 MiB. */
const MAX_PENDING_WORDS = 2 ** 21;

/** The common section of a level. */
interface Common extends Waiting {
  state: 'absent' | 'requested' | 'there';
}

/** Callbacks for parts that arrive, and for parts that fail. */
export interface FetchListener {
  /** A common section has arrived. */
  onCommon(rank: number, words: Uint32Array): void;
  /** A bundle has arrived. */
  onBundle(bundle: Bundle, words: Uint32Array): void;
  /** Parts with these names have failed. */
  onError(error: ShadowFileError, parts: readonly string[]): void;
  /** The file has changed. */
  onChanged(error: ShadowFileError): void;
}

/** The file that parts are fetched from. */
export interface FetchedFile {
  readonly source: Source;
  readonly decoder: Decoder;
  /** The first bytes of the file. */
  readonly header: Uint8Array;
  readonly isCoded: boolean;
  readonly entries: readonly GridEntry[];
  readonly layout: PoolLayout;
  /** The bundles of each level in use, the finest first. */
  readonly levels: readonly (readonly Bundle[])[];
}

/** Fetches parts of a file. */
export class Fetching {
  readonly #file: FetchedFile;
  readonly #listener: FetchListener;
  readonly #commons: readonly Common[];
  #underWay = 0;
  #pendingWords = 0;
  #isOver = false;

  /** Begins with the common section of the coarsest level already loaded. */
  constructor(file: FetchedFile, listener: FetchListener) {
    this.#file = file;
    this.#listener = listener;
    const coarsest = file.levels.length - 1;
    this.#commons = file.levels.map((_, rank) => ({ state: rank === coarsest ? 'there' : 'absent', failures: 0, notBefore: -Infinity }));
  }

  /** Number of requests that are under way. */
  get underWay(): number {
    return this.#underWay;
  }

  /** Requests the bundles that `isWanted` does not refuse, in order, as far as requests are free. */
  request(chosen: readonly Bundle[], isWanted: (bundle: Bundle) => boolean): void {
    const now = performance.now();
    const isDue = (bundle: Bundle): boolean => bundle.state === 'absent' && bundle.notBefore <= now && isWanted(bundle);
    for (const bundle of chosen) {
      if (this.#isOver || this.#underWay >= MAX_REQUESTS || this.#pendingWords > MAX_PENDING_WORDS) return;
      if (!isDue(bundle)) continue;
      const common = this.#commons[bundle.rank]!;
      if (common.state === 'there') void this.#fetchRun(runAround(bundle, this.#file.levels[bundle.rank]!, isDue));
      else if (common.state === 'absent' && common.notBefore <= now) void this.#fetchCommon(bundle.rank, common);
    }
  }

  /** Lets failed parts be requested again at once. */
  retry(): void {
    for (const each of [...this.#commons, ...this.#file.levels.flat()]) putOffNoMore(each);
  }

  /** Stops requesting. */
  end(): void {
    this.#isOver = true;
  }

  async #fetchCommon(rank: number, common: Common): Promise<void> {
    const { layout, entries, isCoded, decoder } = this.#file;
    const { level } = layout.levels[rank]!;
    const { common: { name, offset, length, checksum }, commonRawBytes: rawBytes } = entries[level]!;
    common.state = 'requested';
    try {
      const stored = length === 0 ? new Uint8Array() : await this.#read(offset, length);
      const words = await decoder.decode({ kind: 'common', level, isCoded, stored, name, checksum, rawBytes });
      putOffNoMore(common);
      common.state = 'there';
      this.#listener.onCommon(rank, words);
    } catch (error) {
      common.state = 'absent';
      await this.#fail(error, [common], [name]);
    }
  }

  async #fetchRun(run: readonly Bundle[]): Promise<void> {
    const pending = run.reduce((sum, { entry }) => sum + entry.pageWords, 0);
    this.#pendingWords += pending;
    for (const bundle of run) bundle.state = 'requested';
    try {
      const { offset } = run[0]!;
      const last = run.at(-1)!;
      const bytes = await this.#read(offset, last.offset + last.entry.storedBytes - offset);
      await Promise.all(run.map((bundle) => this.#decode(bundle, bytes.subarray(bundle.offset - offset))));
    } catch (error) {
      for (const bundle of run) bundle.state = 'absent';
      await this.#fail(error, run, run.map(({ entry }) => entry.name));
    } finally {
      this.#pendingWords -= pending;
    }
  }

  async #decode(bundle: Bundle, from: Uint8Array): Promise<void> {
    const { layout, decoder } = this.#file;
    const { entry, rank } = bundle;
    try {
      // Copy the part, because a worker would get the whole buffer.
      const stored = new Uint8Array(from.subarray(0, entry.storedBytes));
      const words = await decoder.decode({ kind: 'bundle', level: layout.levels[rank]!.level, stored, entry });
      putOffNoMore(bundle);
      this.#listener.onBundle(bundle, words);
    } catch (error) {
      bundle.state = 'absent';
      await this.#fail(error, [bundle], [entry.name]);
    }
  }

  async #read(offset: number, length: number): Promise<Uint8Array> {
    this.#underWay += 1;
    try {
      return await this.#file.source.read(offset, length);
    } finally {
      this.#underWay -= 1;
    }
  }

  /** Delays the next request of failed parts and reports the error. Does nothing once fetching has ended. */
  async #fail(error: unknown, what: readonly Waiting[], parts: readonly string[]): Promise<void> {
    if (this.#isOver) return;
    if (!(error instanceof ShadowFileError)) throw error;
    for (const each of what) putOff(each, performance.now());
    const { source, header } = this.#file;
    const isOther = error.kind === 'Changed' || (error.kind !== 'Io' && (await this.#hasOtherHeader(source, header)));
    if (this.#isOver) return;
    if (!isOther) {
      this.#listener.onError(withUrl(error, source.url) as ShadowFileError, parts);
      return;
    }
    this.#isOver = true;
    this.#listener.onChanged(error.kind === 'Changed' ? error : changed(source.url, 'its header is another', {}));
  }

  /** Whether the file was replaced, which would explain the damage. */
  async #hasOtherHeader(source: Source, header: Uint8Array): Promise<boolean> {
    try {
      return !(await isSameHeader(source, header));
    } catch (error) {
      return error instanceof ShadowFileError && error.kind === 'Changed';
    }
  }
}
