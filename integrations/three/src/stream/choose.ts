// Which bundles are to be in the pool: `spec/streaming.md`, "Which pages".

import type { Vec3 } from '../grid/vec3.js';
import { distanceTo } from './box.js';
import type { Bundle } from './bundles.js';
import { isSeen } from './views.js';
import type { View } from './views.js';

/** How many times coarser bundles outside of the view may be. */
const UNSEEN = 4;

/**
 * Returns the bundles that views need, the most needed first, as far as they fit `words` words.
 * `coarserTexel` is the size of a texel of the level after a bundle's, world units; `detail` is the largest
 * number of pixels that a texel may cover.
 */
export function choose(
  candidates: readonly Bundle[],
  views: readonly View[],
  { coarserTexel, detail, words }: { coarserTexel(bundle: Bundle): number; detail: number; words: number },
): Bundle[] {
  const wanted: Bundle[] = [];
  for (const bundle of candidates) {
    bundle.need = 0;
    for (const view of views) bundle.need = Math.max(bundle.need, needOf(bundle, view, coarserTexel(bundle) / detail));
    if (bundle.need > 1) wanted.push(bundle);
  }
  // Coarser levels come first in the file.
  wanted.sort((a, b) => (a.need === b.need ? a.offset - b.offset : b.need - a.need));
  let left = words;
  const end = wanted.findIndex((bundle) => (left -= bundle.words) < 0);
  return end < 0 ? wanted : wanted.slice(0, end);
}

/** Returns how many times coarser than wanted a texel of `texel` world units is in a view. */
function needOf({ box }: Bundle, view: View, texel: number): number {
  const { position, pixel, pixelPerDistance } = view;
  const of = (d: number): number => texel / (pixel + pixelPerDistance * d);
  // Test the ball first: it is at most as far away as the box, and rules out most bundles.
  const nearest = Math.max(apart(position, box.middle) - box.radius, 0);
  if (of(nearest) <= 1) return 0;
  return of(distanceTo(box, position)) / (isSeen(box, view) ? 1 : UNSEEN);
}

function apart(a: Vec3, b: Vec3): number {
  return Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}
