// Warnings, each once in a page.

const given = new Set<string>();

/** Writes a warning to the console, unless it was written before. */
export function warnOnce(text: string): void {
  if (given.has(text)) return;
  given.add(text);
  console.warn(`adumbra-three: ${text}`);
}
