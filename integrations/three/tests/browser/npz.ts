// Reads truth files: NumPy archives (.npz), which are zip files of arrays.

import { readFileSync } from 'node:fs';
import { inflateRawSync } from 'node:zlib';

/** The camera of a truth file. */
export interface TruthCamera {
  readonly eye: readonly [number, number, number];
  readonly target: readonly [number, number, number];
  /** Vertical field of view, degrees. */
  readonly fov_y: number;
  /** Towards the sun, a unit vector. */
  readonly sun: readonly [number, number, number];
}

const END_OF_DIRECTORY = 0x06054b50;
const END_BYTES = 22;
const ENTRY_BYTES = 46;
const LOCAL_HEADER_BYTES = 30;
const DEFLATED = 8;

/** The arrays of a truth file. */
export class Npz {
  readonly #path: string;
  readonly #arrays = new Map<string, Buffer>();

  /** Reads a file. Archives with a comment or of more than 4 GiB are not understood. */
  constructor(path: string) {
    this.#path = path;
    const zip = readFileSync(path);
    const end = zip.length - END_BYTES;
    if (zip.readUInt32LE(end) !== END_OF_DIRECTORY) throw new Error(`${path} is no zip file`);
    let entry = zip.readUInt32LE(end + 16);
    for (let count = zip.readUInt16LE(end + 10); count > 0; count -= 1) {
      const [method, bytes, local] = [zip.readUInt16LE(entry + 10), zip.readUInt32LE(entry + 20), zip.readUInt32LE(entry + 42)];
      const nameEnd = entry + ENTRY_BYTES + zip.readUInt16LE(entry + 28);
      const start = local + LOCAL_HEADER_BYTES + zip.readUInt16LE(local + 26) + zip.readUInt16LE(local + 28);
      const packed = zip.subarray(start, start + bytes);
      const name = zip.toString('utf8', entry + ENTRY_BYTES, nameEnd);
      this.#arrays.set(name, method === DEFLATED ? inflateRawSync(packed) : packed);
      entry = nameEnd + zip.readUInt16LE(entry + 30) + zip.readUInt16LE(entry + 32);
    }
  }

  /** Returns an array of 32-bit floating-point numbers. */
  floats(name: string): Float32Array {
    const data = this.#data(name, '<f4');
    return new Float32Array(Uint8Array.from(data).buffer);
  }

  /** Returns the camera, which is JSON in an array of one text. */
  camera(): TruthCamera {
    // UTF-32, filled up with zeros.
    const data = this.#data('camera', '<U');
    const points = Array.from({ length: data.length / 4 }, (_, i) => data.readUInt32LE(4 * i));
    return JSON.parse(String.fromCodePoint(...points.filter((point) => point !== 0))) as TruthCamera;
  }

  /** Returns the elements of an array whose type begins with `type`. */
  #data(name: string, type: string): Buffer {
    const array = this.#arrays.get(`${name}.npy`);
    if (array === undefined) throw new Error(`${this.#path} has no array ${name}`);
    const [start, wide] = array[6] === 1 ? [10, array.readUInt16LE(8)] : [12, array.readUInt32LE(8)];
    const head = array.toString('latin1', start, start + wide);
    if (!head.includes(`'descr': '${type}`) || !head.includes("'fortran_order': False")) {
      throw new Error(`${this.#path}: ${name} is not of the type ${type}: ${head.trim()}`);
    }
    return array.subarray(start + wide);
  }
}
