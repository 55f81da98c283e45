// The measurements of the page: bytes over the wire, frame times, depth passes.

import { element } from './dom.js';
import type { DepthPasses } from './halves.js';

/** Frames in the median. */
const FRAMES = 60;
/** Milliseconds between changes of the numbers, so that they can be read. */
const CHANGE = 500;

/** Bytes of a resource as transferred, or as stored in the browser's cache. */
function bytesOf(entry: PerformanceResourceTiming): number {
  return entry.transferSize || entry.encodedBodySize;
}

/** Returns the bytes that the page has fetched, and those of the shadow file among them. */
export function fetched(): { all: number; file: number } {
  const entries = [...performance.getEntriesByType('navigation'), ...performance.getEntriesByType('resource')];
  let [all, file] = [0, 0];
  for (const entry of entries as PerformanceResourceTiming[]) {
    all += bytesOf(entry);
    if (new URL(entry.name).pathname.endsWith('/city.adumbra')) file += bytesOf(entry);
  }
  return { all, file };
}

/** Formats a number of bytes. */
export function megabytes(bytes: number): string {
  return `${(bytes / 1e6).toFixed(2)} MB`;
}

/** The numbers. */
export class ReadOuts {
  readonly #times: number[] = [];
  #before: number | undefined;
  #written = 0;

  /** Forgets the times so far, because something else is drawn from now on. */
  restart(): void {
    this.#times.length = 0;
    this.#before = undefined;
  }

  /** Records a frame that began at `now`, with the depth passes of the halves that it has. */
  frame(now: number, file: DepthPasses | null, stock: DepthPasses | null): void {
    if (this.#before !== undefined) this.#times.push(now - this.#before);
    if (this.#times.length > FRAMES) this.#times.shift();
    this.#before = now;
    if (now - this.#written < CHANGE) return;
    this.#written = now;
    const bytes = fetched();
    write('bytes', megabytes(bytes.all));
    write('shadows', megabytes(bytes.file));
    const median = [...this.#times].sort((a, b) => a - b)[this.#times.length >> 1];
    write('frame', median === undefined ? '…' : `${median.toFixed(1)} ms`);
    const each = (name: 'passes' | 'triangles'): string => {
      const ofFile = file?.[name].toLocaleString('en-GB');
      const ofStock = stock?.[name].toLocaleString('en-GB');
      return ofFile !== undefined && ofStock !== undefined ? `${ofFile} | ${ofStock}` : (ofFile ?? ofStock ?? '…');
    };
    write('passes', each('passes'));
    write('triangles', each('triangles'));
    element('read-both', HTMLElement).hidden = file === null || stock === null;
  }
}

/** A number's name. */
type Name = 'bytes' | 'shadows' | 'frame' | 'passes' | 'triangles' | 'wrong';

/** Writes one number. */
export function write(name: Name, text: string): void {
  const place = element(`read-${name}`, HTMLElement);
  if (place.textContent !== text) place.textContent = text;
}
