// Which versions of three are taken.

import { afterEach, expect, it, vi } from 'vitest';

import { checkRevision } from '../../src/revision.js';

it.each(['186', '187', '187dev', '186.1'])('takes r%s', (revision) => {
  expect(() => checkRevision(revision)).not.toThrow();
});

it('takes the three that is installed', () => {
  expect(() => checkRevision()).not.toThrow();
});

it.each(['185', '188', '188dev', '1870', '', 'next'])('refuses r%s, and says what to install', (revision) => {
  expect(() => checkRevision(revision)).toThrow(
    `adumbra-three works with three 0.186 to 0.187, but found r${revision}; install three@0.187`,
  );
});

afterEach(() => {
  vi.doUnmock('three');
  vi.resetModules();
});

const ENTRIES = {
  '.': () => import('../../src/index.js'),
  './gltf': () => import('../../src/gltf/index.js'),
  './webgpu': () => import('../../src/webgpu/index.js'),
  './webgl': () => import('../../src/webgl/index.js'),
};

it.each(Object.entries(ENTRIES))('another three is refused at the import of %s', async (_, entry) => {
  vi.resetModules();
  vi.doMock('three', async (original) => ({ ...(await original<object>()), REVISION: '188' }));
  await expect(entry()).rejects.toThrow('three 0.186 to 0.187, but found r188');
});
