// A city of 2 × 2 km: the demo's city several times in each direction, each copy turned. The copies share
// their meshes, so only the nodes are rewritten.

/** Number of copies along each side. */
export const COPIES = 5;
/** Metres along a side of a copy. */
export const SIDE = 400;

/** Returns the quarter turns of the copy in a column and a row. */
export function turnsOf(column, row) {
  return (3 * column + 2 * row) % 4;
}

/** Returns the places of all copies: their middle, and how they are turned around the vertical. */
export function places() {
  const numbers = [...Array(COPIES).keys()];
  const middle = (n) => SIDE * (n - (COPIES - 1) / 2);
  return numbers.flatMap((column) => numbers.map((row) => ({ x: middle(column), z: middle(row), quarterTurns: turnsOf(column, row) })));
}

/** Returns the bytes of a GLB with all copies of the scene in `glb`, whose nodes must all be at the root. */
export function multiplied(glb) {
  const JSON_HEADER = 20;
  const jsonBytes = glb.readUInt32LE(12);
  const scene = JSON.parse(glb.toString('utf8', JSON_HEADER, JSON_HEADER + jsonBytes));
  const { nodes } = scene;
  scene.nodes = [];
  scene.scenes = [{ nodes: [] }];
  for (const { x, z, quarterTurns } of places()) {
    const first = scene.nodes.length;
    scene.nodes.push(...nodes, {
      translation: [x, 0, z],
      rotation: [0, Math.sin((quarterTurns * Math.PI) / 4), 0, Math.cos((quarterTurns * Math.PI) / 4)],
      children: nodes.map((_, i) => first + i),
    });
    scene.scenes[0].nodes.push(scene.nodes.length - 1);
  }
  const text = Buffer.from(JSON.stringify(scene));
  const json = Buffer.concat([text, Buffer.alloc(-text.length & 3, ' ')]);
  const rest = glb.subarray(JSON_HEADER + jsonBytes);
  const header = Buffer.from(glb.subarray(0, JSON_HEADER));
  header.writeUInt32LE(JSON_HEADER + json.length + rest.length, 8);
  header.writeUInt32LE(json.length, 12);
  return Buffer.concat([header, json, rest]);
}
