// Errors of reading a shadow file and of preparing it for a GPU. Kinds and faults have the names of
// `spec/adumbra-file.md`, "What a reader checks", which the Rust crate shares.

/**
 * The kind of fault of a file.
 *
 * `Io`: it could not be fetched. `TooLarge`: it may be valid, but does not fit the GPU, the budget or the
 * limit. `Changed`: it has changed since it was opened. All others are those of the specification: the file
 * is not valid.
 */
export type ShadowFileErrorKind =
  | 'Magic'
  | 'OtherKind'
  | 'FutureVersion'
  | 'Truncated'
  | 'TrailingBytes'
  | 'HeaderChecksum'
  | 'SectionChecksum'
  | 'HeaderField'
  | 'SectionBounds'
  | 'Bundle'
  | 'Coded'
  | 'Depths'
  | 'TooLarge'
  | 'Changed'
  | 'Io';

/** A fault in the voxels, for the kind `Depths`. */
export type ShadowFileFault = 'TooLong' | 'Root' | 'Order' | 'End' | 'Bits' | 'Ranks' | 'Overlap';

/** The values that an error found, by name. */
export type ShadowFileErrorDetails = Readonly<Record<string, number | string>>;

/** A shadow file that cannot be used. The message names the fault and its place, and says what to do about it. */
export class ShadowFileError extends Error {
  override readonly name = 'ShadowFileError';
  /** The kind of fault. Stable across versions. */
  declare readonly kind: ShadowFileErrorKind;
  /** The fault in the voxels, for the kind `Depths`. Stable across versions. */
  declare readonly fault: ShadowFileFault | undefined;
  /** The values found, by name. For a fault in the voxels, only its level is given. */
  declare readonly details: ShadowFileErrorDetails;
  /** Where the file came from, if a loader read it. */
  declare readonly url: string | undefined;

  /** Creates an error. `url` is put before the message. */
  constructor(
    kind: ShadowFileErrorKind,
    message: string,
    details: ShadowFileErrorDetails = {},
    { fault, url, cause }: { fault?: ShadowFileFault | undefined; url?: string; cause?: unknown } = {},
  ) {
    super(url === undefined ? message : `${url}: ${message}`, { cause });
    Object.assign(this, { kind, details, fault, url });
  }
}

/** Returns a word as eight hexadecimal digits. */
export function hex(word: number): string {
  return `0x${word.toString(16).padStart(8, '0')}`;
}
