// A browser, and a server of the pages that it shows.

import { createReadStream, existsSync, statSync } from 'node:fs';
import { createServer } from 'node:http';
import type { IncomingMessage, Server, ServerResponse } from 'node:http';
import type { AddressInfo } from 'node:net';
import { extname, join, normalize } from 'node:path';
import { fileURLToPath } from 'node:url';

import { chromium } from 'playwright-core';
import type { Browser, Page } from 'playwright-core';

const ROOT = fileURLToPath(new URL('../..', import.meta.url));

const TYPES: Record<string, string> = {
  '.css': 'text/css',
  '.html': 'text/html',
  '.js': 'text/javascript',
  '.svg': 'image/svg+xml',
};

/**
 * The drivers that draw without a GPU, by `ADUMBRA_DRIVERS`:
 *
 * - Without it, SwiftShader, Chromium's own software renderer, which needs no display.
 * - `webgl`: the machine's OpenGL draws WebGL, and SwiftShader WebGPU.
 * - `opengl`: the machine's OpenGL draws both, WebGPU in its compatibility mode.
 */
const DRIVERS = {
  swiftshader: { angle: 'swiftshader', adapter: 'swiftshader' },
  webgl: { angle: 'gl', adapter: 'swiftshader' },
  opengl: { angle: 'gl', adapter: 'opengles' },
};

/** Returns the name of the drivers that the environment asks for. */
function driversAsked(): keyof typeof DRIVERS {
  const asked = process.env['ADUMBRA_DRIVERS'] ?? 'swiftshader';
  if (Object.hasOwn(DRIVERS, asked)) return asked as keyof typeof DRIVERS;
  throw new Error(`ADUMBRA_DRIVERS is ${asked}, but must be one of ${Object.keys(DRIVERS).join(', ')}`);
}

export const drivers = driversAsked();

/** Chromium's flags for WebGPU and WebGL2 without a GPU. */
const FLAGS = [
  '--no-sandbox',
  '--disable-quic',
  '--no-first-run',
  '--disable-background-networking',
  '--disable-component-update',
  '--disable-sync',
  '--enable-unsafe-webgpu',
  '--enable-features=Vulkan',
  '--use-vulkan=swiftshader',
  `--use-angle=${DRIVERS[drivers].angle}`,
  '--ignore-gpu-blocklist',
  `--use-webgpu-adapter=${DRIVERS[drivers].adapter}`,
  '--enable-unsafe-swiftshader',
];

/** Where Debian and others put the browser. */
const BROWSERS = ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'];

/** The versions of three that are tested, and their packages: the oldest for WebGLRenderer, the oldest for WebGPURenderer too. */
export const VERSIONS = { '0.166.0': 'three-166', '0.183.0': 'three-183', '0.187.0': 'three' } as const;

/** How often the browser is started before it is given up. Chromium sometimes crashes before its first page. */
const ATTEMPTS = 3;

/** Starts the browser. */
export async function launch(): Promise<Browser> {
  const executablePath = BROWSERS.find((path) => existsSync(path));
  if (executablePath === undefined) throw new Error('the browser tests need Chromium; Debian: apt-get install chromium');
  for (let attempt = 1; ; attempt++) {
    try {
      return await chromium.launch({ executablePath, args: FLAGS });
    } catch (error) {
      if (attempt === ATTEMPTS) throw error;
    }
  }
}

/** A browser with a server. */
export class Stage {
  readonly #server: Server;
  readonly #browser: Browser;

  private constructor(server: Server, browser: Browser) {
    this.#server = server;
    this.#browser = browser;
  }

  /** Starts both. `folder` is served below `/files/`. */
  static async start(folder: string): Promise<Stage> {
    const server = createServer((request, response) => {
      const path = decodeURIComponent(new URL(request.url ?? '/', 'http://localhost').pathname);
      const three = new URL(request.url ?? '/', 'http://localhost').searchParams.get('three') ?? 'three';
      if (path === '/page.html') {
        response.writeHead(200, { 'content-type': 'text/html' });
        response.end(page(three));
        return;
      }
      const file = path.startsWith('/files/') ? join(folder, normalize(path.slice(6))) : join(ROOT, normalize(path));
      if (!existsSync(file)) {
        response.writeHead(404);
        response.end();
        return;
      }
      send(request, response, file);
    });
    await new Promise<void>((ready) => server.listen(0, '127.0.0.1', ready));
    return new Stage(server, await launch());
  }

  /** The server's address. */
  get address(): string {
    return `http://127.0.0.1:${(this.#server.address() as AddressInfo).port}`;
  }

  /**
   * Opens a page of a version of three, with a script of `tests/browser/page` or of a path. Its errors and
   * warnings are collected in `complaints`.
   */
  async open(three: string, script: string): Promise<{ page: Page; complaints: string[] }> {
    const page = await this.#browser.newPage();
    page.setDefaultTimeout(300_000);
    const complaints: string[] = [];
    page.on('console', (message) => {
      if (['error', 'warning'].includes(message.type()) && !isOfTheMachine(message.text())) complaints.push(message.text());
    });
    page.on('pageerror', (error) => complaints.push(String(error)));
    await page.goto(`${this.address}/page.html?three=${three}&script=${script}`);
    await page.waitForFunction('window.isReady === true');
    return { page, complaints };
  }

  /** Ends both. */
  async stop(): Promise<void> {
    await this.#browser.close();
    await new Promise((done) => this.#server.close(done));
  }
}

/** Sends a file, or the range of it that was asked for, as static servers do. */
export function send(request: IncomingMessage, response: ServerResponse, file: string): void {
  const { size, mtimeMs } = statSync(file);
  const headers = { 'content-type': TYPES[extname(file)] ?? 'application/octet-stream', 'accept-ranges': 'bytes', etag: `"${size}-${mtimeMs}"` };
  const range = /^bytes=(\d+)-(\d+)$/.exec(request.headers.range ?? '');
  if (range === null) {
    response.writeHead(200, headers);
    createReadStream(file).pipe(response);
    return;
  }
  const [start, end] = [Number(range[1]), Math.min(Number(range[2]), size - 1)];
  response.writeHead(206, { ...headers, 'content-range': `bytes ${start}-${end}/${size}` });
  createReadStream(file, { start, end }).pipe(response);
}

/** Whether a message is about the machine, such as those of a software adapter. */
function isOfTheMachine(message: string): boolean {
  return ['GPU stall due to ReadPixels', 'software WebGL', 'SwiftShader', 'favicon.ico'].some((part) => message.includes(part));
}

function page(three: string): string {
  const imports = {
    three: `/node_modules/${three}/build/three.module.js`,
    'three/webgpu': `/node_modules/${three}/build/three.webgpu.js`,
    'three/tsl': `/node_modules/${three}/build/three.tsl.js`,
    'three/addons/': `/node_modules/${three}/examples/jsm/`,
    'adumbra-three': '/dist/index.js',
    ...Object.fromEntries(
      ['gltf', 'look-ups', 'path', 'stream', 'webgl', 'webgpu'].map((entry) => [`adumbra-three/${entry}`, `/dist/${entry}/index.js`]),
    ),
  };
  return `<!doctype html><link rel="icon" href="data:,"><script type="importmap">${JSON.stringify({ imports })}</script>
<script type="module">import(new URL(new URLSearchParams(location.search).get('script'), location.origin + '/tests/browser/page/'));</script>`;
}

/** Returns the path of a file of the package. */
export function packagePath(name: string): string {
  return join(ROOT, name);
}
