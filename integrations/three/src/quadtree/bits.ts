// Operations on the bits of 32-bit words.

/** Returns the number of bits that are 1. */
export function popCount(word: number): number {
  let n = word - ((word >>> 1) & 0x55555555);
  n = (n & 0x33333333) + ((n >>> 2) & 0x33333333);
  return Math.imul((n + (n >>> 4)) & 0x0f0f0f0f, 0x01010101) >>> 24;
}

/** Returns a word whose lowest `count` bits are 1; `count` is 0 to 31. */
export function bitsBelow(count: number): number {
  return (1 << count) - 1;
}

/** Returns the number of binary digits of a number: 0 for 0, 3 for 4 to 7. */
export function digits(n: number): number {
  return 32 - Math.clz32(n);
}

/** Returns the index of the lowest bit that is 1, 0 to 31; −1 if there is none. */
export function lowestBit(word: number): number {
  return digits(word & -word) - 1;
}

/** Returns words as half-words, the lower one of each first. */
export function halvesOf(words: Uint32Array): Uint16Array {
  return new Uint16Array(words.buffer, words.byteOffset, 2 * words.length);
}

/** Returns the word that two half-words make, the lower one first. */
export function twoHalves(halves: Uint16Array, at: number): number {
  return (halves[at] | (halves[at + 1] << 16)) >>> 0;
}
