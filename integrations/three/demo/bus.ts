// The bus, which casts and receives shadows, and the streets that it drives along.

import { BoxGeometry, BufferAttribute, Color, CylinderGeometry, Mesh, MeshStandardMaterial } from 'three';
import type { BufferGeometry, Object3D } from 'three';
import { mergeGeometries } from 'three/addons/utils/BufferGeometryUtils.js';

/** Metres per second. */
const SPEED = 8;

/** Once around a block of the city, on its right-hand lane, and so clockwise seen from above. */
const ROUTE = { west: -117.2, east: -42.8, north: 42.8, south: 117.2, radius: 9 };

const PAINT = 0xd8462f;
const CREAM = 0xf2e8d5;
const GLASS = 0x16202b;
const RUBBER = 0x191919;

/** Makes the geometry of a bus of 11 × 3 × 2.5 m, which heads towards +x and stands at y = 0. */
function busGeometry(): BufferGeometry {
  const box = (colour: number, size: [number, number, number], at: [number, number, number]): BufferGeometry =>
    painted(new BoxGeometry(...size).translate(...at), colour);
  const wheel = (x: number, z: number): BufferGeometry =>
    painted(new CylinderGeometry(0.5, 0.5, 0.3, 20).rotateX(Math.PI / 2).translate(x, 0.5, z), RUBBER);
  return mergeGeometries([
    box(PAINT, [11, 1.1, 2.5], [0, 0.9, 0]),
    box(GLASS, [10.96, 1.0, 2.46], [0, 1.95, 0]),
    box(CREAM, [11, 0.45, 2.5], [0, 2.675, 0]),
    box(CREAM, [3, 0.25, 1.6], [-2.5, 3.02, 0]),
    ...[-5.4, -3.2, -1, 1.2, 3.4, 5.4].flatMap((x) => [-1.2, 1.2].map((z) => box(CREAM, [0.16, 1.0, 0.1], [x, 1.95, z]))),
    ...[-3.4, 3.6].flatMap((x) => [-1.12, 1.12].map((z) => wheel(x, z))),
  ]);
}

function painted(geometry: BufferGeometry, colour: number): BufferGeometry {
  const { count } = geometry.getAttribute('position');
  const { r, g, b } = new Color(colour);
  const colours = new Float32Array(3 * count);
  for (let i = 0; i < count; i += 1) colours.set([r, g, b], 3 * i);
  return geometry.setAttribute('color', new BufferAttribute(colours, 3));
}

let shared: BufferGeometry | undefined;

/** Makes a bus; all have one geometry. */
export function makeBus(): Mesh<BufferGeometry, MeshStandardMaterial> {
  shared ??= busGeometry();
  const bus = new Mesh(shared, new MeshStandardMaterial({ vertexColors: true, roughness: 1 }));
  bus.name = 'bus';
  bus.castShadow = true;
  bus.receiveShadow = true;
  // Never cull the bus: depth passes are counted by its draws.
  bus.frustumCulled = false;
  return bus;
}

/** Puts a bus where it is after some seconds. */
export function drive(bus: Object3D, seconds: number): void {
  const { west, east, north, south, radius } = ROUTE;
  const turn = (Math.PI / 2) * radius;
  const sides = [south - north, east - west, south - north, east - west].map((length) => length - 2 * radius);
  const lap = sides.reduce((sum, side) => sum + side + turn, 0);
  // Middles of the turns; the first side goes north along the west of the block.
  const middles = [
    [west + radius, north + radius],
    [east - radius, north + radius],
    [east - radius, south - radius],
    [west + radius, south - radius],
  ] as const;
  let rest = (seconds * SPEED) % lap;
  for (const [i, side] of sides.entries()) {
    const [x, z] = middles[i]!;
    // The angle of the direction out of the turn's middle, from +x towards +z: west on the first side, then
    // north, …
    const out = Math.PI + (i * Math.PI) / 2;
    const angle = rest <= side ? out : out + Math.min(rest - side, turn) / radius;
    const behind = Math.max(side - rest, 0);
    if (rest <= side + turn) {
      // The bus heads at a right angle to that direction.
      const heading = angle + Math.PI / 2;
      bus.position.set(
        x + radius * Math.cos(angle) - behind * Math.cos(heading),
        0,
        z + radius * Math.sin(angle) - behind * Math.sin(heading),
      );
      bus.rotation.y = -heading;
      return;
    }
    rest -= side + turn;
  }
}
