// Which of the keys that are there answer at a moment, and how.

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
  /** The way to the sun in its grid. */
  readonly slope: MarchSlope;
}

/** What answers at a moment. */
export interface Answering {
  readonly towardsSun: Vec3;
  /** One key, or the one that is asked first and the one that is asked where the first does not know. */
  readonly parts: readonly [AnsweringKey, ...AnsweringKey[]];
  /** Whether these are the keys of the moment. Otherwise they have not all come, and others stand in for them. */
  readonly isExact: boolean;
}

/**
 * Returns what answers at a moment: the keys of the moment; if only one is there, that one; if none is, the nearest one. At
 * least one key must be resident. `undefined` at night.
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
  // The sun is behind all of them, so the nearest one answers for its own sun.
  const [key, file] = near[0]!;
  return { towardsSun, parts: [{ key, file, slope: [0, 0] }], isExact: false };
}

function partOf(key: number, file: BakedShadowFile | undefined, towardsSun: Vec3): AnsweringKey[] {
  const slope = file && marchSlope(file.grid, towardsSun);
  return slope === undefined ? [] : [{ key, file: file!, slope }];
}
