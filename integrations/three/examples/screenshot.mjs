// Takes a picture of a built page, in a browser without a window: node screenshot.mjs FOLDER PNG [WIDTHxHEIGHT]

import { createReadStream, existsSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { extname, join, normalize } from 'node:path';

import { chromium } from 'playwright-core';

const [folder, picture, size = '640x360'] = process.argv.slice(2);
if (picture === undefined) {
  console.error('usage: node screenshot.mjs FOLDER PNG [WIDTHxHEIGHT]');
  process.exit(2);
}
const [width, height] = size.split('x').map(Number);
const types = { '.css': 'text/css', '.html': 'text/html', '.js': 'text/javascript', '.svg': 'image/svg+xml' };

const server = createServer((request, response) => {
  const path = normalize(decodeURIComponent(new URL(request.url, 'http://localhost').pathname));
  const file = join(folder, path === '/' ? 'index.html' : path);
  const compressed = existsSync(`${file}.br`) ? { 'content-encoding': 'br' } : {};
  if (!existsSync(file)) {
    response.writeHead(404).end();
    return;
  }
  response.writeHead(200, { 'content-type': types[extname(file)] ?? 'application/octet-stream', ...compressed });
  createReadStream('content-encoding' in compressed ? `${file}.br` : file).pipe(response);
});
await new Promise((ready) => server.listen(0, '127.0.0.1', ready));

const executablePath = ['/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome'].find(existsSync);
const args = [
  '--no-sandbox',
  '--disable-quic',
  '--no-first-run',
  '--disable-background-networking',
  '--disable-component-update',
  '--disable-sync',
  '--enable-unsafe-webgpu',
  '--enable-features=Vulkan',
  '--use-vulkan=swiftshader',
  '--use-angle=swiftshader',
  '--use-webgpu-adapter=swiftshader',
  '--enable-unsafe-swiftshader',
];
const browser = await chromium.launch({ executablePath, args });
const page = await browser.newPage({ viewport: { width, height } });
page.on('pageerror', (error) => fail(`the page failed: ${error}`));
await page.goto(`http://127.0.0.1:${server.address().port}/`);
await page.waitForSelector('canvas', { timeout: 60_000 });

// A picture with a scene takes far more bytes than a single colour.
let bytes = await page.screenshot({ timeout: 120_000 });
for (const start = Date.now(); bytes.length < (width * height) / 10; bytes = await page.screenshot({ timeout: 120_000 })) {
  if (Date.now() - start > 600_000) fail('the page has drawn nothing after ten minutes');
  await new Promise((done) => setTimeout(done, 1000));
}
writeFileSync(picture, bytes);
await browser.close();
server.close();

function fail(message) {
  console.error(message);
  process.exit(1);
}
