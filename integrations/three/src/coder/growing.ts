// Typed arrays that grow.

/** Returns the array if it has `length` elements, else a copy that is at least twice as long. */
export function grown<A extends Int32Array<ArrayBuffer> | Uint16Array<ArrayBuffer>>(array: A, length: number): A {
  if (length <= array.length) return array;
  const longer = new (array.constructor as new (length: number) => A)(Math.max(length, 2 * array.length));
  longer.set(array);
  return longer;
}
