// The parts of three that baked shadows need, and the versions that have them. Nothing is checked at import,
// so that a page with another version of three keeps working.

import { REVISION } from 'three';

import { warnOnce } from './warn.js';

/** The newest three that the tests ran with. */
const TESTED = 187;

/** The parts of three that baked shadows need, by name. A missing part is `undefined` or false. */
export type Hooks = Readonly<Record<string, unknown>>;

/** Something that baked shadows need is not in this version of three. The message says which version to install. */
export class MissingHookError extends Error {
  override readonly name = 'MissingHookError';
  /** The missing part. */
  declare readonly hook: string;
  /** The versions of three that have all parts, the oldest and the newest that is known. */
  declare readonly versions: readonly [oldest: string, newest: string];

  /** Creates an error. */
  constructor(hook: string, oldest: number, revision: string) {
    const versions = [`0.${oldest}`, `0.${TESTED}`] as const;
    super(`three r${revision} has no ${hook}, which three ${versions.join(' to ')} have; install one of them`);
    Object.assign(this, { hook, versions });
  }
}

/**
 * Warns once if three is newer than all that were tested.
 *
 * @throws MissingHookError if a hook is missing; `oldest` is the first revision with all of them.
 */
export function checkThree(oldest: number, hooks: Hooks, revision: string = REVISION): void {
  if (!(parseInt(revision, 10) <= TESTED)) {
    warnOnce(`tested with three up to 0.${TESTED}, but this is r${revision}; if shadows look wrong, install three@0.${TESTED}`, 'version');
  }
  for (const [hook, found] of Object.entries(hooks)) {
    if (!found) throw new MissingHookError(hook, oldest, revision);
  }
}
