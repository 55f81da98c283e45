// Allocates the words of a pool to pages. A page goes into the smallest gap that holds it.

/** Pages begin at multiples of this many words. */
export const GRANULE_WORDS = 64;

/** A gap. */
interface Gap {
  at: number;
  words: number;
}

/** Returns a number of words rounded up to whole granules. */
export function inGranules(words: number): number {
  return Math.ceil(words / GRANULE_WORDS) * GRANULE_WORDS;
}

/** Allocates words of a range, and frees them. */
export class Allocator {
  /** The gaps in the order of their places. No two touch. */
  readonly #gaps: Gap[];
  #freeWords: number;

  /** Begins with all words from `from`, a multiple of {@link GRANULE_WORDS}, up to `to` free. */
  constructor(from: number, to: number) {
    const words = Math.floor((to - from) / GRANULE_WORDS) * GRANULE_WORDS;
    this.#freeWords = Math.max(words, 0);
    this.#gaps = words > 0 ? [{ at: from, words }] : [];
  }

  /** Number of words that are free, in whole granules. */
  get freeWords(): number {
    return this.#freeWords;
  }

  /** Allocates words, and returns their place, or `undefined` if no gap holds them. */
  allocate(words: number): number | undefined {
    const needed = inGranules(words);
    let best: Gap | undefined;
    for (const gap of this.#gaps) {
      if (gap.words >= needed && (best === undefined || gap.words < best.words)) best = gap;
    }
    if (best === undefined) return undefined;
    const { at } = best;
    best.at += needed;
    best.words -= needed;
    if (best.words === 0) this.#gaps.splice(this.#gaps.indexOf(best), 1);
    this.#freeWords -= needed;
    return at;
  }

  /** Frees words at a place that {@link Allocator.allocate} returned for the same number of words. */
  release(at: number, words: number): void {
    const gaps = this.#gaps;
    const given = inGranules(words);
    let next = 0;
    while (next < gaps.length && gaps[next]!.at < at) next++;
    const [before, after] = [gaps[next - 1], gaps[next]];
    const touchesBefore = before !== undefined && before.at + before.words === at;
    const touchesAfter = after !== undefined && at + given === after.at;
    if (touchesBefore) {
      before.words += given + (touchesAfter ? after.words : 0);
      if (touchesAfter) gaps.splice(next, 1);
    } else if (touchesAfter) {
      after.at = at;
      after.words += given;
    } else gaps.splice(next, 0, { at, words: given });
    this.#freeWords += given;
  }
}
