// Faults of servers and networks while a file is streamed: the coarser level stays, an event names the fault,
// and failed parts are requested again.

import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';

import { toWorld } from '../../src/grid/light-grid.js';
import { BakedShadowFile, Sampler, ShadowFileError } from '../../src/index.js';
import { STREAM_DEFAULTS, StreamedShadowFile } from '../../src/stream/index.js';
import type { StreamOptions } from '../../src/stream/index.js';
import { cameraAt, pause, serve, settled } from './stream-server.js';
import type { Faults } from './stream-server.js';
import { validBytes } from './vectors.js';

const OPTIONS: StreamOptions = { budgetBytes: 1024 * 1024, detailPixels: 1e-9 };
const bytes = validBytes('levels_coded_depths');
const whole = new BakedShadowFile(bytes);
const [x, y, z] = toWorld(whole.grid, [300, 250, 40]);
/** A point in the grid of all levels. */
const POINT = { x, y, z };

/** The events of a file. */
function listen(file: StreamedShadowFile) {
  const heard = { errors: [] as ShadowFileError[], parts: [] as string[], changes: [] as ShadowFileError[] };
  file.addEventListener('error', ({ error, parts }) => {
    heard.errors.push(error);
    heard.parts.push(...parts);
  });
  file.addEventListener('changed', ({ error }) => void heard.changes.push(error));
  return heard;
}

/** Updates a few times, and lets pending work go on. */
async function frames(file: StreamedShadowFile, count = 40): Promise<void> {
  for (let i = 0; i < count; i++) {
    file.update(cameraAt(0, 10, 0), 1080);
    await pause();
  }
}

function expectWhole(file: StreamedShadowFile): void {
  const sampler = file.sampler({ filter: 5 });
  expect(sampler.levelAt(POINT)).toBe(0);
  expect(sampler.visibility(POINT)).toBe(new Sampler(whole, { filter: 5 }).visibility(POINT));
}

async function failure(opening: Promise<unknown>): Promise<ShadowFileError> {
  return opening.then(
    () => Promise.reject(new Error('it was opened')),
    (error: ShadowFileError) => error,
  );
}

let warnings: string[];
beforeEach(() => {
  warnings = [];
  vi.spyOn(console, 'warn').mockImplementation((text: string) => void warnings.push(text));
});
afterEach(() => {
  vi.restoreAllMocks();
  vi.unstubAllGlobals();
  vi.useRealTimers();
});

/** Faults of all requests after the opening until they are taken away. */
const later = (answer: NonNullable<Faults['answer']>): Faults => ({ answer: (request, part) => (request.number > 0 ? answer(request, part) : undefined) });

describe('a request that fails', () => {
  const ways: [string, Faults, RegExp][] = [
    ['is dropped', later(() => Promise.reject(new TypeError('Failed to fetch'))), /^u: bytes \d+ to \d+ cannot be fetched: Failed to fetch; check/],
    ['ends early', later((_, part) => part.slice(0, 10)), /the server sent 10 bytes/],
    ['is of another range', later(({ from }, part) => new Response(part as Uint8Array<ArrayBuffer>, { status: 206, headers: { 'Content-Range': `bytes ${from + 1}-${from + part.length}/${bytes.length}` } })), /the server sent the bytes from \d+ on/],
    ['is refused', later(() => new Response(null, { status: 503, statusText: 'Service Unavailable' })), /the server answered 503 Service Unavailable/],
    ['is damaged', later(({ from }, part) => (from === 0 ? part : part.map((byte, i) => (i === 5 ? byte ^ 1 : byte)))), /is damaged: its checksum is 0x/],
  ];
  it.each(ways)('%s: the coarser level stays, and a second try works', async (_, faults, said) => {
    vi.useFakeTimers({ toFake: ['performance'] });
    const served = serve(bytes, faults);
    const file = await StreamedShadowFile.open('u', OPTIONS);
    const heard = listen(file);
    await frames(file);
    expect(heard.parts.sort()).toEqual(['bundle 0 of level 1', 'common section of level 0']);
    for (const error of heard.errors) {
      expect(error).toBeInstanceOf(ShadowFileError);
      expect(error.message).toMatch(said);
    }
    expect(warnings.length).toBeLessThanOrEqual(1);
    expect(file.sampler({ filter: 5 }).levelAt(POINT)).toBe(2);
    expect(file.sampler({ filter: 5 }).visibility(POINT)).toBe(new Sampler(whole.level(2)!, { filter: 5 }).visibility(POINT));

    const asked = served.ranges.length;
    vi.advanceTimersByTime(999);
    await frames(file);
    expect(served.ranges).toHaveLength(asked);
    vi.advanceTimersByTime(1);
    await frames(file);
    expect(heard.parts).toHaveLength(4);
    // Two seconds, then four.
    vi.advanceTimersByTime(1999);
    await frames(file);
    expect(heard.parts).toHaveLength(4);
    vi.advanceTimersByTime(1);
    await frames(file);
    expect(heard.parts).toHaveLength(6);
    served.faults = {};
    vi.advanceTimersByTime(4000);
    await frames(file);
    expectWhole(file);
    expect(heard.parts).toHaveLength(6);
    expect(heard.changes).toEqual([]);
    file.dispose();
  });

  it('is tried again at once on demand', async () => {
    const served = serve(bytes, later(() => Promise.reject(new TypeError('Failed to fetch'))));
    const file = await StreamedShadowFile.open('u', OPTIONS);
    await frames(file);
    served.faults = {};
    file.retry();
    await frames(file);
    expectWhole(file);
    file.dispose();
  });

  it('fails if it is too slow', async () => {
    const served = serve(bytes, later(({ signal }) => new Promise((_, reject) => signal!.addEventListener('abort', () => reject(signal!.reason)))));
    const file = await StreamedShadowFile.open('u', { ...OPTIONS, timeoutSeconds: 0.02 });
    const heard = listen(file);
    await frames(file);
    await new Promise((done) => setTimeout(done, 40));
    await frames(file);
    expect(heard.errors[0]!.message).toMatch(/cannot be fetched: no answer in 0.02 s/);
    served.faults = {};
    file.retry();
    await frames(file);
    expectWhole(file);
    file.dispose();
  });
});

it('a bundle whose shapes are wrong is refused though its checksum is right', async () => {
  const { entry, damaged } = await withWrongShapes();
  serve(damaged);
  const file = await StreamedShadowFile.open('u', OPTIONS);
  const heard = listen(file);
  await frames(file);
  expect(heard.parts).toContain(entry);
  expect(heard.errors.map(({ kind }) => kind)).toContain('Depths');
  expect(file.sampler({ filter: 1 }).levelAt(POINT)).toBe(1);
  file.dispose();
});

describe('a file that is replaced', () => {
  const replaced: [string, (served: ReturnType<typeof serve>) => void, RegExp][] = [
    ['ETag', (served) => (served.etag = '"2"'), /^u: has changed since it was opened: its ETag was "1" and is "2"; open it again$/],
    ['length', (served) => (served.bytes = new Uint8Array([...bytes, 0])), /its length was 3234 and is 3235/],
    [
      'header',
      (served) => {
        served.bytes = validBytes('levels_depths');
        served.faults = { isHidden: true };
      },
      /its header is another/,
    ],
  ];
  it.each(replaced)('is noticed by its %s: requests end, and resident parts stay', async (_, replace, said) => {
    const served = serve(bytes, { isHidden: said.source.includes('header') });
    const file = await StreamedShadowFile.open('u', OPTIONS);
    const heard = listen(file);
    replace(served);
    await frames(file);
    expect(heard.changes).toHaveLength(1);
    expect(heard.changes[0]!.kind).toBe('Changed');
    expect(heard.changes[0]!.message).toMatch(said);
    expect(heard.errors).toEqual([]);
    const asked = served.ranges.length;
    file.retry();
    await frames(file);
    expect(served.ranges).toHaveLength(asked);
    expect(file.sampler({ filter: 5 }).levelAt(POINT)).toBe(2);
    file.dispose();
  });
});

it('a server without ranges is read once, with one warning', async () => {
  const served = serve(bytes, { noRanges: true });
  const file = await StreamedShadowFile.open('no-ranges', OPTIONS);
  await settled(file);
  expect(served.ranges).toHaveLength(1);
  expect(file.stats.fetchedBytes).toBe(bytes.length);
  expect(warnings).toHaveLength(1);
  expect(warnings[0]).toMatch(/no-ranges sends no ranges/);
  expectWhole(file);
  file.dispose();
});

it('works with another origin that shows neither ETag nor length', async () => {
  serve(bytes, { isHidden: true });
  const file = await StreamedShadowFile.open('u', OPTIONS);
  const heard = listen(file);
  await settled(file);
  expectWhole(file);
  expect(heard.errors).toEqual([]);
  file.dispose();
});

describe('opening', () => {
  it('fails with the address in the error', async () => {
    serve(bytes, { answer: () => new Response(null, { status: 404, statusText: 'Not Found' }) });
    const error = await failure(StreamedShadowFile.open('u', OPTIONS));
    expect(error).toMatchObject({ kind: 'Io', url: 'u' });
    expect(error.message).toMatch(/^u: bytes 0 to 65535 cannot be fetched: the server answered 404 Not Found; check the path and the server$/);
  });

  it('refuses bytes that are not a shadow file', async () => {
    serve(new TextEncoder().encode('<!doctype html>'));
    expect(await failure(StreamedShadowFile.open('u', OPTIONS))).toMatchObject({ kind: 'Magic', url: 'u' });
  });

  it('refuses a file that is cut off', async () => {
    serve(bytes.subarray(0, bytes.length - 1));
    expect(await failure(StreamedShadowFile.open('u', OPTIONS))).toMatchObject({ kind: 'Truncated' });
  });

  it('refuses a budget that the coarsest level does not fit', async () => {
    serve(validBytes('many_pages_depths'));
    const error = await failure(StreamedShadowFile.open('u', { budgetBytes: 8192 }));
    expect(error).toMatchObject({ kind: 'TooLarge' });
    expect(error.message).toMatch(/^u: the coarsest level needs \d+ bytes, but the budget is 8192; /);
  });

  it.each([{ budgetBytes: 0 }, { budgetBytes: NaN }, { budgetBytes: 1e10 }, { ...OPTIONS, detailPixels: 0 }, { ...OPTIONS, timeoutSeconds: -1 }, { uploadBytesPerFrame: 0 }, { fadeFrames: -1 }])('refuses %o', async (options) => {
    expect(await failure(StreamedShadowFile.open('u', options))).toBeInstanceOf(RangeError);
  });

  it('has defaults for all options', async () => {
    serve(bytes);
    const none = { budgetBytes: undefined, detailPixels: undefined } as unknown as StreamOptions;
    for (const file of [await StreamedShadowFile.open('u'), await StreamedShadowFile.open('u', none)]) {
      expect(file.stats.poolBytes).toBe(STREAM_DEFAULTS.budgetBytes);
      expect(file.sampler().filter).toBe(5);
    }
  });

  it('leaves levels out that take more than half of the budget with their tables', async () => {
    serve(bytes);
    const file = await StreamedShadowFile.open('u', { budgetBytes: 4096, detailPixels: 1e-9 });
    await frames(file);
    expect(file.stats.levels.map(({ level }) => level)).toEqual([1, 2]);
    expect(file.grid).toEqual(whole.level(1)!.grid);
    expect(file.settings).toEqual(whole.level(1)!.settings);
    expect(file.sampler({ filter: 5 }).levelAt(POINT)).toBe(1);
    file.dispose();
  });

  it('ends when its signal aborts, before and after', async () => {
    serve(bytes);
    const gone = AbortSignal.abort(new Error('too late'));
    expect((await failure(StreamedShadowFile.open('u', { ...OPTIONS, signal: gone }))).message).toBe('too late');
    const control = new AbortController();
    const opening = failure(StreamedShadowFile.open('u', { ...OPTIONS, signal: control.signal }));
    control.abort(new Error('no more'));
    expect((await opening).message).toBe('no more');

    const served = serve(bytes);
    const during = new AbortController();
    const file = await StreamedShadowFile.open('u', { ...OPTIONS, signal: during.signal });
    const heard = listen(file);
    file.update(cameraAt(0, 10, 0));
    during.abort();
    await frames(file);
    expect(heard.errors).toEqual([]);
    expect(served.ranges.length).toBeLessThanOrEqual(3);
    expect(file.sampler({ filter: 5 }).levelAt(POINT)).toBe(2);
  });
});

/** A raw file one of whose bundles has an invalid leaf, with all checksums as they must be. */
async function withWrongShapes(): Promise<{ entry: string; damaged: Uint8Array }> {
  const { crc32 } = await import('../../src/file/crc32.js');
  const damaged = validBytes('levels_depths');
  const view = new DataView(damaged.buffer);
  // The bundles of level 0 are the last part, and its table the first one after the directory of three
  // levels.
  const DIRECTORY = 256;
  const table = DIRECTORY + 3 * 256;
  const bundles = Number(view.getBigUint64(DIRECTORY + 208, true));
  const length = Number(view.getBigUint64(DIRECTORY + 216, true));
  // The first half-word of the first page is a leaf's.
  view.setUint16(bundles + 4 * 48, 0xffff, true);
  view.setUint32(table + 8, crc32(damaged.subarray(bundles, bundles + length)), true);
  view.setUint32(DIRECTORY + 160 + 16, crc32(damaged.subarray(table, table + 24)), true);
  view.setUint32(132, crc32(damaged.subarray(DIRECTORY, table)), true);
  view.setUint32(252, crc32(damaged.subarray(0, 252)), true);
  return { entry: 'bundle 0 of level 0', damaged };
}
