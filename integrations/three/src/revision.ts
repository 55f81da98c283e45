// The versions of three whose shaders this package fits.

import { REVISION } from 'three';

const FIRST = 186;
const LAST = 187;

/**
 * Checks the version of three.
 *
 * @throws Error if it is not one that this package was tested with.
 */
export function checkRevision(revision: string = REVISION): void {
  const number = Number.parseInt(revision, 10);
  if (!(number >= FIRST && number <= LAST)) {
    throw new Error(
      `adumbra-three works with three 0.${FIRST} to 0.${LAST}, but found r${revision}; ` +
        `install three@0.${LAST}, or the version of adumbra-three that is for yours`,
    );
  }
}
