// When something that failed is asked for again.

/** When something is asked for. */
export interface Waiting {
  /** How often it has failed since it last came. */
  failures: number;
  /** It is not asked for before this time, milliseconds. */
  notBefore: number;
}

/** Notes that something has failed at a time, so that it is asked for again only later. */
export function putOff(what: Waiting, now: number): void {
  what.failures += 1;
  what.notBefore = now + backoff(what.failures);
}

/** Has something asked for at once. */
export function putOffNoMore(what: Waiting): void {
  what.failures = 0;
  what.notBefore = -Infinity;
}

/** Milliseconds until something that has failed so often in a row, at least once, is asked for again: 1 s, 2 s, 4 s, … at most 60 s. */
export function backoff(failures: number): number {
  return Math.min(1000 * 2 ** (failures - 1), 60_000);
}
