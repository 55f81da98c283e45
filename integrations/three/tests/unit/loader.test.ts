// The loader against a server on this machine.

import { createServer } from 'node:http';
import type { AddressInfo } from 'node:net';

import { LoadingManager } from 'three';
import { afterAll, beforeAll, expect, it, vi } from 'vitest';

import { BakedShadowFile, ShadowFileError, ShadowFileLoader } from '../../src/index.js';
import { invalidVector, validBytes } from './vectors.js';

const GOOD = validBytes('upright_depths');
const CODED = validBytes('levels_coded_depths');
const DAMAGED = GOOD.slice();
DAMAGED[DAMAGED.length - 1] ^= 1;
const FILES: Record<string, Uint8Array> = {
  '/city/good.adumbra': GOOD,
  '/city/coded.adumbra': CODED,
  '/city/damaged.adumbra': DAMAGED,
  '/city/magic.adumbra': invalidVector('magic').bytes,
};

const PROGRESS_EVENT = class extends Event {
  readonly loaded: number;
  constructor(type: string, { loaded = 0 }: ProgressEventInit) {
    super(type);
    this.loaded = loaded;
  }
};

const requests: string[] = [];
const server = createServer((request, response) => {
  requests.push(`${request.url} ${request.headers['x-token'] ?? ''}`);
  const bytes = FILES[request.url ?? ''];
  // The path `/never` is left without an answer.
  if (bytes !== undefined) response.end(bytes);
  else if (request.url !== '/never') response.writeHead(404).end();
});
let address = '';

beforeAll(async () => {
  // Node has no progress events, with which three.js reports progress.
  vi.stubGlobal('ProgressEvent', PROGRESS_EVENT);
  await new Promise<void>((resolve) => server.listen(0, '127.0.0.1', resolve));
  address = `http://127.0.0.1:${(server.address() as AddressInfo).port}`;
});
afterAll(() => {
  server.closeAllConnections();
  server.close();
  vi.unstubAllGlobals();
});

it('loads a file, with path, header and progress', async () => {
  const loader = new ShadowFileLoader();
  loader.setPath(`${address}/city/`).setRequestHeader({ 'x-token': 'secret' });
  const progress = vi.fn<(event: ProgressEvent) => void>();
  const file = await loader.loadAsync('good.adumbra', progress);
  expect(file).toBeInstanceOf(BakedShadowFile);
  expect(file.byteLength).toBe(GOOD.length);
  expect(requests).toContain('/city/good.adumbra secret');
  expect(progress.mock.lastCall?.[0].loaded).toBe(GOOD.length);
});

it('the manager waits until a coded file is decoded', async () => {
  const manager = new LoadingManager();
  const order: string[] = [];
  manager.onLoad = () => order.push('manager');
  const loaded = new Promise<BakedShadowFile>((resolve, reject) => {
    const onLoad = (file: BakedShadowFile): void => {
      order.push('file');
      resolve(file);
    };
    new ShadowFileLoader(manager).load(`${address}/city/coded.adumbra`, onLoad, undefined, reject);
  });
  expect(await loaded).toEqual(new BakedShadowFile(CODED));
  await vi.waitFor(() => expect(order).toEqual(['file', 'manager']));
});

it.each(['loader', 'manager'])('is aborted by its %s while it decodes', async (which) => {
  const manager = new LoadingManager();
  const loader = new ShadowFileLoader(manager);
  const parse = vi.spyOn(loader, 'parseAsync');
  const loading = loader.loadAsync(`${address}/city/coded.adumbra`).catch((error: unknown) => error);
  await vi.waitFor(() => expect(parse).toHaveBeenCalled(), { interval: 0 });
  if (which === 'loader') loader.abort();
  else manager.abort();
  expect(await loading).toMatchObject({ name: 'AbortError' });
});

it('an invalid file is a ShadowFileError that names the URL', async () => {
  const manager = new LoadingManager();
  manager.onError = vi.fn();
  const url = `${address}/city/magic.adumbra`;
  const error: unknown = await new ShadowFileLoader(manager).loadAsync(url).catch((e: unknown) => e);
  expect(error).toBeInstanceOf(ShadowFileError);
  expect(error).toMatchObject({ kind: 'Magic', url });
  expect((error as ShadowFileError).message).toContain(`${url}: not a shadow file`);
  expect(manager.onError).toHaveBeenCalledWith(url);
});

it('a missing file is a ShadowFileError of the kind Io', async () => {
  const url = `${address}/city/missing.adumbra`;
  const error: unknown = await new ShadowFileLoader().loadAsync(url).catch((e: unknown) => e);
  expect(error).toBeInstanceOf(ShadowFileError);
  expect(error).toMatchObject({ kind: 'Io', url, cause: { response: { status: 404 } } });
  expect((error as ShadowFileError).message).toContain('404');
});

it('verifies as its setting says', async () => {
  const url = `${address}/city/damaged.adumbra`;
  const loader = new ShadowFileLoader();
  await expect(loader.loadAsync(url)).rejects.toMatchObject({ kind: 'SectionChecksum', url });
  loader.verify = 'header';
  expect((await loader.loadAsync(url)).byteLength).toBe(GOOD.length);
});

it.each(['loader', 'manager'])('is aborted by its %s, and works again afterwards', async (which) => {
  const manager = new LoadingManager();
  const loader = new ShadowFileLoader(manager);
  const never = loader.loadAsync(`${address}/never`);
  if (which === 'loader') loader.abort();
  else manager.abort();
  await expect(never).rejects.toMatchObject({ name: 'AbortError' });
  expect((await loader.loadAsync(`${address}/city/good.adumbra`)).byteLength).toBe(GOOD.length);
});

it.each([false, true])('is aborted by a signal, which has aborted before: %s', async (before) => {
  const loader = new ShadowFileLoader();
  const controller = new AbortController();
  loader.signal = controller.signal;
  if (before) controller.abort();
  const never = loader.loadAsync(`${address}/never`);
  controller.abort();
  await expect(never).rejects.toMatchObject({ name: 'AbortError' });
  loader.signal = null;
  expect((await loader.loadAsync(`${address}/city/good.adumbra`)).byteLength).toBe(GOOD.length);
});

it('loads again in the same tick as it aborts, as React does', async () => {
  const loader = new ShadowFileLoader();
  const url = `${address}/city/good.adumbra`;
  const first = loader.loadAsync(url);
  loader.abort();
  const second = loader.loadAsync(url);
  await expect(first).rejects.toMatchObject({ name: 'AbortError' });
  expect((await second).byteLength).toBe(GOOD.length);
});

it.each([0, 1])('aborting load %s of two of a URL lets the other go on', async (which) => {
  const loaders = [new ShadowFileLoader(), new ShadowFileLoader()];
  const loads = loaders.map((loader) => loader.loadAsync(`${address}/city/good.adumbra`));
  loaders[which]!.abort();
  await expect(loads[which]).rejects.toMatchObject({ name: 'AbortError' });
  expect((await loads[1 - which])!.byteLength).toBe(GOOD.length);
});

it('two loads of a URL are both aborted by their manager', async () => {
  const manager = new LoadingManager();
  const loads = [0, 1].map(() => new ShadowFileLoader(manager).loadAsync(`${address}/never`));
  manager.abort();
  for (const load of loads) await expect(load).rejects.toMatchObject({ name: 'AbortError' });
});

it('outside of browsers, the error says what to do', async () => {
  vi.stubGlobal('ProgressEvent', undefined);
  const error = await new ShadowFileLoader().loadAsync(`${address}/city/good.adumbra`).catch((reason: unknown) => reason);
  expect(error).toMatchObject({ name: 'ShadowFileError', kind: 'Io', url: `${address}/city/good.adumbra` });
  expect((error as Error).message).toContain('new BakedShadowFile(bytes)');
  vi.stubGlobal('ProgressEvent', PROGRESS_EVENT);
});

it('without onError, errors are printed', async () => {
  const printed = vi.spyOn(console, 'error').mockImplementation(() => undefined);
  new ShadowFileLoader().load(`${address}/city/magic.adumbra`, () => undefined);
  await vi.waitFor(() => expect(printed).toHaveBeenCalledWith(expect.objectContaining({ kind: 'Magic' })));
  printed.mockRestore();
});
