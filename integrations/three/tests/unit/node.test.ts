// The children of nodes, in each form that a node can give them.

import { expect, it } from 'vitest';

import { NEVER, UNIFORM } from '../../src/quadtree/leaf.js';
import { childrenOf, descend, fieldsLength } from '../../src/quadtree/node.js';
import type { Child } from '../../src/quadtree/node.js';

/** Address of the node. */
const NODE = 500;

/** A form: its bits, its fields, and the child that it stands for. */
const FORMS: [name: string, high: number, low: number, kind: number, fields: number[], child: Partial<Child>][] = [
  ['base', 0, 0, 0, [], { at: UNIFORM, delta: 0, isNever: false }],
  ['never', 0, 0, 1, [], { at: UNIFORM, isNever: true }],
  ['near in the common section', 0, 1, 0, [0x7fff], { at: 0x7fff, delta: 0, isRelative: false }],
  ['near in the part', 0, 1, 0, [0x8000 + 20], { at: NODE - 20, delta: 0, isRelative: true }],
  ['delta', 0, 1, 1, [0xfffe], { at: UNIFORM, delta: -2, isNever: false }],
  ['short', 1, 0, 0, [0x7f01], { at: NODE - 1, delta: 127, isRelative: true }],
  ['short with a delta below 0', 1, 0, 0, [0x80ff], { at: NODE - 255, delta: -128, isRelative: true }],
  ['delta and near', 1, 0, 1, [0x8000, 0x8003], { at: NODE - 3, delta: -32768, isRelative: true }],
  ['far in the common section', 1, 1, 0, [5, 0x6789, 0x0123], { at: 0x1236789, delta: 5, isRelative: false }],
  ['far in the part', 1, 1, 0, [0xffff, 300, 0x8000 + (0x1f << 9)], { at: NODE - 300, delta: 2 ** 21 - 1, isRelative: true }],
  ['far with a delta below 0', 1, 1, 0, [0, 7, 0x20 << 9], { at: 7, delta: -(2 ** 21), isRelative: false }],
  ['far without a shape', 1, 1, 0, [1, 0, 0x8000 + (0x3f << 9)], { at: UNIFORM, delta: -65535, isNever: false }],
];

/** Returns a code in which the node's children have these forms, the other ones the first. */
function codeOf(forms: typeof FORMS): Uint16Array {
  const code = new Uint16Array(NODE + 64);
  const bits = (index: 1 | 2 | 3): number => forms.reduce((all, form, child) => all | (form[index] << child), 0);
  code.set([bits(2), bits(1), bits(3), ...forms.flatMap(([, , , , fields]) => fields)], NODE);
  return code;
}

it.each(FORMS.map((form, index) => [form[0], index] as const))('%s', (_, index) => {
  // After the fields of all earlier children.
  expect(childrenOf(codeOf(FORMS))(NODE, index)).toMatchObject(FORMS[index]![5]);
  // The form may also be that of the last of sixteen children.
  const last = [...Array(15).fill(FORMS[0]), FORMS[index]!] as typeof FORMS;
  expect(childrenOf(codeOf(last))(NODE, 15)).toMatchObject(FORMS[index]![5]);
});

it('fieldsLength is the sum of the fields of the children', () => {
  const code = codeOf(FORMS);
  const [low, high, kind] = code.subarray(NODE) as unknown as [number, number, number];
  FORMS.forEach((_, child) => {
    const before = FORMS.slice(0, child).flatMap(([, , , , fields]) => fields).length;
    expect(fieldsLength(low, high, kind, (1 << child) - 1)).toBe(before);
  });
});

it('descend ends at blocks without a shape; bases wrap at 2^32', () => {
  const children = childrenOf(codeOf(FORMS));
  const index = (name: string): number => FORMS.findIndex(([form]) => form === name);
  const towards = (name: string): [number, number] => descend(children, [NODE, 1], 5, 3, 8 * (index(name) & 3), 8 * (index(name) >> 2));
  expect(towards('delta')).toEqual([UNIFORM, 2 ** 32 - 1]);
  expect(towards('base')).toEqual([UNIFORM, 1]);
  expect(towards('never')).toEqual([UNIFORM, NEVER]);
  expect(towards('short')).toEqual([NODE - 1, 128]);
});
