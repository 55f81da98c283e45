// The line between the halves, which pointers drag and keys move.

import { element } from './dom.js';

/** Percent per key press. */
const STEPS: Record<string, number> = {
  ArrowLeft: -2,
  ArrowDown: -2,
  ArrowRight: 2,
  ArrowUp: 2,
  PageDown: -10,
  PageUp: 10,
  Home: -100,
  End: 100,
};

/** The divider. */
export class Divider {
  readonly #halves = element('halves', HTMLElement);
  readonly #slider = element('divider', HTMLElement);
  #share = 0.5;

  constructor() {
    this.#slider.addEventListener('pointerdown', (event) => {
      event.preventDefault();
      this.#slider.focus();
      this.#slider.setPointerCapture(event.pointerId);
    });
    this.#slider.addEventListener('pointermove', (event) => {
      if (!this.#slider.hasPointerCapture(event.pointerId)) return;
      const { left, width } = this.#halves.getBoundingClientRect();
      this.share = (event.clientX - left) / width;
    });
    this.#slider.addEventListener('keydown', (event) => {
      const step = STEPS[event.key];
      if (step === undefined) return;
      event.preventDefault();
      this.share = Math.round(100 * this.#share + step) / 100;
    });
    this.share = this.#share;
  }

  /** The share of the width that is the file's half, 0 to 1. */
  get share(): number {
    return this.#share;
  }

  set share(share: number) {
    this.#share = Math.min(Math.max(share, 0), 1);
    const percent = Math.round(100 * this.#share);
    this.#halves.style.setProperty('--split', `${100 * this.#share}%`);
    this.#slider.setAttribute('aria-valuenow', String(percent));
    this.#slider.setAttribute('aria-valuetext', `${percent} % the file, ${100 - percent} % three's own shadows`);
  }

  /** Shows labels, and the divider if there are both. */
  label(file: string | null, stock: string | null): void {
    for (const [id, text] of [['label-file', file], ['label-stock', stock]] as const) {
      element(id, HTMLElement).textContent = text;
      element(id, HTMLElement).hidden = text === null;
    }
    const isDivided = file !== null && stock !== null;
    this.#slider.hidden = !isDivided;
    this.#halves.classList.toggle('undivided', !isDivided);
  }
}
