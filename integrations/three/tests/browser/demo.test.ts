// The demo page, built and served by a plain static server below a path, as a visitor gets it.

import { execFileSync } from 'node:child_process';
import { createReadStream, existsSync, readFileSync, statSync } from 'node:fs';
import { createServer } from 'node:http';
import type { Server } from 'node:http';
import type { AddressInfo } from 'node:net';
import { extname, join, normalize } from 'node:path';
import { fileURLToPath } from 'node:url';

import type { Browser, BrowserContextOptions, Page } from 'playwright-core';
import { afterAll, beforeAll, expect, test } from 'vitest';

import { launch, send } from './stage.js';

const ROOT = fileURLToPath(new URL('../..', import.meta.url));
const DIST = join(ROOT, 'demo/dist');
const BELOW = '/some/where/';

const TYPES: Record<string, string> = {
  '.css': 'text/css',
  '.html': 'text/html',
  '.js': 'text/javascript',
  '.json': 'application/json',
  '.png': 'image/png',
};

const IS_FULL = process.env['ADUMBRA_FULL'] !== undefined;

/** Few pixels and cheap shadows, for machines without a GPU. */
const SMALL = 'pixels=0.1&filter=1&stock=default';

const PHONE = { width: 390, height: 844 };

let server: Server;
let browser: Browser;
let sent = 0;
/** Requests of a range of bytes. */
let ranges = 0;
/** Bytes that would have been sent without compression. */
let plain = 0;

beforeAll(async () => {
  if (process.env['ADUMBRA_BIN'] === undefined) throw new Error('the browser tests need the program: ADUMBRA_BIN=…/adumbra');
  execFileSync('npm', ['run', 'build:demo'], { cwd: ROOT, stdio: 'pipe' });
  server = createServer((request, response) => {
    const { pathname } = new URL(request.url ?? '/', 'http://localhost');
    const name = pathname.startsWith(BELOW) ? normalize(decodeURIComponent(pathname.slice(BELOW.length))) : '';
    const file = join(DIST, name === '.' || name === '' ? 'index.html' : name);
    if (!pathname.startsWith(BELOW) || !existsSync(file)) {
      response.writeHead(404).end();
      return;
    }
    if (request.headers.range !== undefined) {
      ranges += 1;
      send(request, response, file);
      return;
    }
    const isSmaller = existsSync(`${file}.br`) && /\bbr\b/.test(request.headers['accept-encoding']?.toString() ?? '');
    const body = isSmaller ? `${file}.br` : file;
    sent += statSync(body).size;
    plain += statSync(file).size;
    response.writeHead(200, {
      'content-type': TYPES[extname(file)] ?? 'application/octet-stream',
      ...(isSmaller ? { 'content-encoding': 'br' } : {}),
    });
    createReadStream(body).pipe(response);
  });
  await new Promise<void>((ready) => server.listen(0, '127.0.0.1', ready));
  browser = await launch();
});

afterAll(async () => {
  await browser?.close();
  await new Promise((done) => server.close(done));
});

/**
 * Opens the page and waits for its first picture. Settings that `options` leaves out are as on a desk, with a
 * mouse.
 */
async function open(
  query: string,
  { before, path = '', ...options }: BrowserContextOptions & { before?: () => void; path?: string } = {},
): Promise<{ page: Page; complaints: string[] }> {
  const page = await browser.newPage({ viewport: { width: 960, height: 600 }, ...options });
  if (before !== undefined) await page.addInitScript(before);
  page.setDefaultTimeout(100_000);
  const complaints: string[] = [];
  page.on('console', (message) => {
    const isOfTheMachine = /GPU stall|software WebGL|SwiftShader/.test(message.text());
    if (['error', 'warning'].includes(message.type()) && !isOfTheMachine) complaints.push(message.text());
  });
  page.on('pageerror', (error) => complaints.push(String(error)));
  page.on('request', (request) => {
    if (!/^(data|blob):/.test(request.url()) && !request.url().startsWith(address())) complaints.push(request.url());
  });
  await page.goto(`${address()}${path}?${query}`);
  await drawn(page);
  return { page, complaints };
}

function address(): string {
  return `http://127.0.0.1:${(server.address() as AddressInfo).port}${BELOW}`;
}

async function drawn(page: Page): Promise<void> {
  await page.waitForFunction(() => document.documentElement.dataset['drawn'] === 'true');
}

/** A part of the screen that the canvas alone fills. */
function picture(page: Page): Promise<Buffer> {
  return page.screenshot({ clip: { x: 20, y: 150, width: 300, height: 200 } });
}

/** The number of colours in that part. */
async function colours(page: Page): Promise<number> {
  const png = await picture(page);
  return page.evaluate(async (data) => {
    const bitmap = await createImageBitmap(await (await fetch(`data:image/png;base64,${data}`)).blob());
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d')!;
    context.drawImage(bitmap, 0, 0);
    return new Set(new Uint32Array(context.getImageData(0, 0, bitmap.width, bitmap.height).data.buffer)).size;
  }, png.toString('base64'));
}

/** Waits until the status line says something. */
async function expectStatus(page: Page, said: RegExp): Promise<void> {
  await expect.poll(() => page.locator('#status').textContent(), { timeout: 60_000 }).toMatch(said);
}

/** Drops a file on the page. */
async function drop(page: Page, name: string, bytes: Buffer): Promise<void> {
  await page.evaluate(
    ([fileName, data]) => {
      const dataTransfer = new DataTransfer();
      const content = Uint8Array.from(atob(data!), (letter) => letter.charCodeAt(0));
      dataTransfer.items.add(new File([content], fileName!));
      document.body.dispatchEvent(new DragEvent('drop', { dataTransfer, bubbles: true, cancelable: true }));
    },
    [name, bytes.toString('base64')],
  );
}

test('shows its first picture after at most 3 MB, and says how many bytes it fetched', async () => {
  [sent, plain] = [0, 0];
  const { page, complaints } = await open(`renderer=webgpu&${SMALL}`);
  console.log(`first picture after ${sent} bytes, ${plain} without compression`);
  expect(sent).toBeLessThanOrEqual(3_000_000);
  // A server that compresses nothing sends this.
  expect(plain).toBeLessThanOrEqual(3_000_000);
  expect(await colours(page)).toBeGreaterThan(20);
  await page.waitForFunction(() => document.getElementById('read-bytes')?.textContent?.includes('MB'));
  const said = Number.parseFloat((await page.locator('#read-bytes').textContent())!);
  expect(Math.abs(said - sent / 1e6)).toBeLessThan(0.05);
  expect(await page.locator('#renderer').inputValue()).toBe('webgpu');
  expect(complaints).toEqual([]);
  await page.close();
});

test('moves its divider by keyboard, shows one kind of shadows alone, and goes on after a broken file', async () => {
  const { page, complaints } = await open(`renderer=webgpu&${SMALL}`);
  const divider = page.getByRole('slider', { name: /Divider/ });
  await divider.focus();
  for (const key of ['ArrowRight', 'PageUp']) await page.keyboard.press(key);
  expect(await divider.getAttribute('aria-valuenow')).toBe('62');
  await page.keyboard.press('Home');
  expect(await divider.getAttribute('aria-valuenow')).toBe('0');

  await page.getByLabel('File only').check();
  await page.waitForFunction(() => document.getElementById('read-passes')?.textContent === '1');
  expect(await divider.isVisible()).toBe(false);

  const whole = readFileSync(join(DIST, 'city.adumbra'));
  await drop(page, 'cut.adumbra', whole.subarray(0, 1000));
  await expectStatus(page, /^cut\.adumbra: Truncated: /);
  const broken = Buffer.from(whole);
  broken[whole.length >> 1]! ^= 1;
  await drop(page, 'broken.adumbra', broken);
  await expectStatus(page, /^broken\.adumbra: SectionChecksum: /);
  await drop(page, 'notes.txt', Buffer.from('?'));
  await expectStatus(page, /^notes\.txt: /);
  expect(await colours(page)).toBeGreaterThan(20);
  await drop(page, 'mine.adumbra', whole);
  await expectStatus(page, /^Shows city\.glb with mine\.adumbra\.$/);
  expect(await colours(page)).toBeGreaterThan(20);
  expect(complaints).toEqual([]);
  await page.close();
});

test('fits a phone, and changes its renderer', async () => {
  const { page, complaints } = await open(`renderer=webgl2&${SMALL}`, { viewport: PHONE });
  /** The elements that are wider inside than outside, and so would scroll or be cut off. */
  const tooWide = (): Promise<string[]> =>
    page.evaluate(() =>
      ['html', 'body', 'aside', 'dialog', 'dialog pre']
        .flatMap((each) => [...document.querySelectorAll(each)])
        .filter(({ scrollWidth, clientWidth }) => scrollWidth > clientWidth || scrollWidth > 390)
        .map(({ tagName }) => tagName),
    );
  expect(await tooWide()).toEqual([]);
  await page.locator('summary').click();
  expect(await tooWide()).toEqual([]);
  await page.getByRole('button', { name: 'What is this?' }).click();
  expect(await tooWide()).toEqual([]);
  await page.keyboard.press('Escape');
  await page.getByLabel('Renderer').selectOption('webgl');
  await page.waitForURL(/renderer=webgl&/);
  await drawn(page);
  expect(await page.getByLabel('Renderer').inputValue()).toBe('webgl');
  expect(await colours(page)).toBeGreaterThan(20);
  expect(complaints).toEqual([]);
  await page.close();
});

test.runIf(IS_FULL)('moves its divider by mouse', async () => {
  const { page, complaints } = await open(`renderer=webgl&${SMALL}`);
  const divider = page.getByRole('slider', { name: /Divider/ });
  const { x, y, width, height } = (await divider.boundingBox())!;
  expect(x + width / 2).toBeCloseTo(480, 0);
  await page.mouse.move(x + width / 2, y + height / 2);
  await page.mouse.down();
  await page.mouse.move(240, 300);
  await page.mouse.up();
  expect(await divider.getAttribute('aria-valuenow')).toBe('25');
  await page.mouse.move(700, 300);
  expect(await divider.getAttribute('aria-valuenow')).toBe('25');
  expect(complaints).toEqual([]);
  await page.close();
});

// Half a minute on a software renderer.
test.runIf(IS_FULL)('stands still where people want less motion, and turns and walks by touch', async () => {
  const hand = { hasTouch: true, isMobile: true, viewport: PHONE, reducedMotion: 'reduce' } as const;
  const { page, complaints } = await open(`renderer=webgl&${SMALL}`, hand);
  const touch = await page.context().newCDPSession(page);
  const point = (type: string, ...touchPoints: { x: number; y: number }[]): Promise<unknown> =>
    touch.send('Input.dispatchTouchEvent', { type: type as 'touchStart', touchPoints });
  const settled = async (): Promise<Buffer> => {
    const before = await picture(page);
    await page.waitForTimeout(700);
    const after = await picture(page);
    return before.equals(after) ? after : settled();
  };
  await page.locator('summary').click();
  expect(await page.locator('#bus').textContent()).toBe('Let the bus go');
  await page.locator('summary').click();

  const first = await settled();
  await point('touchStart', { x: 60, y: 500 });
  for (let x = 80; x <= 200; x += 20) await point('touchMove', { x, y: 500 });
  await point('touchEnd');
  const turned = await settled();
  expect(turned.equals(first)).toBe(false);
  expect(await page.evaluate(() => [scrollX, scrollY])).toEqual([0, 0]);

  await page.locator('summary').click();
  await page.getByRole('radio', { name: 'Walk' }).check();
  await page.locator('summary').click();
  const standing = await settled();
  const { x, y, width, height } = (await page.getByRole('button', { name: 'Forward' }).boundingBox())!;
  await point('touchStart', { x: x + width / 2, y: y + height / 2 });
  await page.waitForTimeout(1500);
  await point('touchEnd');
  expect((await settled()).equals(standing)).toBe(false);
  expect(complaints).toEqual([]);
  await page.close();
});

test('draws with WebGL2 where there is no WebGPU, and says so', async () => {
  const without = (): void => void Object.defineProperty(navigator, 'gpu', { value: undefined });
  const { page, complaints } = await open(`renderer=webgpu&${SMALL}`, { before: without });
  expect(await page.getByLabel('Renderer').inputValue()).toBe('webgl2');
  await expectStatus(page, /no WebGPU, so WebGL2 draws/);
  expect(await colours(page)).toBeGreaterThan(20);
  expect(complaints).toEqual([]);
  await page.close();
});

test('counts wrong pixels against rays, of which the file has fewer', async () => {
  const { page, complaints } = await open(`renderer=webgl&${SMALL}`);
  await page.getByRole('button', { name: 'View with truth' }).click();
  await expectStatus(page, /^Wrong pixels of 480 × 270/);
  const [file, stock] = (await page.locator('#read-wrong').textContent())!.split('|').map(Number.parseFloat);
  console.log(`wrong pixels of the demo's view: file ${file} %, three's default ${stock} %`);
  expect(file).toBeLessThan(1);
  expect(stock).toBeGreaterThan(2 * file!);
  expect(complaints).toEqual([]);
  await page.close();
});

/** Each takes minutes on a software renderer, so the others run only with `ADUMBRA_FULL`. */
const STREAMING = IS_FULL ? ['webgpu', 'webgl2', 'webgl'] : ['webgpu'];

test.each(STREAMING)('streams a city of 2 × 2 km with %s', async (renderer) => {
  ranges = 0;
  // Without motion, so that everything that this place needs arrives.
  const { page, complaints } = await open(`renderer=${renderer}&pixels=0.1&haze=150&budget=8&seconds=40`, { path: 'metropolis.html', reducedMotion: 'reduce' });
  const said = (name: string): Promise<string | null> => page.locator(`#read-${name}`).textContent();
  const numbers = async (name: string): Promise<number[]> => (await said(name))!.match(/[\d.]+/g)!.map(Number);
  expect(await page.locator('#renderer').inputValue()).toBe(renderer);
  await expect.poll(async () => (await numbers('missing'))[1], { timeout: 60_000 }).toBeGreaterThan(0);
  await expect.poll(async () => (await numbers('missing'))[0], { timeout: 60_000 }).toBe(0);
  expect(await colours(page)).toBeGreaterThan(20);
  const [fetchedMb, allMb] = await numbers('fetched');
  console.log(`metropolis, ${renderer}: ${await said('fetched')}, ${await said('requests')} requests; held ${await said('held')}; texels ${await said('texel')}; parts ${await said('levels')}`);
  expect(fetchedMb).toBeLessThan(allMb! / 2);
  expect((await numbers('requests'))[0]).toBe(ranges);
  const [held, budget] = await numbers('held');
  expect(held).toBeLessThanOrEqual(budget!);
  expect(budget).toBeLessThanOrEqual(8);

  expect(complaints).toEqual([]);
  await page.close();
});
