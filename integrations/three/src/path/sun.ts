// Where the sun of a path is at a moment, and which keys answer then. `spec/sun-path.md` has the rules.
// Counterpart of `crates/adumbra/src/path/mod.rs`.

import { dot, map3 } from '../grid/vec3.js';
import type { Vec3 } from '../grid/vec3.js';
import { STEP_NUMBERS } from './front.js';
import type { PathFront } from './front.js';

/** The steps and keys of a path. */
export type Course = Pick<PathFront, 'steps' | 'keys'>;

/**
 * Returns the unit vector towards the sun at a moment: between two steps on the shortest arc. `undefined`
 * before the first step, after the last, and while the sun is at or below the horizon.
 */
export function sunAt({ steps }: Course, seconds: number): Vec3 | undefined {
  const after = firstFrom(steps.length / STEP_NUMBERS, (i) => steps[STEP_NUMBERS * i]!, seconds);
  const b = stepAt(steps, after);
  if (b === undefined) return undefined;
  let towards = b.towards;
  if (b.seconds !== seconds) {
    const a = stepAt(steps, after - 1);
    if (a === undefined) return undefined;
    towards = between(a.towards, b.towards, (seconds - a.seconds) / (b.seconds - a.seconds));
  }
  return towards[1] > 0 ? towards : undefined;
}

/**
 * Returns the numbers of the keys that answer at a moment: the key that is looked up first, and the other
 * key. Before the first key, after the last and at a key, both are the same key. `undefined` where
 * {@link sunAt} has no sun.
 */
export function keysAt(course: Course, seconds: number): [first: number, second: number] | undefined {
  /** How many times nearer the key with the lower sun must be to be the first. */
  const MUCH_NEARER = 4;
  const { keys } = course;
  if (sunAt(course, seconds) === undefined) return undefined;
  const after = keyFrom(course, seconds);
  const before = after - 1;
  if (after === keys.length) return [before, before];
  if (after === 0 || keys[after]!.seconds === seconds) return [after, after];
  const heightOf = (key: number): number => sunAt(course, keys[key]!.seconds)?.[1] ?? 0;
  const isHigherBefore = heightOf(before) >= heightOf(after);
  const toBefore = (isHigherBefore ? 1 : MUCH_NEARER) * (seconds - keys[before]!.seconds);
  const toAfter = (isHigherBefore ? MUCH_NEARER : 1) * (keys[after]!.seconds - seconds);
  return toBefore <= toAfter ? [before, after] : [after, before];
}

/** Returns the keys that a moment needs, and the next one in the direction of time, the most urgent first. At night these are the keys around it. */
export function wantedAt(course: Course, seconds: number, isForward: boolean): number[] {
  const last = course.keys.length - 1;
  const after = keyFrom(course, seconds);
  const around = isForward ? [after, after - 1] : [after - 1, after];
  const ofMoment = keysAt(course, seconds) ?? around.filter((key) => key >= 0 && key <= last);
  const next = isForward ? Math.max(...ofMoment) + 1 : Math.min(...ofMoment) - 1;
  return [...new Set([...ofMoment, next])].filter((key) => key >= 0 && key <= last);
}

/** Returns the number of the first key at a moment or later, or the number of keys. */
function keyFrom({ keys }: Course, seconds: number): number {
  return firstFrom(keys.length, (i) => keys[i]!.seconds, seconds);
}

/** Returns the index of the first of `count` ascending times that is not before `seconds`. */
function firstFrom(count: number, timeOf: (index: number) => number, seconds: number): number {
  let [low, high] = [0, count];
  while (low < high) {
    const middle = (low + high) >>> 1;
    if (timeOf(middle) < seconds) low = middle + 1;
    else high = middle;
  }
  return low;
}

function stepAt(steps: Float64Array, index: number): { seconds: number; towards: Vec3 } | undefined {
  const at = STEP_NUMBERS * index;
  if (at < 0 || at >= steps.length) return undefined;
  return { seconds: steps[at]!, towards: [steps[at + 1]!, steps[at + 2]!, steps[at + 3]!] };
}

/** Returns the direction at a share of the shortest arc between two unit vectors. */
function between(a: Vec3, b: Vec3, share: number): Vec3 {
  const angle = Math.acos(Math.min(Math.max(dot(a, b), -1), 1));
  const sine = Math.sin(angle);
  const [ofA, ofB] = sine > 1e-9 ? [Math.sin((1 - share) * angle) / sine, Math.sin(share * angle) / sine] : [1 - share, share];
  const sum = map3(a, (c, axis) => ofA * c + ofB * b[axis]);
  const length = Math.sqrt(dot(sum, sum));
  return map3(sum, (c) => c / length);
}
