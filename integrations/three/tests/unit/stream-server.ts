// A server of one file, in place of `fetch`, with the faults that servers and networks have.

import { vi } from 'vitest';

import { PerspectiveCamera } from 'three';
import type { StreamedShadowFile } from '../../src/stream/index.js';

/** The faults of a server. */
export interface Faults {
  /** The server does not support ranges. */
  noRanges?: boolean;
  /** No Content-Range and no ETag can be read, as from another origin. */
  isHidden?: boolean;
  /** Changes the answer to a request, or throws as `fetch` does. `number` counts requests from 0 on. */
  answer?(request: { number: number; from: number; to: number; signal: AbortSignal | undefined }, bytes: Uint8Array): Response | Uint8Array | Promise<Response | Uint8Array> | undefined;
}

/** The requests that a server received. */
export interface Served {
  bytes: Uint8Array;
  etag: string;
  faults: Faults;
  readonly ranges: [from: number, to: number][];
  /** Most requests that were under way at a time. */
  most: number;
}

/** Serves a file in place of `fetch`. */
export function serve(bytes: Uint8Array, faults: Faults = {}): Served {
  const served: Served = { bytes, etag: '"1"', faults, ranges: [], most: 0 };
  let underWay = 0;
  vi.stubGlobal('fetch', async (_: string, init: RequestInit): Promise<Response> => {
    const [from, to] = /^bytes=(\d+)-(\d+)$/.exec(new Headers(init.headers).get('Range')!)!.slice(1).map(Number) as [number, number];
    const number = served.ranges.push([from, to]) - 1;
    served.most = Math.max(served.most, ++underWay);
    try {
      await Promise.resolve();
      init.signal?.throwIfAborted();
      const { noRanges = false, isHidden = false, answer } = served.faults;
      const all = served.bytes;
      const end = Math.min(to + 1, all.length);
      const etag: Record<string, string> = isHidden ? {} : { ETag: served.etag };
      if (noRanges) return new Response(all.slice(), { status: 200, headers: etag });
      const part = all.slice(from, end);
      const changed = await answer?.({ number, from, to, signal: init.signal ?? undefined }, part);
      if (changed instanceof Response) return changed;
      const headers: Record<string, string> = isHidden ? {} : { ...etag, 'Content-Range': `bytes ${from}-${end - 1}/${all.length}` };
      return new Response((changed ?? part) as Uint8Array<ArrayBuffer>, { status: 206, headers });
    } finally {
      underWay -= 1;
    }
  });
  return served;
}

/** A camera over a place of the world, looking down. */
export function cameraAt(x: number, y: number, z: number): PerspectiveCamera {
  const camera = new PerspectiveCamera(60, 16 / 9, 0.1, 1e5);
  camera.position.set(x, y, z);
  camera.lookAt(x + 1, y - 2, z);
  return camera;
}

/** Lets pending work go on. */
export const pause = (): Promise<void> => new Promise((resolve) => setTimeout(resolve));

/** Updates until everything that a camera needs and the budget allows is resident. */
export async function settled(file: StreamedShadowFile, camera = cameraAt(0, 100, 0), rows = 1080): Promise<void> {
  const END = 10_000;
  let [whole, still] = [0, 0];
  // No counter shows bundles that are being decoded.
  for (let i = 0; i < END && whole < 20 && still < 400; i++) {
    const before = JSON.stringify(file.stats);
    file.update(camera, rows);
    await pause();
    const { missing, underWay, fading } = file.stats;
    whole = missing === 0 && underWay === 0 && fading === 0 ? whole + 1 : 0;
    still = before === JSON.stringify(file.stats) ? still + 1 : 0;
  }
}
