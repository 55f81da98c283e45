// Every file of `test_vectors/`: the valid ones give their answers, the invalid ones their errors.

import { describe, expect, it } from 'vitest';

import { LATEST_VERSION } from '../../src/file/header.js';
import { BakedShadowFile, Sampler, ShadowFileError } from '../../src/index.js';
import { caught, expectedPoints, invalidNames, invalidVector, validBytes, validNames } from './vectors.js';

const POINT_ONLY = { constantTexels: 0, slopeTexels: 0, normalOffsetTexels: 0 };

describe('valid', () => {
  it.each(validNames())('%s gives its answers', (name) => {
    const bytes = validBytes(name);
    const file = new BakedShadowFile(bytes);
    expect(file.version).toBe(LATEST_VERSION);
    expect(file.byteLength).toBe(bytes.length);
    const sampler = new Sampler(file, { filter: 1, bias: POINT_ONLY });
    const points = expectedPoints(name);
    expect(points.length).toBeGreaterThan(30);
    for (const { world, visibility, where } of points) {
      const [x, y, z] = world;
      expect(sampler.pointVisibility({ x, y, z }), where).toBe(visibility);
      expect(sampler.visibility({ x, y, z }), where).toBe(visibility);
    }
  });

  it('has both frames, several pages and several levels', () => {
    const files = validNames().map((name) => new BakedShadowFile(validBytes(name)));
    expect(new Set(files.map(({ grid }) => grid.frame))).toEqual(new Set(['light', 'oblique']));
    expect(Math.max(...files.map(({ grid }) => grid.size[0]))).toBeGreaterThan(4 * 512);
    expect(Math.max(...files.map(({ levelCount }) => levelCount))).toBe(3);
  });
});

describe('invalid', () => {
  it.each(invalidNames())('%s gives its error', (name) => {
    const { bytes, expected } = invalidVector(name);
    const error = caught(() => new BakedShadowFile(bytes));
    expect(error).toBeInstanceOf(ShadowFileError);
    const { kind, fault, message } = error as ShadowFileError;
    expect({ error: kind, fault }, message).toEqual({ error: expected.error, fault: expected.fault });
    expect(message).toContain(expected.names);
    expect(message).toMatch(/bake|update/);
  });
});

it('a tree file is named as such', () => {
  const bytes = new TextEncoder().encode('ADUMTREE and more');
  expect(caught(() => new BakedShadowFile(bytes))).toMatchObject({ kind: 'OtherKind' });
});
