// The parts of streaming one by one: room in the pool, the choice of bundles, runs, and retry delays.

import { OrthographicCamera, PerspectiveCamera, Vector3 } from 'three';
import { describe, expect, it } from 'vitest';

import { toWorld } from '../../src/grid/light-grid.js';
import { BakedShadowFile } from '../../src/index.js';
import type { Vec3 } from '../../src/index.js';
import { parseEntries, parseTables } from '../../src/file/front.js';
import { parseHeader } from '../../src/file/header.js';
import { Allocator, GRANULE_WORDS, inGranules } from '../../src/stream/allocator.js';
import { boxOf, distanceTo } from '../../src/stream/box.js';
import { bundlesOf } from '../../src/stream/bundles.js';
import type { Bundle } from '../../src/stream/bundles.js';
import { choose } from '../../src/stream/choose.js';
import { poolLayout, poolSize } from '../../src/stream/layout.js';
import { MAX_RUN_BYTES, runAround } from '../../src/stream/requests.js';
import { backoff } from '../../src/stream/retry.js';
import { isSeen, viewOf } from '../../src/stream/views.js';
import { scatter, validBytes } from './vectors.js';

describe('room in the pool', () => {
  it('is allocated and freed without overlap or loss', () => {
    const [from, to] = [128, 128 + 500 * GRANULE_WORDS + 17];
    const allocator = new Allocator(from, to);
    const all = allocator.freeWords;
    expect(all).toBe(500 * GRANULE_WORDS);
    const random = scatter(1);
    const taken: { at: number; words: number }[] = [];
    let [refused, sum] = [0, 0];
    for (let step = 0; step < 5000; step++) {
      if (random() < 0.55 || taken.length === 0) {
        const words = 1 + Math.floor(1500 * random() ** 3);
        const at = allocator.allocate(words);
        if (at === undefined) refused += 1;
        else {
          expect(at % GRANULE_WORDS).toBe(0);
          expect(at).toBeGreaterThanOrEqual(from);
          expect(at + words).toBeLessThanOrEqual(to);
          for (const other of taken) expect(at + inGranules(words) <= other.at || other.at + inGranules(other.words) <= at).toBe(true);
          taken.push({ at, words });
          sum += inGranules(words);
        }
      } else {
        const [given] = taken.splice(Math.floor(random() * taken.length), 1);
        allocator.release(given!.at, given!.words);
        sum -= inGranules(given!.words);
      }
      expect(allocator.freeWords).toBe(all - sum);
    }
    expect(refused).toBeGreaterThan(100);
    for (const { at, words } of taken) allocator.release(at, words);
    expect(allocator.allocate(all)).toBe(from);
    expect(allocator.allocate(1)).toBeUndefined();
  });

  it('is the smallest gap that is large enough', () => {
    const allocator = new Allocator(0, 64 * 10);
    const places = [64 * 3, 64, 64 * 2, 64, 64 * 3].map((words) => allocator.allocate(words)!);
    allocator.release(places[0]!, 64 * 3);
    allocator.release(places[2]!, 64 * 2);
    expect(allocator.allocate(100)).toBe(places[2]);
  });

  it.each([1024, 262_144, 2_500_000, 8_388_608])('of %i words is a texture of at most as many', (words) => {
    const [width, height] = poolSize(words);
    expect(width & (width - 1)).toBe(0);
    expect(width * height).toBeLessThanOrEqual(words);
    expect(width * height).toBeGreaterThan(words - width);
    expect(width).toBeLessThanOrEqual(4 * height);
  });
});

const open = (name: string) => {
  const bytes = validBytes(name);
  const header = parseHeader(bytes);
  const entries = parseEntries(bytes, header);
  return { entries, tables: parseTables(bytes, entries, header.isCoded) };
};

it('the parts of a pool follow each other, and pages begin at a granule', () => {
  const { entries, tables } = open('levels_depths');
  const { levels, pagesAt } = poolLayout(1024 * 1024, entries, tables);
  // Tables of 18 × 17, 5 × 5 and 2 × 2 blocks; common sections of the first level alone.
  const blocks = [2 * 18 * 17, 2 * 5 * 5, 2 * 2 * 2];
  const common = entries[0]!.commonRawBytes / 4;
  expect(levels.map(({ tableAt }) => tableAt)).toEqual([0, blocks[0], blocks[0]! + blocks[1]!]);
  const end = blocks[0]! + blocks[1]! + blocks[2]!;
  expect(levels.map(({ commonAt }) => commonAt)).toEqual([end, end + common, end + common]);
  expect(pagesAt).toBe(Math.ceil((end + common) / 64) * 64);
});

describe('boxes', () => {
  it.each(['many_pages_depths', 'upright_turned_low_depths', 'low_sun_tall_depths', 'slopes_depths'])('%s: the distance is the least of all points of the box', (name) => {
    const { grid } = new BakedShadowFile(validBytes(name));
    const box = boxOf(grid, 0, 0, 20);
    const random = scatter(3);
    const [sx, sy, sz] = grid.size;
    const [endX, endY] = [Math.min(sx, 2064), Math.min(sy, 2064)];
    const inBox = (): Vec3 => toWorld(grid, [endX * random(), endY * random(), 4 + (sz - 4) * random()]);
    expect(distanceTo(box, inBox())).toBe(0);
    for (let i = 0; i < 20; i++) {
      const p = toWorld(grid, [sx * (3 * random() - 1), sy * (3 * random() - 1), sz * (3 * random() - 1)]);
      const d = distanceTo(box, p);
      let least = Infinity;
      for (let j = 0; j < 4000; j++) {
        const q = inBox();
        least = Math.min(least, Math.hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]));
      }
      expect(d).toBeLessThanOrEqual(least + 1e-6);
      // Some sampled point is near the nearest one.
      expect(least - d).toBeLessThan(0.15 * box.radius);
    }
  });
});

describe('views', () => {
  it('have the size of a pixel at a distance', () => {
    const camera = new PerspectiveCamera(90, 2, 1, 100);
    camera.position.set(3, 4, 5);
    const view = viewOf(camera, 500);
    expect(new Vector3(...view.position).distanceTo(camera.position)).toBeLessThan(1e-12);
    expect(view.pixel).toBe(0);
    // At a distance of 1 the picture is 2 high.
    expect(view.pixelPerDistance).toBeCloseTo(2 / 500, 10);
    const flat = viewOf(new OrthographicCamera(-10, 10, 20, -20, 1, 100), 400);
    expect(flat.pixel).toBeCloseTo(40 / 400, 10);
    expect(flat.pixelPerDistance).toBe(0);
  });

  it('see boxes before them, and none behind or beside', () => {
    const camera = new PerspectiveCamera(60, 1, 1, 100);
    camera.lookAt(new Vector3(0, 0, -1));
    const view = viewOf(camera, 500);
    const box = (x: number, y: number, z: number) => ({ corner: [x, y, z], edges: [[2, 0, 0], [0, 2, 0], [0, 0, 2]], middle: [x + 1, y + 1, z + 1], radius: 2 }) as const;
    expect(isSeen(box(-1, -1, -10), view)).toBe(true);
    expect(isSeen(box(-1, -1, 10), view)).toBe(false);
    expect(isSeen(box(20, 0, -10), view)).toBe(false);
    expect(isSeen(box(4.5, 0, -10), view)).toBe(true);
  });
});

/** Bundles in a row, 100 bytes each. */
function row(count: number, storedBytes = 100): Bundle[] {
  const { entries, tables } = open('levels_depths');
  const { levels } = poolLayout(1024 * 1024, entries, tables);
  const [one] = bundlesOf(0, levels[0]!, entries, tables[0]!);
  return Array.from({ length: count }, (_, index) => {
    const entry = { ...one!.entry, storedBytes, name: `bundle ${index}` };
    const corner: Vec3 = [100 * index, 0, 0];
    const box = { ...one!.box, corner, edges: [[100, 0, 0], [0, 0, 100], [0, 10, 0]] as const, middle: [100 * index + 50, 5, 50] as const, radius: 110 };
    return { ...one!, index, entry, offset: 1000 + storedBytes * index, box, words: 1000 };
  });
}

describe('the choice', () => {
  const camera = new PerspectiveCamera(90, 1, 0.1, 1e4);
  camera.position.set(-100, 5, 50);
  camera.lookAt(0, 5, 50);
  const view = viewOf(camera, 200);
  const options = { coarserTexel: () => 4.02, detail: 1, words: Infinity };

  it('has the nearest first, and ends where the coarser level suffices', () => {
    const bundles = row(10);
    const chosen = choose([...bundles].reverse(), [view], options);
    // A pixel is a hundredth of the distance, so texels of 4.02 are too coarse up to 402.
    expect(chosen.map(({ index }) => index)).toEqual([0, 1, 2, 3]);
    expect(chosen[0]!.need).toBeCloseTo(4.02, 6);
    expect(chosen[2]!.need).toBeCloseTo(1.34, 6);
    expect(choose(bundles, [view], { ...options, detail: 2.1 }).map(({ index }) => index)).toEqual([0]);
  });

  it('allows unseen bundles to be four times coarser', () => {
    const back = new PerspectiveCamera(90, 1, 0.1, 1e4);
    back.position.copy(camera.position);
    back.lookAt(-1000, 5, 50);
    const chosen = choose(row(10), [viewOf(back, 200)], { ...options, detail: 0.6 });
    expect(chosen.map(({ index }) => index)).toEqual([0]);
    expect(chosen[0]!.need).toBeCloseTo(4.02 / 0.6 / 4, 6);
  });

  it('takes the greatest need of several views, and stops when full', () => {
    const far = camera.clone();
    far.position.x = 1100;
    far.lookAt(0, 5, 50);
    const bundles = row(10);
    const both = choose(bundles, [view, viewOf(far, 200)], options);
    expect(both.map(({ index }) => index).sort()).toEqual([0, 1, 2, 3, 6, 7, 8, 9]);
    expect(choose(bundles, [view], { ...options, words: 2500 }).map(({ index }) => index)).toEqual([0, 1]);
    expect(choose(bundles, [], options)).toEqual([]);
  });

  it('among equals takes the coarser level, then the order of the file', () => {
    const inside = camera.clone();
    inside.position.set(50, 5, 50);
    const [first] = row(1);
    const equals = [300, 100, 200].map((offset) => ({ ...first!, offset }));
    expect(choose(equals, [viewOf(inside, 200)], options).map(({ offset }) => offset)).toEqual([100, 200, 300]);
    expect(equals[0]!.need).toBe(Infinity);
  });
});

describe('a run', () => {
  const indices = (run: readonly Bundle[]) => run.map(({ index }) => index);

  it('takes wanted neighbours along, and skips bundles without bytes', () => {
    const level = row(10);
    level[6] = { ...level[6]!, entry: { ...level[6]!.entry, storedBytes: 0 } };
    expect(indices(runAround(level[4]!, level, ({ index }) => index !== 2 && index !== 8))).toEqual([3, 4, 5, 7]);
  });

  it('has at most 256 KiB unless it is one bundle', () => {
    const level = row(10, MAX_RUN_BYTES / 4);
    expect(indices(runAround(level[0]!, level, () => true))).toEqual([0, 1, 2, 3]);
    expect(indices(runAround(level[9]!, level, () => true))).toEqual([6, 7, 8, 9]);
    const large = row(3, 2 * MAX_RUN_BYTES);
    expect(indices(runAround(large[1]!, large, () => true))).toEqual([1]);
  });
});

it('waits are doubled up to a minute', () => {
  expect([1, 2, 3, 4, 5, 6, 7, 8, 50].map(backoff)).toEqual([1000, 2000, 4000, 8000, 16_000, 32_000, 60_000, 60_000, 60_000]);
});
