// Which bundles are in the pool: bundles that have arrived enter it, and others make room. If levels fade,
// bundles that enter or leave change their weight step by step, and a bundle that needs the room of a leaving
// one waits for it.

import { HEAD_WORDS } from '../file/table.js';
import { inGranules } from './allocator.js';
import type { Bundle } from './bundles.js';
import { tooSmall } from './layout.js';
import { WHOLE } from './pool.js';
import type { Entering, Pool } from './pool.js';

/** The bundles in a pool, and those on their way into it. */
export class Residency {
  readonly #pool: Pool;
  /** The bundles that may be given up. */
  readonly #comers: readonly Bundle[];
  /** The words of bundles that have arrived. */
  readonly #arrived = new Map<Bundle, Uint32Array>();
  /** A bundle some of whose pages are in the pool. */
  #entering: Entering | undefined;
  /** Bundles whose weight changes. */
  readonly #fading = new Set<Bundle>();
  /** The change of a weight per update. */
  readonly #step: number;
  #choice = 0;

  /**
   * Takes the bundles of all levels, the finest first, and the number of updates over which they fade. The
   * coarsest level is never given up.
   */
  constructor(pool: Pool, levels: readonly (readonly Bundle[])[], fadeFrames: number) {
    this.#pool = pool;
    this.#step = Math.ceil(WHOLE / Math.max(fadeFrames, 1));
    this.#comers = levels.slice(0, -1).flat().filter(hasBytes);
    for (const bundle of levels.flat()) {
      if (hasBytes(bundle)) continue;
      pool.showUniform(bundle);
      bundle.state = 'resident';
    }
  }

  /** The bundles that are loaded and given up. */
  get comers(): readonly Bundle[] {
    return this.#comers;
  }

  /** Number of bundles whose weight changes. */
  get fading(): number {
    return this.#fading.size;
  }

  /** Adds a bundle of the coarsest level, which stays. */
  settle(bundle: Bundle, words: Uint32Array): void {
    const entering = this.#pool.enter(bundle, words);
    const { length } = this.#pool.words;
    if (entering === undefined) throw tooSmall(4 * length, 4 * (length + bundle.words));
    this.#pool.copy(entering, Infinity);
    bundle.state = 'resident';
    bundle.words = wordsOf(words);
  }

  /** Queues a decoded bundle for the pool. */
  arrive(bundle: Bundle, words: Uint32Array): void {
    bundle.state = 'arrived';
    bundle.words = wordsOf(words);
    this.#arrived.set(bundle, words);
  }

  /**
   * Copies bundles that have arrived into the pool, up to about `words` words. `choice` is the number of the
   * last choice.
   */
  bringIn(words: number, choice: number): void {
    this.#choice = choice;
    this.#fade();
    let left = words;
    while (left > 0 && (this.#entering ??= this.#next()) !== undefined) {
      const { bundle } = this.#entering;
      const { words: copied, isDone } = this.#pool.copy(this.#entering, left);
      left -= copied;
      if (!isDone) continue;
      bundle.state = 'resident';
      this.#entering = undefined;
      if (this.#fades) this.#fading.add(bundle);
    }
  }

  get #fades(): boolean {
    return this.#step < WHOLE;
  }

  /** Changes all weights by a step. */
  #fade(): void {
    for (const bundle of this.#fading) {
      const weight = bundle.weight + (bundle.isLeaving ? -this.#step : this.#step);
      this.#pool.setWeight(bundle, Math.min(Math.max(weight, 0), WHOLE));
      if (bundle.isLeaving && bundle.weight === 0) this.#giveUp(bundle);
      else if (!bundle.isLeaving && bundle.weight === WHOLE) this.#fading.delete(bundle);
    }
  }

  /** Finds room for the most needed bundle that has arrived. Bundles without room are dropped. */
  #next(): Entering | undefined {
    const waiting = [...this.#arrived].sort(([a], [b]) => b.chosenAt - a.chosenAt || b.need - a.need);
    for (const [bundle, words] of waiting) {
      this.#arrived.delete(bundle);
      let entering = this.#pool.enter(bundle, words);
      while (entering === undefined && this.#makeRoom(bundle)) {
        if (this.#fades) {
          this.#arrived.set(bundle, words);
          return undefined;
        }
        entering = this.#pool.enter(bundle, words);
      }
      if (entering !== undefined) return entering;
      bundle.state = 'absent';
      bundle.blockedAt = this.#pool.givenUp;
    }
    return undefined;
  }

  /**
   * Makes bundles leave for another one, which may have room once they are gone. Returns false if all others
   * are needed more.
   */
  #makeRoom(forBundle: Bundle): boolean {
    if (!this.#isChosen(forBundle)) return false;
    let leaving = 0;
    for (const bundle of this.#fading) leaving += bundle.isLeaving ? bundle.words : 0;
    while (leaving === 0 || leaving + this.#pool.pageWords.free < forBundle.words) {
      const victim = this.#victim(forBundle);
      if (victim === undefined) break;
      leaving += victim.words;
      victim.isLeaving = true;
      this.#fading.add(victim);
      if (this.#fades) continue;
      this.#giveUp(victim);
      break;
    }
    return leaving > 0;
  }

  /** Returns the bundle that should leave first for another one, if any is needed less. */
  #victim(forBundle: Bundle): Bundle | undefined {
    let victim: Bundle | undefined;
    for (const bundle of this.#comers) {
      if (bundle.state !== 'resident' || bundle.isLeaving) continue;
      if (this.#isChosen(bundle) && bundle.need >= forBundle.need) continue;
      // Bundles that were chosen least recently leave first, and among these the least needed.
      if (victim === undefined || bundle.chosenAt < victim.chosenAt || (bundle.chosenAt === victim.chosenAt && bundle.need < victim.need)) victim = bundle;
    }
    return victim;
  }

  #isChosen(bundle: Bundle): boolean {
    return bundle.chosenAt === this.#choice;
  }

  #giveUp(bundle: Bundle): void {
    this.#pool.giveUp(bundle);
    bundle.state = 'absent';
    bundle.isLeaving = false;
    this.#fading.delete(bundle);
    // Although the bundle was chosen, there is no room for all chosen bundles.
    if (this.#isChosen(bundle)) bundle.blockedAt = this.#pool.givenUp;
  }
}

/** Whether a bundle has bytes in the file. The others are always resident. */
export function hasBytes({ entry }: Bundle): boolean {
  return entry.storedBytes > 0;
}

/** The words that the pages of a decoded bundle take in the pool. */
function wordsOf(words: Uint32Array): number {
  let sum = 0;
  for (let head = 2; head < HEAD_WORDS; head += 3) sum += inGranules(words[head]!);
  return sum;
}
