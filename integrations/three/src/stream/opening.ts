// The beginning of a file: header, directory, tables, and the coarsest level. `spec/streaming.md`, "Opening".

import { ShadowFileError } from '../error.js';
import type { GridEntry } from '../file/directory.js';
import { HEADER_BYTES, trailing, truncated } from '../file/faults.js';
import { parseEntries, parseTables } from '../file/front.js';
import { parseHeader } from '../file/header.js';
import type { ShadowFileHeader } from '../file/header.js';
import type { BundleEntry } from '../file/table.js';
import type { Source } from './source.js';

/** Bytes of the first request. */
const FIRST_BYTES = 65_536;

/** The beginning of a file. */
export interface Front {
  readonly header: ShadowFileHeader;
  readonly entries: readonly GridEntry[];
  /** The bundles of each level. */
  readonly tables: readonly (readonly BundleEntry[])[];
  /** All bytes up to the end of the coarsest level. */
  readonly bytes: Uint8Array;
}

/**
 * Reads the beginning of a file, with at most two requests.
 *
 * @throws ShadowFileError if it cannot be fetched or is not valid.
 */
export async function readFront(source: Source): Promise<Front> {
  const first = await source.read(0, FIRST_BYTES);
  const header = parseHeader(first);
  const entries = parseEntries(first, header);
  const { bundles } = entries.at(-1)!;
  const end = bundles.offset + bundles.length;
  const bytes = await upTo(source, first, end);
  const { fileLength } = source;
  if (bytes.length < end) throw truncated(bundles.name, end, bytes.length);
  if (fileLength !== undefined && fileLength < header.fileBytes) throw truncated('bundles of level 0', header.fileBytes, fileLength);
  if (fileLength !== undefined && fileLength > header.fileBytes) throw trailing(header.fileBytes);
  return { header, entries, tables: parseTables(bytes, entries, header.isCoded), bytes };
}

/** Whether a file still has the header that it had when it was opened. */
export async function isSameHeader(source: Source, header: Uint8Array): Promise<boolean> {
  const now = await source.read(0, HEADER_BYTES);
  return now.every((byte, i) => byte === header[i]);
}

/** Returns the bytes of a file up to `end`. `first` are the bytes that have already been read. */
export async function upTo(source: Source, first: Uint8Array, end: number): Promise<Uint8Array> {
  if (first.length >= end) return first;
  const rest = await source.read(first.length, end - first.length);
  const bytes = new Uint8Array(first.length + rest.length);
  bytes.set(first);
  bytes.set(rest, first.length);
  return bytes;
}

/** Returns an error with the address of the file in its message. */
export function withUrl(error: unknown, url: string): unknown {
  if (!(error instanceof ShadowFileError) || error.url !== undefined) return error;
  const { kind, message, details, fault, cause } = error;
  return new ShadowFileError(kind, message, details, { fault, url, cause });
}
