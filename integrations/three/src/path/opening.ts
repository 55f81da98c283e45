// The beginning of a path file on a server.

import { trailing, truncated } from '../file/faults.js';
import { upTo } from '../stream/opening.js';
import type { Source } from '../stream/source.js';
import { parsePathHeader, parsePathTables } from './front.js';
import type { PathFront } from './front.js';

/** Bytes of the first request. A day of minutes fits into it. */
const FIRST_BYTES = 65_536;

/**
 * Reads header and tables of a path, with at most two requests.
 *
 * @throws ShadowFileError if they cannot be fetched or are not valid.
 */
export async function readPathFront(source: Source): Promise<PathFront> {
  const first = await source.read(0, FIRST_BYTES);
  const header = parsePathHeader(first);
  const front = parsePathTables(await upTo(source, first, header.frontBytes), header);
  const { fileLength } = source;
  const { fileBytes } = front;
  if (fileLength !== undefined && fileLength < fileBytes) throw truncated('keys', fileBytes, fileLength);
  if (fileLength !== undefined && fileLength > fileBytes) throw trailing(fileBytes);
  return front;
}
