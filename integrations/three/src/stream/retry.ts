// When a request that failed is repeated.

/** When a part may be requested. */
export interface Waiting {
  /** How often it has failed since it last arrived. */
  failures: number;
  /** It is not requested before this time, milliseconds. */
  notBefore: number;
}

/** Notes that a part has failed at a time, which delays its next request. */
export function putOff(what: Waiting, now: number): void {
  what.failures += 1;
  what.notBefore = now + backoff(what.failures);
}

/** Lets a part be requested at once. */
export function putOffNoMore(what: Waiting): void {
  what.failures = 0;
  what.notBefore = -Infinity;
}

/**
 * Milliseconds until a part that has failed `failures` times in a row, at least once, is requested again:
 * 1 s, 2 s, 4 s, … at most 60 s.
 */
export function backoff(failures: number): number {
  return Math.min(1000 * 2 ** (failures - 1), 60_000);
}
