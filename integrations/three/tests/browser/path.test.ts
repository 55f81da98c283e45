// Compares three's pictures at moments of a sun path with look-ups on the CPU, as keys come and go. A pixel
// may differ where a position in 32-bit floats falls into the next texel.

import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

import type { Page } from 'playwright-core';
import { afterAll, beforeAll, expect, test } from 'vitest';

import { crc32 } from '../../src/file/crc32.js';
import { parsePathHeader, parsePathTables } from '../../src/path/front.js';
import type { PathFront } from '../../src/path/front.js';
import type { SunPathStats } from '../../src/path/index.js';
import { Stage } from './stage.js';

let folder: string;
let stage: Stage;
let page: Page;
let complaints: string[];
let front: PathFront;

beforeAll(async () => {
  const program = process.env['ADUMBRA_BIN'];
  if (program === undefined) throw new Error('the browser tests need the program: ADUMBRA_BIN=…/adumbra');
  folder = mkdtempSync(join(tmpdir(), 'adumbra-path-'));
  const [scene, day] = [join(folder, 'city.glb'), join(folder, 'day.adumbra')];
  execFileSync(program, ['generate', 'city', '-o', scene]);
  execFileSync(program, ['bake', scene, '--sun-path', 'lat=20,lon=11,date=2026-03-20,from=10,to=11:30', '--resolution', '1024', '-o', day, '--progress', 'none']);
  const bytes = readFileSync(day);
  front = parsePathTables(bytes, parsePathHeader(bytes));
  writeFileSync(day, withGuesses(bytes, front));
  stage = await Stage.start(folder);
  ({ page, complaints } = await stage.open('three', 'path.js'));
});

afterAll(async () => {
  await stage?.stop();
  rmSync(folder, { recursive: true, force: true });
});

/** Makes rays dark that both keys hide for a voxel or more, so that guesses are not rare. */
function withGuesses(bytes: Buffer, { keys }: PathFront): Buffer {
  const [DARK_AFTER, CHECKSUM] = [4 * 39, 4 * 63];
  for (const { offset } of keys) {
    bytes.writeUInt32LE(1, offset + DARK_AFTER);
    bytes.writeUInt32LE(crc32(bytes.subarray(offset, offset + CHECKSUM)), offset + CHECKSUM);
  }
  return bytes;
}

/** The page's results for a moment. */
interface Drawn {
  found: string;
  expected: string;
  isActive: boolean;
  stats: SunPathStats;
}

const floats = (text: string): Float32Array => new Float32Array(new Uint8Array(Buffer.from(text, 'base64')).buffer);

test.each(['webgpu', 'webgl2', 'webgl'])('%s draws what the path answers', async (backend) => {
  const [first, second, third] = front.keys.map(({ seconds }) => seconds) as [number, number, number];
  const moments = [
    { seconds: 0.6 * second + 0.4 * third, waits: false },
    { seconds: 0.5 * first + 0.5 * second, waits: true },
    { seconds: 0.5 * second + 0.5 * third, waits: true },
    { seconds: third + 86_400, waits: true },
    { seconds: first, waits: true },
  ];
  const task = { backend, url: '/files/day.adumbra', moments, height: 1, width: 120, filter: 5 };
  const drawn = await page.evaluate((what) => (window as unknown as { draw(task: object): Promise<Drawn[]> }).draw(what), task);
  expect(drawn.map(({ stats }) => stats.isExact)).toEqual([false, true, true, true, true]);
  expect(drawn.map(({ stats }) => stats.answering.length)).toEqual([1, 2, 2, 0, 1]);
  drawn.forEach(({ found, expected, isActive }, i) => {
    const [a, b] = [floats(found), floats(expected)];
    let [off, most, shadowed] = [0, 0, 0];
    b.forEach((value, pixel) => {
      const difference = Math.abs(a[pixel]! - value);
      off += Number(!(difference <= 0.004));
      most = Math.max(most, Number.isNaN(difference) ? Infinity : difference);
      shadowed += Number(value < 0.5);
    });
    console.log(`${backend}, moment ${i}: ${off} of ${b.length} differ, by at most ${most.toFixed(3)}; ${shadowed} in shadow`);
    expect(isActive).toBe(true);
    expect(shadowed).toSatisfy((n: number) => (i === 3 ? n === b.length : n > b.length / 20 && n < (b.length * 19) / 20));
    expect({ off, most }).toSatisfy(() => off * 500 <= b.length && most <= 1 / 3 + 0.004);
  });
});

test('the console is silent', () => {
  expect(complaints).toEqual([]);
});
