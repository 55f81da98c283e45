// A look-up: a shader text in the two shader languages of browsers.

/** The shader text of a look-up, as `adumbra-three/look-ups` exports it. */
export interface LookUp {
  /** Its name. */
  readonly name: 'filtered' | 'soft' | 'path';
  /** Whether it softens shadows with distance; otherwise it is a filter of K × K taps. */
  readonly isSoft: boolean;
  /** The text for WebGPU. */
  readonly wgsl: string;
  /** The text for WebGL2. */
  readonly glsl: string;
}

/**
 * Gives the names of a text a prefix, so that the texts of two lights can be in one shader. All names that a
 * text declares contain `adumbra`, in lower or upper case.
 */
export function withPrefix(text: string, prefix: string): string {
  return text.replace(/adumbra/gi, (part) => (part === 'ADUMBRA' ? prefix.toUpperCase() : prefix));
}
