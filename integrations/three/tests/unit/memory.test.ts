// The memory that a file takes: it is known before the file is decoded, and lists of shapes take little more
// than their half-words.

import { expect, it } from 'vitest';

import { Layout } from '../../src/coder/layout.js';
import { NEVER_CHILD, NODE, Shapes, UNIFORM_CHILD } from '../../src/coder/shapes.js';
import { BakedShadowFile, ShadowFileError, ShadowFileLoader } from '../../src/index.js';
import { caught, validBytes, validNames } from './vectors.js';

/** Returns the bytes that a file needs, as its error says. */
function neededOf(bytes: Uint8Array): number {
  const error = caught(() => new BakedShadowFile(bytes, { limitBytes: 1 })) as ShadowFileError;
  expect(error).toBeInstanceOf(ShadowFileError);
  expect(error).toMatchObject({ kind: 'TooLarge', details: { limit: 1 } });
  return error.details['needed'] as number;
}

it.each(validNames())('%s is accepted within its limit, and refused one byte below', async (name) => {
  const bytes = validBytes(name);
  const needed = neededOf(bytes);
  expect(needed).toBeGreaterThan(bytes.length);
  expect(needed).toBeLessThan(600 * bytes.length);
  const file = new BakedShadowFile(bytes, { limitBytes: needed });
  expect(file).toEqual(new BakedShadowFile(bytes));
  expect(needed).toBeGreaterThan(bytes.length + file.code.byteLength + file.top.byteLength);
  await expect(BakedShadowFile.parseAsync(bytes, { limitBytes: needed - 1 })).rejects.toMatchObject({ kind: 'TooLarge' });
  const loader = new ShadowFileLoader();
  loader.limitBytes = needed - 1;
  expect(caught(() => loader.parse(bytes))).toMatchObject({ kind: 'TooLarge' });
});

it('a file that is too large is not decoded', () => {
  const bytes = validBytes('many_pages_coded_depths');
  const needed = neededOf(bytes);
  bytes[bytes.length - 1]! ^= 1;
  expect(caught(() => new BakedShadowFile(bytes, { limitBytes: needed - 1 }))).toMatchObject({ kind: 'TooLarge' });
  expect(caught(() => new BakedShadowFile(bytes, { limitBytes: needed }))).toMatchObject({ kind: 'SectionChecksum' });
});

/** Sixteen children: a shape and the difference of its base. */
const ALL = (shape: number, delta: number): Int32Array => Int32Array.from({ length: NODE }, (_, i) => (i % 2 === 0 ? shape : delta));

it.each([
  ['the smallest leaves', undefined],
  ['nodes that never switch', ALL(NEVER_CHILD, 0)],
  ['nodes that switch at their base', ALL(UNIFORM_CHILD, 0)],
  ['nodes that switch at other depths', ALL(UNIFORM_CHILD, 3)],
  ['nodes of leaves', ALL(0, 0)],
  ['nodes of leaves at far depths', ALL(0, 2 ** 17)],
] as const)('%s take at most 16 times their half-words', (_, children) => {
  const shapes = new Shapes();
  const pushLeaf = (): void => {
    shapes.reserveLeaf();
    // A single depth, slanted.
    shapes.halves.set([0x200, 1], shapes.halvesLength);
    shapes.pushLeaf(shapes.halvesLength + 2, 0, 0);
  };
  pushLeaf();
  // A little more than a power of two, so the lists are half empty.
  for (let n = 0; n < 4200; n++) {
    if (children === undefined) pushLeaf();
    else shapes.pushNode(5, children, 0, 0);
  }
  const { entries, halves, children: listed, levels } = shapes;
  const taken = [entries, halves, listed, ...levels].reduce((sum, array) => sum + array.byteLength, 0);
  const layout = new Layout(shapes, new Shapes(), undefined, 0, 2 ** 20, () => {
    throw new Error('too many half-words');
  });
  for (let shape = 0; shape < shapes.length; shape++) layout.writeShape(shape);
  const last = layout.addresses.at(-1)!;
  // Without the last shape.
  expect(taken + layout.addresses.byteLength).toBeLessThan(16 * 2 * last);
});
