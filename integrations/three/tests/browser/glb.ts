// Changes the JSON of a GLB file.

/** The parts of the JSON that tests change. */
export interface GltfJson {
  extensions: { KHR_lights_punctual: { lights: [{ extras: { adumbra: object } }] } };
}

const HEADER_BYTES = 12;
const CHUNK_HEADER_BYTES = 8;

/** Returns a GLB file with its JSON changed. The chunks that follow stay as they are. */
export function withJson(glb: Buffer, change: (json: GltfJson) => void): Buffer {
  const start = HEADER_BYTES + CHUNK_HEADER_BYTES;
  const end = start + glb.readUInt32LE(HEADER_BYTES);
  const json = JSON.parse(glb.toString('utf8', start, end)) as GltfJson;
  change(json);
  const text = Buffer.from(JSON.stringify(json));
  const padded = Buffer.alloc(Math.ceil(text.length / 4) * 4, ' ');
  text.copy(padded);
  const whole = Buffer.concat([glb.subarray(0, start), padded, glb.subarray(end)]);
  whole.writeUInt32LE(whole.length, 8);
  whole.writeUInt32LE(padded.length, HEADER_BYTES);
  return whole;
}
