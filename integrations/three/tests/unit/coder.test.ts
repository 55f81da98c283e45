// Coded files: they have the words of their raw twins, any bytes throw nothing but a ShadowFileError, and
// loading them does not block the page.

import { afterEach, describe, expect, it, vi } from 'vitest';

import { PartDecoder } from '../../src/coder/part.js';
import { LARGEST_RATIO } from '../../src/coder/rans.js';
import { parseDirectory } from '../../src/file/directory.js';
import { run, runInSlices } from '../../src/file/steps.js';
import { HEAD_WORDS, parseTable } from '../../src/file/table.js';
import { BUNDLE_PAGES } from '../../src/quadtree/pages.js';
import { HEADER_BYTES } from '../../src/file/faults.js';
import { parseHeader } from '../../src/file/header.js';
import { BakedShadowFile, ShadowFileError } from '../../src/index.js';
import { caught, scatter, validBytes, validNames } from './vectors.js';

const CODED = validNames().filter((name) => parseHeader(validBytes(name)).isCoded);

/** Ends the decoding of a part. */
class Fault extends Error {}

const fail = (): never => {
  throw new Fault();
};

/** A coded common section and the coded bundles after it, with their numbers of words. */
interface CodedLevel {
  readonly common: readonly [stored: Uint8Array, words: number];
  readonly bundles: readonly (readonly [stored: Uint8Array, words: number])[];
}

function levelsOf(bytes: Uint8Array): CodedLevel[] {
  const header = parseHeader(bytes);
  const entries = parseDirectory(bytes.subarray(HEADER_BYTES, HEADER_BYTES * (1 + header.levelCount)), header);
  return entries.map(({ table, common, commonRawBytes, bundles }, level) => {
    let at = bundles.offset;
    const entriesOfTable = parseTable(bytes.subarray(table.offset, table.offset + table.length), level, table.name, bundles.length, true);
    return {
      common: [bytes.subarray(common.offset, common.offset + common.length), commonRawBytes / 4],
      bundles: entriesOfTable.map(({ storedBytes, pageWords }) => [bytes.subarray(at, (at += storedBytes)), HEAD_WORDS + pageWords] as const).filter(([stored]) => stored.length > 0),
    };
  });
}

const LEVELS = CODED.flatMap((name) => levelsOf(validBytes(name)));

/** Decodes a part; returns its words, or `undefined` if it is refused. */
function decoded(steps: Generator<void, Uint32Array>): Uint32Array | undefined {
  try {
    return run(steps);
  } catch (error) {
    expect(error).toBeInstanceOf(Fault);
    return undefined;
  }
}

afterEach(() => {
  vi.unstubAllGlobals();
});

it.each(CODED)('%s has the words of its raw twin', (name) => {
  const [coded, raw] = [name, name.replace('_coded', '')].map((each) => new BakedShadowFile(validBytes(each))) as [BakedShadowFile, BakedShadowFile];
  expect(coded.levelCount).toBe(raw.levelCount);
  for (let n = 0; n < raw.levelCount; n++) {
    for (const part of ['code', 'top', 'topDims', 'rootLevel', 'grid', 'settings'] as const) {
      expect(coded.level(n)![part], `${part} of level ${n}`).toEqual(raw.level(n)![part]);
    }
  }
});

it('the vectors cover coded common sections and several bundles', () => {
  expect(LEVELS.some(({ common: [stored] }) => stored.length > 0)).toBe(true);
  expect(Math.max(...LEVELS.map(({ bundles }) => bundles.length))).toBeGreaterThan(1);
});

it('earlier decodings do not affect a result', () => {
  for (const { common, bundles } of LEVELS) {
    const decoder = new PartDecoder();
    run(decoder.common(...common, fail));
    const first = bundles.map((bundle) => run(decoder.bundle(...bundle, fail)));
    decoded(decoder.bundle(Uint8Array.from({ length: 400 }, (_, i) => 37 * i), 10_000, fail));
    expect(bundles.map((bundle) => run(decoder.bundle(...bundle, fail)))).toEqual(first);
  }
});

describe('garbage is refused or gives the expected number of words', () => {
  const random = scatter(20_261_126);
  const below = (n: number): number => Math.floor(random() * n);
  const noise = (length: number): Uint8Array => Uint8Array.from({ length }, () => below(256));

  it.each([...LEVELS.keys()])('of level %i', (i) => {
    const { common, bundles } = LEVELS[i]!;
    const decoder = new PartDecoder();
    run(decoder.common(...common, fail));
    /** Decodes bytes as each kind of part. */
    const both = (stored: Uint8Array, words: number): void => {
      for (const steps of [decoder.bundle(stored, Math.max(words, HEAD_WORDS), fail), new PartDecoder().common(stored, words, fail)]) {
        const found = decoded(steps);
        if (found !== undefined && stored.length > 0) expect(found.length).toBe(words);
      }
    };
    for (const [stored, words] of [common, ...bundles]) {
      for (let at = 0; at < stored.length; at += 1 + below(stored.length / 20)) {
        expect(decoded(decoder.bundle(stored.subarray(0, at), words, fail))).toBeUndefined();
        both(stored.slice(0, at), words);
      }
      for (let n = 0; n < 100 && stored.length > 0; n++) {
        const flipped = stored.slice();
        flipped[below(stored.length)]! ^= 1 << below(8);
        both(flipped, words);
        const changed = stored.slice();
        for (let at = below(stored.length), count = below(40); count > 0 && at < stored.length; count--) changed[at++] = below(256);
        both(changed, words);
      }
      for (const other of [0, 1, HEAD_WORDS - 1, HEAD_WORDS, words - 1, words + 1, 2 * words]) {
        if (other >= HEAD_WORDS && stored.length > 0) expect(decoded(decoder.bundle(stored, other, fail))).toBeUndefined();
      }
    }
    for (let n = 0; n < 300; n++) both(noise(below(500)), below(2 ** 18));
  });
});

it('steps and memory are bounded by the bytes of a part', () => {
  let allocated = 0;
  const counted = <C extends new (...args: any[]) => ArrayBufferView>(array: C): C =>
    class extends array {
      constructor(...args: any[]) {
        super(...args);
        allocated += this.byteLength;
      }
    };
  vi.stubGlobal('Int32Array', counted(Int32Array));
  vi.stubGlobal('Uint16Array', counted(Uint16Array));
  vi.stubGlobal('Uint32Array', counted(Uint32Array));
  const random = scatter(5);
  for (const length of [8, 1000, 20_000]) {
    for (const byte of [() => 0, () => 255, () => Math.floor(256 * random())]) {
      const stored = Uint8Array.from({ length }, byte);
      const words = (LARGEST_RATIO / 4) * length;
      for (const decode of [(decoder: PartDecoder) => decoder.common(stored, words, fail), (decoder: PartDecoder) => decoder.bundle(stored, Math.max(words, HEAD_WORDS), fail)]) {
        allocated = 0;
        let count = 0;
        const steps = decode(new PartDecoder());
        expect(() => {
          while (steps.next().done !== true) count++;
        }).toThrow(Fault);
        expect(count).toBeLessThanOrEqual(length + BUNDLE_PAGES);
        // The decoder's own tables take 272 KB.
        expect(allocated).toBeLessThan(2 ** 19 + 4 * length);
      }
    }
  }
});

describe('in slices', () => {
  it.each(validNames())('%s gives the same file', async (name) => {
    const bytes = validBytes(name);
    const file = await BakedShadowFile.parseAsync(bytes);
    expect(file).toBeInstanceOf(BakedShadowFile);
    expect(file).toEqual(new BakedShadowFile(bytes));
    expect(Object.isFrozen(file)).toBe(true);
  });

  it('takes ten milliseconds each, with the event loop in between', async () => {
    let [clock, reads, turns, isOver] = [0, 0, 0, false];
    const work = function* (): Generator<void, string> {
      for (let step = 0; step < 100; step++) {
        clock += 3;
        yield;
      }
      return 'done';
    };
    const turn = (): void => {
      turns++;
      if (!isOver) setImmediate(turn);
    };
    turn();
    const now = (): number => {
      reads++;
      return clock;
    };
    expect(await runInSlices(work(), undefined, now)).toBe('done');
    isOver = true;
    // The clock is read once for each slice, which has four steps, and once after each step.
    expect(reads).toBe(26 + 100);
    expect(turns).toBeGreaterThan(3);
  });

  it('an invalid file is a ShadowFileError', async () => {
    const bytes = validBytes(CODED[0]!);
    bytes[bytes.length - 1]! ^= 1;
    const error: unknown = await BakedShadowFile.parseAsync(bytes).catch((e: unknown) => e);
    expect(error).toBeInstanceOf(ShadowFileError);
    expect(error).toEqual(caught(() => new BakedShadowFile(bytes)));
  });

  it('rejects with the reason of its signal', async () => {
    const controller = new AbortController();
    const parsing = BakedShadowFile.parseAsync(validBytes(CODED[0]!), { signal: controller.signal });
    controller.abort(new Error('enough'));
    await expect(parsing).rejects.toThrow('enough');
  });
});
