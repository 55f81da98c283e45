// Warnings, each once in a page.

const given = new Set<string>();

/** Writes a warning to the console, unless one of the same topic was written before. */
export function warnOnce(text: string, topic: string): void {
  if (!given.has(topic)) console.warn(`adumbra-three: ${text}`);
  given.add(topic);
}
