// Which bundles are requested together.

import type { Bundle } from './bundles.js';

/** The most bytes of a request of several bundles. */
export const MAX_RUN_BYTES = 256 * 1024;
/** The most requests that are under way at a time. */
export const MAX_REQUESTS = 6;

/**
 * Returns the run of bundles around one in the order of the file, of at most {@link MAX_RUN_BYTES} if there
 * are several. `level` are all bundles of its level. A run ends at the first neighbour that `isWanted`
 * refuses. Bundles without bytes are skipped.
 */
export function runAround(bundle: Bundle, level: readonly Bundle[], isWanted: (bundle: Bundle) => boolean): Bundle[] {
  const run = [bundle];
  let bytes = bundle.entry.storedBytes;
  for (const step of [1, -1]) {
    for (let i = bundle.index + step; i >= 0 && i < level.length; i += step) {
      const next = level[i]!;
      const { storedBytes } = next.entry;
      if (storedBytes === 0) continue;
      if (!isWanted(next) || bytes + storedBytes > MAX_RUN_BYTES) break;
      bytes += storedBytes;
      if (step > 0) run.push(next);
      else run.unshift(next);
    }
  }
  return run;
}
