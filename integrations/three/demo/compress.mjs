// Puts a file `.br` beside each file of the built page that gets smaller, for servers that send these. The
// streamed file gets none, because ranges count the bytes as they are stored.

import { readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { brotliCompressSync, constants } from 'node:zlib';

const folder = fileURLToPath(new URL('dist', import.meta.url));
for (const entry of readdirSync(folder, { recursive: true, withFileTypes: true })) {
  if (!entry.isFile() || entry.name.endsWith('.br') || entry.name === 'metropolis.adumbra') continue;
  const path = join(entry.parentPath, entry.name);
  const bytes = readFileSync(path);
  const compressed = brotliCompressSync(bytes, {
    params: {
      [constants.BROTLI_PARAM_QUALITY]: 11,
      [constants.BROTLI_PARAM_LGWIN]: 24,
      [constants.BROTLI_PARAM_SIZE_HINT]: bytes.length,
    },
  });
  if (compressed.length < bytes.length) writeFileSync(`${path}.br`, compressed);
  console.log(`${path.slice(folder.length + 1)}: ${bytes.length} bytes, ${Math.min(bytes.length, compressed.length)} compressed`);
}
