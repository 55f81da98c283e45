import { crc32 as zlibCrc32 } from 'node:zlib';

import { expect, it } from 'vitest';

import { crc32 } from '../../src/file/crc32.js';
import { scatter } from './vectors.js';

it('gives the check value of the specification', () => {
  expect(crc32(new TextEncoder().encode('123456789'))).toBe(0xcbf43926);
  expect(crc32(new Uint8Array(0))).toBe(0);
});

it('takes bytes of any length at any offset in their buffer', () => {
  const random = scatter(1);
  const bytes = Uint8Array.from({ length: 300 }, () => 256 * random());
  for (let from = 0; from < 9; from++) {
    for (let to = from; to < bytes.length; to++) {
      const part = bytes.subarray(from, to);
      expect(crc32(part)).toBe(zlibCrc32(part));
    }
  }
});
