// Which versions of three are taken.

import { expect, it } from 'vitest';

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
