// Decodes parts in a worker; without a worker, in slices on the page.

import { ShadowFileError } from '../error.js';
import { runInSlices } from '../file/steps.js';
import { Decoding } from './decode.js';
import type { DecodeJob } from './decode.js';

/** A request to the worker. */
export interface DecodeRequest {
  readonly id: number;
  readonly job: DecodeJob;
}

/** The worker's answer: words, or the parts of an error. */
export interface DecodeAnswer {
  readonly id: number;
  readonly words?: Uint32Array;
  readonly error?: Pick<ShadowFileError, 'kind' | 'message' | 'details' | 'fault'>;
}

/** A job that is not done. */
interface Pending {
  readonly job: DecodeJob;
  resolve(words: Uint32Array): void;
  reject(error: unknown): void;
}

/** Decodes parts in the order in which they are given. */
export class Decoder {
  readonly #pending = new Map<number, Pending>();
  /** Common sections, which a page that takes over from a worker needs. */
  readonly #commons: DecodeJob[] = [];
  #worker: Worker | null = null;
  #last: Promise<unknown> = Promise.resolve();
  #decoding = new Decoding();
  #nextId = 0;
  readonly #over = new AbortController();

  /** Starts a worker, unless `inWorker` is false. */
  constructor(inWorker = true) {
    if (!inWorker || typeof Worker === 'undefined') return;
    try {
      this.#worker = new Worker(new URL('./worker.js', import.meta.url), { type: 'module' });
    } catch {
      // A page may forbid workers.
      return;
    }
    this.#worker.addEventListener('message', ({ data }: MessageEvent<DecodeAnswer>) => this.#take(data));
    this.#worker.addEventListener('error', () => this.#takeOver());
  }

  /** Whether a worker decodes. */
  get hasWorker(): boolean {
    return this.#worker !== null;
  }

  /**
   * Decodes a part.
   *
   * @throws ShadowFileError if it is damaged.
   */
  decode(job: DecodeJob): Promise<Uint32Array> {
    if (job.kind === 'common') this.#commons.push(job);
    return new Promise((resolve, reject) => {
      const id = this.#nextId++;
      this.#pending.set(id, { job, resolve, reject });
      if (this.#worker === null) this.#doOnPage(id);
      else this.#worker.postMessage({ id, job } satisfies DecodeRequest);
    });
  }

  /** Ends the worker. Pending jobs reject with an `AbortError`. */
  dispose(): void {
    this.#worker?.terminate();
    this.#worker = null;
    this.#over.abort();
    for (const { reject } of this.#pending.values()) reject(this.#over.signal.reason);
    this.#pending.clear();
  }

  #take({ id, words, error }: DecodeAnswer): void {
    const pending = this.#pending.get(id);
    this.#pending.delete(id);
    if (words !== undefined) pending?.resolve(words);
    else if (error !== undefined) pending?.reject(new ShadowFileError(error.kind, error.message, error.details, { fault: error.fault }));
  }

  /** Goes on without the worker, which could not be loaded. */
  #takeOver(): void {
    this.#worker?.terminate();
    this.#worker = null;
    const ids = [...this.#pending.keys()];
    const isPending = (job: DecodeJob): boolean => ids.some((id) => this.#pending.get(id)!.job === job);
    for (const job of this.#commons) if (!isPending(job)) this.#then(job);
    for (const id of ids) this.#doOnPage(id);
  }

  #doOnPage(id: number): void {
    const { job, resolve, reject } = this.#pending.get(id)!;
    this.#then(job)
      .then(resolve, reject)
      .finally(() => this.#pending.delete(id));
  }

  /** Does a job after all earlier jobs. */
  #then(job: DecodeJob): Promise<Uint32Array> {
    const done = this.#last.then(() => runInSlices(this.#decoding.do(job), this.#over.signal));
    this.#last = done.catch(() => undefined);
    return done;
  }
}
