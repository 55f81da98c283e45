// Writes shapes as half-words, each after the shapes that it points to, in the shortest form that holds it.
// Counterpart of `crates/adumbra/src/layout/depths/write.rs`, and of `Layout` in
// `crates/adumbra/src/coder/shapes.rs`.

import { popCount } from '../quadtree/bits.js';
import { UNIFORM, leafHead } from '../quadtree/leaf.js';
import { IN_PAGE } from '../quadtree/pages.js';
import { grown } from './growing.js';
import { UNIFORM_CHILD } from './shapes.js';
import type { Shapes } from './shapes.js';

/** Pointers of one half-word reach to this, and have this bit if they are relative. */
const NEAR = 2 ** 15;
/** Far pointers have this bit if they are relative. */
const FAR = 0x80000000 | 0;
/** Number of bits of a far pointer's address or distance. */
const FAR_BITS = 25;
/** In place of the address of a shape that was not written. */
const NOWHERE = -1;

/** Writes the shapes of a common section, or of the pages of a bundle. */
export class Layout {
  /** Address of each shape of the part, from its beginning. Addresses before the page are those of other pages. */
  readonly addresses: Int32Array;
  #halves = new Uint16Array(2 ** 12);
  #length: number;
  /** Where the page begins. */
  #begin = 0;
  readonly #common: Shapes;
  readonly #commonAddresses: Int32Array;
  readonly #isCommon: boolean;
  readonly #own: Shapes;
  readonly #most: number;
  readonly #fail: () => never;

  /**
   * Begins a part of up to `most` half-words, of which the first `head` are left free. `commonAddresses` are
   * those of the shapes in `common`; without them the part is a common section itself.
   */
  constructor(own: Shapes, common: Shapes, commonAddresses: Int32Array | undefined, head: number, most: number, fail: () => never) {
    this.#own = own;
    this.#common = common;
    this.#isCommon = commonAddresses === undefined;
    this.#commonAddresses = commonAddresses ?? new Int32Array(0);
    this.#length = head;
    this.#most = most;
    this.#fail = fail;
    this.addresses = new Int32Array(own.length).fill(NOWHERE);
  }

  /** Begins a page. */
  beginPage(): void {
    this.#begin = this.#length;
  }

  /**
   * Writes the shapes of the page in post-order, and a zero if their number of half-words is odd. Returns the
   * page's root.
   */
  writePage(root: number): number {
    if (root < 0) return UNIFORM;
    this.writeShape(root);
    this.#pad();
    const before = this.#common.length;
    return root < before ? this.#commonAddresses[root] : this.addresses[root - before] - this.#begin + IN_PAGE;
  }

  /** Number of words of the page. */
  get pageWords(): number {
    return (this.#length - this.#begin) / 2;
  }

  /** Returns all words. Fails unless there are as many as the part should have. */
  finish(): Uint32Array<ArrayBuffer> {
    this.#pad();
    if (this.#length !== this.#most) this.#fail();
    return new Uint32Array(this.#halves.slice(0, this.#length).buffer);
  }

  #pad(): void {
    if (this.#length % 2 === 0) return;
    this.#reserve(1);
    this.#put(0);
  }

  /** Writes a shape, after its children, unless it is already in the page or in the common section. */
  writeShape(shape: number): void {
    const index = shape - this.#common.length;
    if (index < 0 || this.addresses[index] >= this.#begin) return;
    const own = this.#own;
    const first = own.entries[3 * index + 1];
    if (own.entries[3 * index] === 0) {
      const [, , , , , planesAt, planes] = leafHead(own.halves[first]);
      const count = planesAt + 4 * planes;
      this.#reserve(count);
      this.addresses[index] = this.#length;
      for (let i = 0; i < count; i++) this.#put(own.halves[first + i]);
    } else {
      const head = own.entries[3 * index + 2];
      const end = first + 2 * popCount(head & 0xffff);
      for (let at = first; at < end; at += 2) if (own.children[at] >= 0) this.writeShape(own.children[at]);
      this.addresses[index] = this.#length;
      this.#writeNode(head, first);
    }
    if (this.#length > this.#most) this.#fail();
  }

  #writeNode(head: number, first: number): void {
    const { children } = this.#own;
    const at = this.#length;
    let child = first;
    let low = 0;
    let high = 0;
    let kind = 0;
    this.#reserve(3 + 3 * 16);
    this.#length += 3;
    for (let c = 0; c < 16; c++) {
      let form = (head >>> (16 + c)) & 1;
      if (((head >>> c) & 1) === 1) {
        const shape = children[child++];
        const delta = children[child++];
        form = shape === UNIFORM_CHILD ? this.#writeUniform(delta) : this.#writePointer(at, shape, delta);
      }
      high |= (form >> 2) << c;
      low |= ((form >> 1) & 1) << c;
      kind |= (form & 1) << c;
    }
    this.#halves[at] = low;
    this.#halves[at + 1] = high;
    this.#halves[at + 2] = kind;
  }

  /** Writes the difference of a uniform child, which is not 0. Returns its bits as 4 · high + 2 · low + kind. */
  #writeUniform(delta: number): number {
    if (!fits(delta, 16)) return this.#writeFar(delta, FAR);
    this.#put(delta);
    return 3;
  }

  /**
   * Writes the pointer from the node at `node` to a shape. Returns the child's bits as 4 · high + 2 · low +
   * kind.
   */
  #writePointer(node: number, shape: number, delta: number): number {
    const index = shape - this.#common.length;
    const isHere = index >= 0;
    /** Address in the common section, or {@link NOWHERE}. */
    const address = !isHere ? this.#commonAddresses[shape] : this.#isCommon ? this.addresses[index] : NOWHERE;
    /** Half-words back, or {@link NOWHERE}. */
    const back = isHere ? node - this.addresses[index] : NOWHERE;
    const isNear = address !== NOWHERE && address < NEAR;
    const isNearBack = back !== NOWHERE && back < NEAR;
    const near = isNear ? address : NEAR | back;
    if (delta === 0 && (isNear || isNearBack)) {
      this.#put(near);
      return 2;
    }
    if (back !== NOWHERE && back < 256 && fits(delta, 8)) {
      this.#put((delta << 8) | back);
      return 4;
    }
    if ((isNear || isNearBack) && fits(delta, 16)) {
      this.#put(delta);
      this.#put(near);
      return 5;
    }
    return this.#writeFar(delta, address !== NOWHERE ? address : FAR | back);
  }

  /** Writes a far pointer: an address, or {@link FAR} and a distance. */
  #writeFar(delta: number, pointer: number): number {
    if (!fits(delta, 22) || (pointer & ~FAR) >>> FAR_BITS !== 0) this.#fail();
    const word = pointer | (((delta >>> 16) << FAR_BITS) & ~FAR);
    this.#put(delta);
    this.#put(word);
    this.#put(word >>> 16);
    return 6;
  }

  /** Makes room for `count` half-words. */
  #reserve(count: number): void {
    this.#halves = grown(this.#halves, this.#length + count);
  }

  /** Writes the lowest half of a number. */
  #put(half: number): void {
    this.#halves[this.#length++] = half;
  }
}

/** Whether a difference fits `bits` bits in two's complement. */
function fits(delta: number, bits: number): boolean {
  return (delta << (32 - bits)) >> (32 - bits) === delta;
}
