// Decodes and checks parts of a file one by one, in a worker or on the page.

import { checkChecksum } from '../file/faults.js';
import type { Steps } from '../file/steps.js';
import { HEAD_WORDS, codedUnpacker, rawUnpacker, unpackBundle } from '../file/table.js';
import type { BundleEntry, Unpacker } from '../file/table.js';
import { BUNDLE_SIDE } from '../quadtree/pages.js';
import type { Page } from '../quadtree/pages.js';
import { validate } from '../quadtree/validate.js';

/** A common section to decode. The jobs of the bundles that follow need it. */
export interface CommonJob {
  readonly kind: 'common';
  readonly level: number;
  readonly isCoded: boolean;
  readonly stored: Uint8Array;
  readonly name: string;
  readonly checksum: number;
  readonly rawBytes: number;
}

/** A bundle to decode. */
export interface BundleJob {
  readonly kind: 'bundle';
  readonly level: number;
  readonly stored: Uint8Array;
  readonly entry: BundleEntry;
}

/** A part to decode. */
export type DecodeJob = CommonJob | BundleJob;

/** The state of a level. */
interface Level {
  readonly unpacker: Unpacker;
  readonly common: Uint32Array;
}

/** Decodes parts. One job must be done before the next begins. */
export class Decoding {
  readonly #levels = new Map<number, Level>();

  /**
   * Decodes a part into words. The words of a bundle begin with three per page.
   *
   * @throws ShadowFileError if the part is damaged.
   */
  do(job: DecodeJob): Steps<Uint32Array> {
    return job.kind === 'common' ? this.#common(job) : this.#bundle(job);
  }

  *#common({ level, isCoded, stored, name, checksum, rawBytes }: CommonJob): Steps<Uint32Array> {
    checkChecksum(stored, checksum, name);
    const unpacker = isCoded ? codedUnpacker() : rawUnpacker();
    const common = yield* unpacker.common(stored, rawBytes, name);
    this.#levels.set(level, { unpacker, common });
    // Return a copy, because the caller may transfer its words.
    return common.slice();
  }

  *#bundle({ level, stored, entry }: BundleJob): Steps<Uint32Array> {
    const { unpacker, common } = this.#levels.get(level)!;
    checkChecksum(stored, entry.checksum, entry.name);
    const words = yield* unpackBundle(unpacker, stored, entry);
    const code = new Uint32Array(common.length + entry.pageWords);
    code.set(common);
    code.set(words.subarray(HEAD_WORDS), common.length);
    let firstWord = common.length;
    const pages: Page[] = [];
    for (let head = 0; head < HEAD_WORDS; head += 3) {
      const [root, base, count] = words.subarray(head, head + 3) as unknown as [number, number, number];
      pages.push({ root, base, firstWord, words: count });
      firstWord += count;
    }
    yield* validate(code, common.length, pages, BUNDLE_SIDE, level);
    return words;
  }
}
