// Loads `.adumbra` files as other loaders of three.js load theirs.

import { FileLoader, Loader } from 'three';

import { ShadowFileError } from './error.js';
import { BakedShadowFile } from './file/shadow-file.js';

/**
 * Loads a `.adumbra` file into a {@link BakedShadowFile}.
 *
 * `loadAsync` rejects with the error that `load` gives to `onError`: a {@link ShadowFileError} whose message
 * and `url` name the file, of the kind `Io` if it could not be fetched. A request that was aborted, by
 * {@link ShadowFileLoader.abort}, by {@link ShadowFileLoader.signal} or by the loading manager, gives the
 * browser's `AbortError`.
 */
export class ShadowFileLoader extends Loader<BakedShadowFile> {
  /** The checks: everything by default; `'header'` for files that you trust. */
  verify: true | 'header' = true;
  /** The most bytes of memory that a file may take while it is parsed, see `limitBytes` of `ParseOptions`. */
  limitBytes = Infinity;
  /** Loads that begin while it is set end once it aborts. */
  signal: AbortSignal | null = null;
  /** Functions that end the loads that are under way. */
  readonly #aborts = new Set<() => void>();

  /**
   * Loads the file at `url`, after the loader's `path`.
   *
   * @param onProgress Is called with the bytes that have arrived.
   * @param onError Is called with a {@link ShadowFileError}, or with an `AbortError`.
   */
  override load(
    url: string,
    onLoad: (file: BakedShadowFile) => void,
    onProgress?: (event: ProgressEvent) => void,
    onError: (error: unknown) => void = console.error,
  ): void {
    const { signal } = this;
    // Three has it from 0.179 on.
    const ofManager = this.manager.abortController?.signal;
    let isOver = false;
    let request: FileLoader<ArrayBuffer>;
    const parsing = new AbortController();
    const end = (): void => {
      isOver = true;
      this.#aborts.delete(abort);
      for (const each of [signal, ofManager]) each?.removeEventListener('abort', abort);
    };
    const fail = (error: unknown): void => {
      end();
      onError(error);
    };
    const abort = (): void => {
      fail(new DOMException(`the load of ${url} was aborted`, 'AbortError'));
      parsing.abort();
      // Before 0.179, three does not end the transfer.
      request.abort?.();
    };
    const fetchFile = (mayRetry: boolean): void => {
      request = new FileLoader<ArrayBuffer>(this.manager)
        .setPath(this.path)
        .setResponseType('arraybuffer')
        .setRequestHeader(this.requestHeader)
        .setWithCredentials(this.withCredentials);
      request.load(
        url,
        (buffer) => {
          if (isOver) return;
          // For the manager, the request is over when this returns, but the load is not.
          this.manager.itemStart(url);
          this.parseAsync(buffer, parsing.signal)
            .then(
              (file) => {
                if (isOver) return;
                end();
                onLoad(file);
              },
              (error: unknown) => {
                if (isOver) return;
                fail(withUrl(error, url));
                this.manager.itemError(url);
              },
            )
            .finally(() => this.manager.itemEnd(url));
        },
        (event) => {
          if (!isOver) onProgress?.(event);
        },
        (error) => {
          if (isOver) return;
          // Loads of one URL share one request in three, which another load has aborted.
          if (mayRetry && isAbort(error) && !ofManager?.aborted) fetchFile(false);
          else fail(isAbort(error) ? error : withUrl(error, url));
        },
      );
    };
    if (typeof ProgressEvent === 'undefined') {
      const message = 'three loads files in browsers only; read the file, and give its bytes to new BakedShadowFile(bytes)';
      fail(new ShadowFileError('Io', message, {}, { url }));
      return;
    }
    this.#aborts.add(abort);
    for (const each of [signal, ofManager]) each?.addEventListener('abort', abort);
    fetchFile(true);
    if (signal?.aborted) abort();
  }

  /**
   * Parses the bytes of a file at once. It does not keep the buffer.
   *
   * @throws ShadowFileError if the bytes are not exactly one valid file.
   */
  parse(buffer: ArrayBufferLike | Uint8Array): BakedShadowFile {
    return new BakedShadowFile(buffer, this);
  }

  /**
   * Parses the bytes of a file in slices of about ten milliseconds, so that the page stays responsive. It
   * does not keep the buffer.
   *
   * @throws ShadowFileError if the bytes are not exactly one valid file.
   * @throws the reason of `signal`, once it aborts.
   */
  parseAsync(buffer: ArrayBufferLike | Uint8Array, signal?: AbortSignal): Promise<BakedShadowFile> {
    const { verify, limitBytes } = this;
    return BakedShadowFile.parseAsync(buffer, { verify, limitBytes, signal });
  }

  /** Aborts all requests that are under way. The loader can be used again afterwards. */
  override abort(): this {
    for (const abort of this.#aborts) abort();
    return this;
  }
}

function isAbort(error: unknown): boolean {
  return (error as Error).name === 'AbortError';
}

/** Returns an error that names the file. */
function withUrl(error: unknown, url: string): unknown {
  if (error instanceof ShadowFileError) {
    const { kind, message, details, fault, cause } = error;
    return new ShadowFileError(kind, message, details, { fault, url, cause });
  }
  const { message: reason } = error as Error;
  return new ShadowFileError('Io', `cannot be fetched: ${reason}; check its path and the server`, {}, { url, cause: error });
}
