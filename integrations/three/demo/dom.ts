// The elements of the page.

/**
 * Returns the element with an id.
 *
 * @throws Error if the page has none of this kind.
 */
export function element<T extends HTMLElement>(id: string, kind: new () => T): T {
  const found = document.getElementById(id);
  if (!(found instanceof kind)) throw new Error(`the page has no ${kind.name} #${id}`);
  return found;
}

/** Says something in the page's status line, which screen readers read out. */
export function say(message: string, kind: 'note' | 'error' = 'note'): void {
  const line = element('status', HTMLElement);
  line.dataset['kind'] = kind;
  line.textContent = message;
}

/** Calls back with the value of a group of radio buttons whenever it changes. */
export function onChoice(group: string, change: (value: string) => void): void {
  for (const radio of document.querySelectorAll<HTMLInputElement>(`input[name="${group}"]`)) {
    radio.addEventListener('change', () => {
      if (radio.checked) change(radio.value);
    });
  }
}

/** Checks one radio button of a group. */
export function choose(group: string, value: string): void {
  const radio = document.querySelector<HTMLInputElement>(`input[name="${group}"][value="${value}"]`);
  if (radio !== null) radio.checked = true;
}
