// The words that look-ups read: tables, common sections, and the pages that are resident.
// `spec/streaming.md`, "The pool".

import { HEAD_WORDS } from '../file/table.js';
import { halvesOf } from '../quadtree/bits.js';
import { UNIFORM } from '../quadtree/leaf.js';
import { childrenOf, descend } from '../quadtree/node.js';
import type { Children } from '../quadtree/node.js';
import { BUNDLE_PAGES, BUNDLE_SIDE, PAGE_LEVEL } from '../quadtree/pages.js';
import { addressOf, forEachBlock } from '../quadtree/top.js';
import { Allocator } from './allocator.js';
import type { Bundle, PlacedPage } from './bundles.js';
import type { LevelPlace, PoolLayout } from './layout.js';

/** In place of the address of a block whose page is not resident. */
export const ABSENT = 0xfffffffe;
/** The weight of a page that answers alone. With less, the next coarser level has the remaining share. */
export const WHOLE = 256;

/** A bundle whose words are on their way into the pool. */
export interface Entering {
  readonly bundle: Bundle;
  /** The bundle as it was decoded. */
  readonly words: Uint32Array;
  /** Its pages in the pool. */
  readonly pages: readonly PlacedPage[];
  /** The next page to copy, and its first word in `words`. */
  page: number;
  from: number;
}

/** The words of a pool, and their state. */
export class Pool {
  /** All words, row by row of a texture. */
  readonly words: Uint32Array<ArrayBuffer>;
  readonly layout: PoolLayout;
  readonly #allocator: Allocator;
  /** The reader of nodes of each level in use. */
  readonly #children: readonly Children[];
  /** Of each row of the texture, the revision that changed it last. */
  readonly #changes: Uint32Array;
  #revision = 1;
  #givenUp = 0;

  /** Makes a pool without pages. */
  constructor(layout: PoolLayout) {
    const { width, height, levels, pagesAt } = layout;
    this.layout = layout;
    this.words = new Uint32Array(width * height);
    this.#allocator = new Allocator(pagesAt, this.words.length);
    this.#children = levels.map(({ commonAt }) => childrenOf(halvesOf(this.words.subarray(commonAt))));
    this.#changes = new Uint32Array(height);
    for (const { tableAt, topDims } of levels) {
      for (let i = 0; i < topDims[0] * topDims[1]; i++) this.words[tableAt + 2 * i] = ABSENT;
    }
    this.#touch(0, pagesAt);
  }

  /** Counts up with each change. */
  get revision(): number {
    return this.#revision;
  }

  /** How many bundles were given up. */
  get givenUp(): number {
    return this.#givenUp;
  }

  /** Number of words that pages can take, and how many of them are free. */
  get pageWords(): { readonly all: number; readonly free: number } {
    return { all: this.words.length - this.layout.pagesAt, free: this.#allocator.freeWords };
  }

  /** Visits the rows that have changed since a revision, as ranges from one row up to another. */
  forEachChange(since: number, visit: (from: number, to: number) => void): void {
    const { height } = this.layout;
    for (let row = 0; row < height; row++) {
      if (this.#changes[row]! <= since) continue;
      const from = row;
      while (row < height && this.#changes[row]! > since) row++;
      visit(from, row);
    }
  }

  /** Writes the common section of a level in use. */
  setCommon({ commonAt }: LevelPlace, words: Uint32Array): void {
    this.#write(commonAt, words);
  }

  /** Finds room for a bundle that was decoded. Returns `undefined` if the pool has no room. */
  enter(bundle: Bundle, words: Uint32Array): Entering | undefined {
    const pages: PlacedPage[] = [];
    for (let head = 0; head < HEAD_WORDS; head += 3) {
      const count = words[head + 2]!;
      const at = count === 0 ? 0 : this.#allocator.allocate(count);
      if (at === undefined) {
        this.#release(pages);
        return undefined;
      }
      pages.push({ at, words: count });
    }
    return { bundle, words, pages, page: 0, from: HEAD_WORDS };
  }

  /**
   * Copies pages of a bundle, at least one, until all are copied or `budget` words are used up. Look-ups read
   * the bundle once all are copied. Returns the number of copied words, and whether all pages are copied.
   */
  copy(entering: Entering, budget: number): { readonly words: number; readonly isDone: boolean } {
    const { words, pages } = entering;
    let copied = 0;
    while (entering.page < BUNDLE_PAGES && copied < Math.max(budget, 1)) {
      const { at, words: count } = pages[entering.page]!;
      if (count > 0) this.#write(at, words.subarray(entering.from, entering.from + count));
      entering.from += count;
      entering.page += 1;
      copied += count;
    }
    const isDone = entering.page === BUNDLE_PAGES;
    if (isDone) this.#show(entering);
    return { words: copied, isDone };
  }

  /** Lets look-ups read a bundle without bytes, all of whose columns switch at one depth. */
  showUniform(bundle: Bundle): void {
    this.#setBlocks(bundle, () => () => [UNIFORM, bundle.entry.range[0]]);
    this.setWeight(bundle, WHOLE);
  }

  /** Sets the weight of all pages of a bundle, if its level fades. */
  setWeight(bundle: Bundle, weight: number): void {
    const { weightsAt, pageDims: [across, down] } = this.layout.levels[bundle.rank]!;
    bundle.weight = weight;
    if (weightsAt === undefined) return;
    this.#revision += 1;
    const [x, y] = [BUNDLE_SIDE * bundle.x, BUNDLE_SIDE * bundle.y];
    const columns = Math.min(BUNDLE_SIDE, across - x);
    for (let row = y; row < Math.min(y + BUNDLE_SIDE, down); row++) {
      const at = weightsAt + row * across + x;
      this.words.fill(weight, at, at + columns);
      this.#touch(at, columns);
    }
  }

  /** Removes a bundle from look-ups, and frees its words. */
  giveUp(bundle: Bundle): void {
    this.#setBlocks(bundle, () => () => [ABSENT, 0]);
    this.#release(bundle.pages);
    bundle.pages = [];
    this.#givenUp += 1;
  }

  #show({ bundle, words, pages }: Entering): void {
    const { commonAt, rootLevel } = this.layout.levels[bundle.rank]!;
    const children = this.#children[bundle.rank]!;
    bundle.pages = pages;
    this.#setBlocks(bundle, (slot) => {
      const root = words[3 * slot]!;
      const top = [addressOf({ root, firstWord: pages[slot]!.at - commonAt }), words[3 * slot + 1]!] as const;
      return (x, y) => descend(children, top, PAGE_LEVEL, rootLevel, x, y);
    });
  }

  /** Writes the blocks of all pages of a bundle: address and base of the block that begins at a column. */
  #setBlocks({ rank, x, y }: Bundle, ofPage: (slot: number) => (column: number, row: number) => readonly [number, number]): void {
    const { tableAt, rootLevel, topDims } = this.layout.levels[rank]!;
    this.#revision += 1;
    for (let slot = 0; slot < BUNDLE_PAGES; slot++) {
      const blockOf = ofPage(slot);
      const [pageX, pageY] = [BUNDLE_SIDE * x + (slot % BUNDLE_SIDE), BUNDLE_SIDE * y + Math.floor(slot / BUNDLE_SIDE)];
      forEachBlock(rootLevel, topDims, pageX, pageY, (column, row, at) => {
        this.words.set(blockOf(column, row), tableAt + at);
        this.#touch(tableAt + at, 2);
      });
    }
  }

  #release(pages: readonly PlacedPage[]): void {
    for (const { at, words } of pages) if (words > 0) this.#allocator.release(at, words);
  }

  #write(at: number, words: Uint32Array): void {
    this.words.set(words, at);
    this.#revision += 1;
    this.#touch(at, words.length);
  }

  #touch(at: number, count: number): void {
    const { width } = this.layout;
    for (let row = Math.floor(at / width); row * width < at + count; row++) this.#changes[row] = this.#revision;
  }
}
