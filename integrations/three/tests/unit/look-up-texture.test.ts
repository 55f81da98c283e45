// The look-up texture equals that of the Rust crate, whose headers and checksums are in `tests/golden/`, in
// every bit.

import { readFileSync } from 'node:fs';

import { describe, expect, it } from 'vitest';

import { HEADER_WORDS } from '../../src/gpu/look-up-header.js';
import { BakedShadowFile, LookUpTexture, ShadowFileError } from '../../src/index.js';
import type { FilterWidth, GpuLookUpOptions } from '../../src/index.js';
import { crc32 } from '../../src/file/crc32.js';
import { textureSize } from '../../src/gpu/look-up-texture.js';
import { caught, validBytes } from './vectors.js';

interface Golden {
  readonly size: [number, number];
  readonly checksum: number;
  readonly headers: number[][];
}

const GOLDEN = JSON.parse(
  readFileSync(new URL('../golden/look_up_texture.json', import.meta.url), 'utf8'),
) as Record<string, Golden[]>;
/** The levels of all files. */
const LEVELS = Object.entries(GOLDEN).flatMap(([path, levels]) =>
  levels.map((golden, level) => ({ name: path.replace(/^valid\/|\.adumbra$/g, ''), level, golden })),
);

/** The settings for which the golden headers were made. */
const OPTIONS: GpuLookUpOptions[] = [
  { filter: 5 },
  { filter: 9, bias: { constantTexels: 0.7, slopeTexels: 1.3, normalOffsetTexels: 0.1 } },
  {
    filter: 1,
    bias: { constantTexels: 0.7, slopeTexels: 1.3, normalOffsetTexels: 0.1 },
    penumbra: { sunDegrees: 0.53, maxRadiusTexels: 20.5 },
  },
  { filter: 5, placement: [0, 0, -0.5, 0, 0, 0.5, 0, 0, 0.5, 0, 0, 0, 12.5, -3, 40.25, 1] },
  { filter: 5, placement: [4.8, 6.4, 0, 0, -6.4, 4.8, 0, 0, 0, 0, 8, 0, -7, 0.25, 1e5, 1] },
];

function vector(name: string, level = 0): BakedShadowFile {
  return new BakedShadowFile(validBytes(name)).level(level)!;
}

it('all levels are compared', () => {
  for (const [path, levels] of Object.entries(GOLDEN)) {
    expect(vector(path.replace(/^valid\/|\.adumbra$/g, '')).levelCount).toBe(levels.length);
  }
});

describe.each(LEVELS)('$name, level $level', ({ name, level, golden: { size, checksum, headers } }) => {
  it('equals the texture of the Rust crate', () => {
    const file = vector(name, level);
    const texture = new LookUpTexture(file, 4096, OPTIONS[0]);
    expect([texture.width, texture.height]).toEqual(size);
    expect(crc32(new Uint8Array(texture.words.buffer))).toBe(checksum);
    headers.forEach((header, i) => {
      texture.setLookUp(OPTIONS[i]);
      expect([...texture.header], `header ${i}`).toEqual(header);
    });
    expect(headers).toHaveLength(OPTIONS.length);
    texture.setLookUp(OPTIONS[0]);
    expect([...texture.header]).toEqual(headers[0]);
  });

  it('has the words of the file and zeros after them', () => {
    const file = vector(name, level);
    const { words } = new LookUpTexture(file, 4096, OPTIONS[0]);
    const all = [...file.top, ...file.code];
    expect(words[3]).toBe(all.length);
    expect([...words.subarray(HEADER_WORDS, HEADER_WORDS + all.length)]).toEqual(all);
    expect(words.subarray(HEADER_WORDS + all.length).every((word) => word === 0)).toBe(true);
  });
});

it('is as square as powers of two allow', () => {
  const size = (texels: number, maxSide: number) => textureSize(texels - HEADER_WORDS, maxSide);
  expect(size(129, 4096)).toEqual([128, 2]);
  expect(size(128 * 128 + 1, 4096)).toEqual([256, 65]);
  expect(size(2 ** 24, 4096)).toEqual([4096, 4096]);
  // A largest side that is not a power of two is used in full by the rows.
  expect(size(4000 * 2048, 4000)).toEqual([2048, 4000]);
  expect(size(32_128, 8192)).toEqual([256, 126]);
});

it.each([
  [2 ** 24 + 1, 4096],
  [4000 * 2048 + 1, 4000],
  [129, 100],
])('%i texels do not fit a side of %i', (texels, maxSide) => {
  const error = caught(() => textureSize(texels - HEADER_WORDS, maxSide));
  expect(error).toBeInstanceOf(ShadowFileError);
  expect(error).toMatchObject({ kind: 'TooLarge', details: { texels, maxSide } });
});

it('a grid that is too large for the arithmetic of shaders is refused', () => {
  const file = vector('cliff_depths');
  const grid = { ...file.grid, size: [16, 1, 516_097] as const };
  const tall = Object.create(file, { grid: { value: grid } }) as BakedShadowFile;
  expect(caught(() => new LookUpTexture(tall, 4096, { filter: 1 }))).toMatchObject({
    kind: 'TooLarge',
    details: { voxels: 516_097, limit: 516_096 },
  });
});

it.each([
  ['filter', { filter: 2 as FilterWidth }],
  ['bias', { filter: 1, bias: { constantTexels: 17, slopeTexels: 0, normalOffsetTexels: 0 } }],
  ['bias', { filter: 1, bias: { constantTexels: 0, slopeTexels: NaN, normalOffsetTexels: 0 } }],
  ['filter', { filter: 3, penumbra: { sunDegrees: 0.5, maxRadiusTexels: 8 } }],
  ['angular diameter', { filter: 1, penumbra: { sunDegrees: 21, maxRadiusTexels: 8 } }],
  ['radius', { filter: 1, penumbra: { sunDegrees: 0.5, maxRadiusTexels: 65 } }],
] satisfies [string, GpuLookUpOptions][])('refuses %s out of its range: %o', (name, options) => {
  const file = vector('sphere_depths');
  const error = caught(() => new LookUpTexture(file, 4096, options));
  expect(error).toBeInstanceOf(RangeError);
  expect((error as RangeError).message).toContain(name);
});
