// Reading of the fields of the header and of directory entries.

import { hex } from '../error.js';
import type { Vec3 } from '../grid/vec3.js';
import { check } from './faults.js';

/** A part of the file that consists of fields, which are at words counted from the beginning of the part. */
export class Fields {
  readonly #view: DataView;
  readonly #of: string;

  /** Takes the fields in `bytes`. `of` follows the number of a reserved word in messages. */
  constructor(bytes: Uint8Array, of = '') {
    this.#view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    this.#of = of;
  }

  u32(word: number): number {
    return this.#view.getUint32(4 * word, true);
  }

  u32s(word: number): Vec3 {
    return [this.u32(word), this.u32(word + 1), this.u32(word + 2)];
  }

  /** Returns a number of 64 bits, rounded above 2^53. */
  u64(word: number): number {
    return Number(this.#view.getBigUint64(4 * word, true));
  }

  f64(word: number): number {
    return this.#view.getFloat64(4 * word, true);
  }

  f64s(word: number): Vec3 {
    return [this.f64(word), this.f64(word + 2), this.f64(word + 4)];
  }

  /** Returns whether all bits from a word up to another are 0. */
  isZero(from: number, to: number): boolean {
    for (let word = from; word < to; word++) if (this.u32(word) !== 0) return false;
    return true;
  }

  /** Checks that the reserved words from one up to another are 0. */
  reserved(from: number, to = from + 1): void {
    for (let word = from; word < to; word++) check(this.isZero(word, word + 1), `reserved word ${word}${this.#of}`, hex(this.u32(word)), 0);
  }
}
