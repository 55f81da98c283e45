// The files of `test_vectors/` with their expected answers and faults, as `spec/adumbra-file.md` describes
// them.

import { readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

/** The folder `test_vectors`. */
export const VECTORS = fileURLToPath(new URL('../../../../test_vectors', import.meta.url));

/** A point with the answer that every reader must give. */
export interface ExpectedPoint {
  readonly world: [number, number, number];
  readonly visibility: 0 | 1;
  readonly where: string;
}

/** Reads a file into a separate buffer. */
export function readBytes(path: string): Uint8Array<ArrayBuffer> {
  return new Uint8Array(readFileSync(path));
}

/** Returns the names of the valid vectors, sorted, without `.adumbra`. */
export function validNames(): string[] {
  const files = readdirSync(join(VECTORS, 'valid')).filter((name) => name.endsWith('.adumbra'));
  return files.map((name) => name.slice(0, -'.adumbra'.length)).sort();
}

/** Returns the bytes of a valid vector. */
export function validBytes(name: string): Uint8Array<ArrayBuffer> {
  return readBytes(join(VECTORS, 'valid', `${name}.adumbra`));
}

/** Returns the points of a valid vector with their answers. */
export function expectedPoints(name: string): ExpectedPoint[] {
  const text = readFileSync(join(VECTORS, 'valid', `${name}.json`), 'utf8');
  return (JSON.parse(text) as { points: ExpectedPoint[] }).points;
}

/** Returns the names of the invalid vectors, sorted. */
export function invalidNames(): string[] {
  return readdirSync(join(VECTORS, 'invalid')).sort();
}

/** Returns the bytes of an invalid vector and the error that it must cause. */
export function invalidVector(name: string): {
  bytes: Uint8Array<ArrayBuffer>;
  expected: { error: string; fault?: string; names: string };
} {
  const folder = join(VECTORS, 'invalid', name);
  return {
    bytes: readBytes(join(folder, 'file.adumbra')),
    expected: JSON.parse(readFileSync(join(folder, 'expected.json'), 'utf8')) as {
      error: string;
      fault?: string;
      names: string;
    },
  };
}

/** Returns the error that `action` throws, which must be a {@link ShadowFileError}. */
export function caught(action: () => unknown): unknown {
  try {
    action();
  } catch (error) {
    return error;
  }
  throw new Error('nothing was thrown');
}

/** A deterministic source of numbers from 0 to 1: mulberry32. */
export function scatter(seed: number): () => number {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let t = Math.imul(state ^ (state >>> 15), state | 1);
    t ^= t + Math.imul(t ^ (t >>> 7), t | 61);
    return ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
  };
}
