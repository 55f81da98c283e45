// The page's shadow file. It is fetched packed by gzip, so that it is small from a server that compresses nothing too.

import { ShadowFileLoader } from 'adumbra-three';
import type { BakedShadowFile } from 'adumbra-three';

/**
 * Loads a shadow file that is packed by gzip.
 *
 * @throws Error if it cannot be fetched, and ShadowFileError if it is none.
 */
export async function loadPacked(url: string): Promise<BakedShadowFile> {
  const response = await fetch(url);
  if (!response.ok) throw new Error(`${url} cannot be fetched: ${response.status}`);
  const bytes = new Uint8Array(await response.arrayBuffer());
  // Of some servers the browser has unpacked it.
  const isPacked = bytes[0] === 0x1f && bytes[1] === 0x8b;
  if (!isPacked) return new ShadowFileLoader().parseAsync(bytes);
  const unpacked = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new ShadowFileLoader().parseAsync(await new Response(unpacked).arrayBuffer());
}
