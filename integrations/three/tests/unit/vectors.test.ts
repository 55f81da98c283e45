// Every file of `test_vectors/`: the valid ones give their answers, the invalid ones their errors.

import { describe, expect, it } from 'vitest';

import { BakedShadowFile, Sampler, ShadowFileError } from '../../src/index.js';
import { VALID_FOLDERS, caught, expectedPoints, invalidNames, invalidVector, validBytes, validNames } from './vectors.js';

const POINT_ONLY = { constantTexels: 0, slopeTexels: 0, normalOffsetTexels: 0 };

describe.each(VALID_FOLDERS)('%s', (folder) => {
  it.each(validNames(folder))('%s gives its answers', (name) => {
    const bytes = validBytes(folder, name);
    const file = new BakedShadowFile(bytes);
    expect(file.version).toBe(bytes[8]);
    expect(file.byteLength).toBe(bytes.length);
    const sampler = new Sampler(file, { filter: 1, bias: POINT_ONLY });
    const points = expectedPoints(folder, name);
    expect(points.length).toBeGreaterThan(30);
    for (const { world, visibility, where } of points) {
      const [x, y, z] = world;
      expect(sampler.pointVisibility({ x, y, z }), where).toBe(visibility);
      expect(sampler.visibility({ x, y, z }), where).toBe(visibility);
    }
  });
});

it('the folders hold all versions and frames', () => {
  const kinds = new Set<string>();
  for (const folder of VALID_FOLDERS) {
    for (const name of validNames(folder)) {
      const { version, grid } = new BakedShadowFile(validBytes(folder, name));
      kinds.add(`${version} ${grid.frame}`);
    }
  }
  expect([...kinds].sort()).toEqual(['2 light', '3 light', '3 oblique']);
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
