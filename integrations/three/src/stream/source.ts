// The bytes of a file on a server, part by part. Without ranges, the whole file is read once.

import { ShadowFileError } from '../error.js';
import { warnOnce } from '../light/warn.js';

/** Options of `fetch` besides the range, such as `credentials` or `headers`. */
export type FetchOptions = Omit<RequestInit, 'signal' | 'method' | 'body'>;

/** A file on a server. */
export class Source {
  readonly url: string;
  readonly #options: FetchOptions;
  readonly #timeout: number;
  /** Ends all requests. */
  readonly #over = new AbortController();
  /** The whole file, if the server has no ranges. */
  #whole: Promise<Uint8Array> | undefined;
  #etag: string | null = null;
  #length: number | undefined;
  #requests = 0;
  #bytes = 0;

  /** Names a file. A request that takes longer than `timeout` milliseconds fails. */
  constructor(url: string, options: FetchOptions, timeout: number) {
    this.url = url;
    this.#options = options;
    this.#timeout = timeout;
  }

  /** Number of requests so far. */
  get requests(): number {
    return this.#requests;
  }

  /** Number of bytes that have arrived so far. */
  get bytes(): number {
    return this.#bytes;
  }

  /** Length of the file, bytes, if the server reports it. */
  get fileLength(): number | undefined {
    return this.#length;
  }

  /**
   * Reads a part of the file. It is shorter than `length` only if the file ends before.
   *
   * @throws ShadowFileError of the kind `Io` if it cannot be fetched, or `Changed` if the file has changed.
   */
  async read(offset: number, length: number): Promise<Uint8Array> {
    if (this.#whole !== undefined) return (await this.#whole).subarray(offset, offset + length);
    const slow = new AbortController();
    const timer = setTimeout(() => slow.abort(), this.#timeout);
    const stop = (): void => slow.abort();
    this.#over.signal.addEventListener('abort', stop);
    try {
      this.#over.signal.throwIfAborted();
      return await this.#fetch(offset, length, slow.signal, () => clearTimeout(timer));
    } catch (error) {
      if (error instanceof ShadowFileError) throw error;
      this.#over.signal.throwIfAborted();
      const reason = slow.signal.aborted ? `no answer in ${this.#timeout / 1000} s` : (error as Error).message;
      throw this.#failed(offset, length, reason, error);
    } finally {
      clearTimeout(timer);
      this.#over.signal.removeEventListener('abort', stop);
    }
  }

  /** Ends all requests, which reject with an `AbortError`. */
  abort(): void {
    this.#over.abort();
  }

  async #fetch(offset: number, length: number, signal: AbortSignal, onWhole: () => void): Promise<Uint8Array> {
    const headers = new Headers(this.#options.headers);
    headers.set('Range', `bytes=${offset}-${offset + length - 1}`);
    this.#requests += 1;
    const response = await fetch(this.url, { ...this.#options, headers, signal });
    if (response.status === 200) {
      onWhole();
      if (this.#whole !== undefined) void response.body?.cancel();
      return (await (this.#whole ??= this.#takeWhole(response))).subarray(offset, offset + length);
    }
    if (response.status !== 206) throw this.#failed(offset, length, `the server answered ${response.status} ${response.statusText}`);
    const range = /^bytes (\d+)-(\d+)\/(\d+|\*)$/.exec(response.headers.get('Content-Range') ?? '');
    const total = range === null || range[3] === '*' ? undefined : Number(range[3]);
    this.#checkSame(response, total);
    if (range !== null && Number(range[1]) !== offset) throw this.#failed(offset, length, `the server sent the bytes from ${range[1]} on`);
    const bytes = new Uint8Array(await response.arrayBuffer());
    this.#bytes += bytes.length;
    // Only the first request may ask for more bytes than the file has. Servers of other origins may hide its
    // length.
    const end = this.#length === undefined ? Infinity : Math.max(this.#length - offset, 0);
    const isAll = bytes.length === Math.min(length, end) || (end === Infinity && offset === 0 && bytes.length < length);
    if (!isAll) throw this.#failed(offset, length, `the server sent ${bytes.length} bytes`);
    return bytes;
  }

  /** Reads all of a response to a request of a part. */
  async #takeWhole(response: Response): Promise<Uint8Array> {
    try {
      this.#checkSame(response, undefined);
      warnOnce(`the server of ${this.url} sends no ranges, so all of it was loaded`, `ranges ${this.url}`);
      const bytes = new Uint8Array(await response.arrayBuffer());
      this.#bytes += bytes.length;
      if (this.#length !== undefined && this.#length !== bytes.length) throw this.#changed('length', this.#length, bytes.length);
      this.#length = bytes.length;
      return bytes;
    } catch (error) {
      this.#whole = undefined;
      throw error;
    }
  }

  /** Checks that a response belongs to the file that was first seen, as far as its headers say. */
  #checkSame(response: Response, length: number | undefined): void {
    const etag = response.headers.get('ETag');
    if (etag !== null && this.#etag !== null && etag !== this.#etag) throw this.#changed('ETag', this.#etag, etag);
    if (length !== undefined && this.#length !== undefined && length !== this.#length) throw this.#changed('length', this.#length, length);
    this.#etag ??= etag;
    this.#length ??= length;
  }

  #changed(what: string, before: number | string, now: number | string): ShadowFileError {
    return changed(this.url, `its ${what} was ${before} and is ${now}`, { what, before, now });
  }

  #failed(offset: number, length: number, reason: string, cause?: unknown): ShadowFileError {
    const message = `bytes ${offset} to ${offset + length - 1} cannot be fetched: ${reason}; check the path and the server`;
    return new ShadowFileError('Io', message, { offset, length }, { url: this.url, cause });
  }
}

/** Returns the error of a file that has changed since it was opened. */
export function changed(url: string, how: string, details: Record<string, number | string>): ShadowFileError {
  return new ShadowFileError('Changed', `has changed since it was opened: ${how}; open it again`, details, { url });
}
