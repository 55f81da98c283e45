// Two keys of a path in one texture, for one light, as `wgsl/path.wgsl` reads them: a row with both headers
// and the values that change with the moment, then a slot for the words of each key.

import type { DataTexture } from 'three';

import { ShadowFileError } from '../error.js';
import type { BakedShadowFile } from '../file/shadow-file.js';
import { HEADER_WORDS, lookUpHeader, wordCount } from '../gpu/look-up-header.js';
import type { GpuLookUpOptions, LookUpHeader } from '../gpu/look-up-header.js';
import { RowUpload } from '../light/row-upload.js';
import type { AnyRenderer, StreamedWords } from '../light/streamed.js';
import { dataTexture } from '../light/textures.js';
import type { Answering, AnsweringKey } from './answering.js';

/** Number of keys that answer at a moment. */
const SLOTS = 2;
/**
 * Header words: the key's first word in the texture; whether it is night; the slope towards the sun; the rise
 * from which hidden rays are dark.
 */
const [FIRST_WORD, IS_NIGHT, SLOPE, DARK_AFTER] = [104, 106, 107, 109] as const;

/** The words of the keys that answer, for one light. */
export class PathWords implements StreamedWords {
  readonly texture: DataTexture;
  readonly lookUps: readonly LookUpHeader[];
  readonly #words: Uint32Array<ArrayBuffer>;
  readonly #width: number;
  readonly #slotRows: number;
  /** The files whose words are in the slots. */
  readonly #slots: (BakedShadowFile | undefined)[] = Array(SLOTS).fill(undefined);
  readonly #rows: RowUpload;
  readonly #renderers = new Set<AnyRenderer>();
  readonly #onDispose: () => void;
  #options: GpuLookUpOptions;
  /** The keys that answer. */
  #shown: readonly Pick<AnsweringKey, 'file' | 'slope'>[] = [];

  /**
   * Makes a texture for the keys that answer now. Its slots have `slotWords` words, which are enough for any
   * key.
   *
   * @throws ShadowFileError of the kind `TooLarge`, if a side of the texture would be longer than `maxSide`.
   * @throws RangeError if an option is out of its range.
   */
  constructor(answering: Answering | undefined, slotWords: number, options: GpuLookUpOptions, maxSide: number, onDispose: () => void) {
    let width = SLOTS * HEADER_WORDS;
    while (width * width < SLOTS * slotWords) width *= 2;
    this.#width = width;
    this.#slotRows = Math.ceil(slotWords / width);
    const height = 1 + SLOTS * this.#slotRows;
    if (Math.max(width, height) > maxSide) {
      const message = `two keys need a texture of ${width} × ${height}, but a side may have ${maxSide} texels; bake at a lower resolution`;
      throw new ShadowFileError('TooLarge', message, { width, height, maxSide });
    }
    this.#words = new Uint32Array(width * height);
    this.#options = options;
    this.#onDispose = onDispose;
    this.texture = dataTexture(this.#words, width, height);
    this.#rows = new RowUpload(this.texture);
    this.lookUps = [
      {
        words: new Uint32Array(HEADER_WORDS),
        parts: [],
        count: 0,
        anchorWorld: [0, 0, 0],
        placement: undefined,
        setLookUp: (changed) => {
          this.#writeHeaders(changed);
          this.#options = changed;
        },
      },
    ];
    this.show(answering);
  }

  /** Sends later changes to a renderer, which is about to draw with the texture for the first time. */
  follow(renderer: AnyRenderer): void {
    this.#renderers.add(renderer);
  }

  /** Shows the keys that answer now; `undefined` is the night. Do not call it while a renderer draws. */
  show(answering: Answering | undefined): void {
    if (answering !== undefined) {
      this.#shown = answering.parts;
      this.#fillSlots();
    }
    this.#words[IS_NIGHT] = Number(answering === undefined);
    this.#writeHeaders(this.#options);
  }

  dispose(): void {
    this.#renderers.clear();
    this.texture.dispose();
    this.#rows.dispose();
    this.#onDispose();
  }

  /** Puts the words of the files that answer into slots, unless they are there already. */
  #fillSlots(): void {
    const files = this.#shown.map(({ file }) => file);
    for (const file of files) {
      if (this.#slots.includes(file)) continue;
      const slot = this.#slots.findIndex((held) => held === undefined || !files.includes(held));
      this.#slots[slot] = file;
      const row = this.#rowOf(slot);
      const at = row * this.#width;
      this.#words.set(file.top, at);
      this.#words.set(file.code, at + file.top.length);
      this.#upload(row, row + Math.ceil(wordCount(file) / this.#width));
    }
  }

  /** Writes the headers of the files that answer. If only one file answers, its header is written twice. */
  #writeHeaders(options: GpuLookUpOptions): void {
    for (let i = 0; i < SLOTS; i++) {
      const shown = this.#shown[i] ?? this.#shown[0];
      if (shown === undefined) break;
      const header = this.#words.subarray(HEADER_WORDS * i, HEADER_WORDS * (i + 1));
      lookUpHeader(shown.file, options, header);
      header[FIRST_WORD] = this.#rowOf(this.#slots.indexOf(shown.file)) * this.#width;
      header.set(shown.slope, SLOPE);
      header[DARK_AFTER] = shown.file.settings.darkAfterVoxels;
    }
    this.#upload(0, 1);
  }

  #rowOf(slot: number): number {
    return 1 + slot * this.#slotRows;
  }

  #upload(from: number, to: number): void {
    for (const renderer of this.#renderers) this.#rows.upload(renderer, from, to);
  }
}
