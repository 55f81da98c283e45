// A common section, or the pages of a bundle, from coded bytes. Counterpart of
// `crates/adumbra/src/coder/part.rs`.

import { NEVER } from '../quadtree/leaf.js';
import { BUNDLE_PAGES } from '../quadtree/pages.js';
import { Layout } from './layout.js';
import { NEVER_CHILD, Shapes } from './shapes.js';
import { Walk } from './walk.js';

/** Number of words of a bundle before those of its pages. */
const HEAD_WORDS = 3 * BUNDLE_PAGES;

/**
 * Decodes the common section of a level, then its bundles. `fail` is called for bytes that no encoder wrote.
 * Work is done in steps of at most a page or a shape. Memory is proportional to the decoded words.
 */
export class PartDecoder {
  readonly #walk = new Walk();
  /** Address of each shape of the common section. */
  #addresses: Int32Array = new Int32Array(0);

  /** Decodes the common section, which has `words` words. */
  *common(stored: Uint8Array, words: number, fail: () => never): Generator<void, Uint32Array<ArrayBuffer>> {
    if (stored.length === 0) return new Uint32Array(0);
    const walk = this.#walk;
    walk.begin(halvesIn(stored, fail), 2 * words, fail);
    for (let left = walk.count(); left > 0; left--) {
      walk.shape();
      yield;
    }
    if (!walk.reader.isAtEnd(words)) fail();
    const layout = new Layout(walk.own, new Shapes(), undefined, 0, 2 * words, fail);
    for (let shape = 0; shape < walk.own.length; shape++) {
      layout.writeShape(shape);
      yield;
    }
    walk.keepCommon();
    this.#addresses = layout.addresses;
    return layout.finish();
  }

  /** Decodes a bundle, which has `words` words: three for each page, then the words of its pages. */
  *bundle(stored: Uint8Array, words: number, fail: () => never): Generator<void, Uint32Array<ArrayBuffer>> {
    const walk = this.#walk;
    walk.begin(halvesIn(stored, fail), 2 * (words - HEAD_WORDS), fail);
    const roots = new Int32Array(BUNDLE_PAGES);
    const heads = new Uint32Array(HEAD_WORDS);
    let base = 0;
    for (let page = 0; page < BUNDLE_PAGES; page++) {
      const [shape, delta] = walk.page(page, base);
      roots[page] = shape;
      if (shape !== NEVER_CHILD) base = (base + delta) | 0;
      heads[3 * page + 1] = shape === NEVER_CHILD ? NEVER : base;
      yield;
    }
    if (!walk.reader.isAtEnd(words - HEAD_WORDS)) fail();
    const layout = new Layout(walk.own, walk.common, this.#addresses, 2 * HEAD_WORDS, 2 * words, fail);
    for (let page = 0; page < BUNDLE_PAGES; page++) {
      layout.beginPage();
      heads[3 * page] = layout.writePage(roots[page]);
      heads[3 * page + 2] = layout.pageWords;
      yield;
    }
    const found = layout.finish();
    found.set(heads);
    return found;
  }
}

/** Returns bytes as half-words. */
function halvesIn(stored: Uint8Array, fail: () => never): Uint16Array<ArrayBuffer> {
  if (stored.length % 2 !== 0) fail();
  // Copy by the constructor: the method `slice` of Node's Buffer makes no copy.
  return new Uint16Array(new Uint8Array(stored).buffer);
}
