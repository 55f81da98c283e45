// The exports of the package, as Node and bundlers see them.

import { readFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';

import { expect, test } from 'vitest';

interface Package {
  exports: Record<string, string | Record<string, string>>;
}

const { exports } = JSON.parse(readFileSync(fileURLToPath(new URL('../../package.json', import.meta.url)), 'utf8')) as Package;

test('every entry is found under every condition, by `require` too', () => {
  expect(Object.keys(exports)).toEqual(['.', './webgpu', './webgl', './gltf', './look-ups', './stream', './path', './package.json']);
  const { './package.json': itself, ...entries } = exports;
  expect(itself).toBe('./package.json');
  for (const [name, conditions] of Object.entries(entries)) {
    const folder = name === '.' ? '' : `${name.slice(2)}/`;
    // Types come first, as TypeScript wants it, and `default` comes last.
    expect(Object.entries(conditions)).toEqual([
      ['types', `./dist/${folder}index.d.ts`],
      ['default', `./dist/${folder}index.js`],
    ]);
  }
});
