// Which of the keys in memory answer at a moment, and how.

import type { BakedShadowFile } from '../file/shadow-file.js';
import type { Vec3 } from '../grid/vec3.js';
import { marchSlope } from './slope.js';
import type { MarchSlope } from './slope.js';
import { keysAt, sunAt } from './sun.js';
import type { Course } from './sun.js';

/** A key that answers. */
export interface AnsweringKey {
  /** Its number in the path. */
  readonly key: number;
  readonly file: BakedShadowFile;
  /** The slope towards the sun in its grid. */
  readonly slope: MarchSlope;
}

/** The keys that answer at a moment. */
export interface Answering {
  readonly towardsSun: Vec3;
  /** One key, or two: the second is looked up where the first has no answer. */
  readonly parts: readonly [AnsweringKey, ...AnsweringKey[]];
  /**
   * Whether these are the keys of the moment. Otherwise not all of those are in memory, and others stand in
   * for them.
   */
  readonly isExact: boolean;
}

/**
 * Returns the keys that answer at a moment: the keys of the moment; if only one of them is resident, that
 * key; if none is, the nearest resident key. At least one key must be resident. `undefined` at night.
 */
export function answeringAt(course: Course, resident: ReadonlyMap<number, BakedShadowFile>, seconds: number): Answering | undefined {
  const towardsSun = sunAt(course, seconds);
  const keys = keysAt(course, seconds);
  if (towardsSun === undefined || keys === undefined) return undefined;
  const ofMoment = [...new Set(keys)];
  const parts = ofMoment.flatMap((key) => partOf(key, resident.get(key), towardsSun));
  if (parts.length > 0) return { towardsSun, parts: parts as [AnsweringKey, ...AnsweringKey[]], isExact: parts.length === ofMoment.length };
  const distance = (key: number): number => Math.abs(course.keys[key]!.seconds - seconds);
  const near = [...resident].sort(([a], [b]) => distance(a) - distance(b));
  const marched = near.flatMap(([key, file]) => partOf(key, file, towardsSun))[0];
  if (marched !== undefined) return { towardsSun, parts: [marched], isExact: false };
  // The sun is behind all keys, so the nearest key answers for its own sun.
  const [key, file] = near[0]!;
  return { towardsSun, parts: [{ key, file, slope: [0, 0] }], isExact: false };
}

function partOf(key: number, file: BakedShadowFile | undefined, towardsSun: Vec3): AnsweringKey[] {
  const slope = file && marchSlope(file.grid, towardsSun);
  return slope === undefined ? [] : [{ key, file: file!, slope }];
}
