// The world: loaded from a GLB, with its static meshes merged so that a frame takes a few hundred draws, and
// put into a separate scene for each kind of shadows.

import { Box3, Color, DirectionalLight, Group, HemisphereLight, Mesh, Scene, Vector3 } from 'three';
import type { BufferGeometry, Light, Material, MeshStandardMaterial, Object3D } from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { mergeGeometries } from 'three/addons/utils/BufferGeometryUtils.js';
import { clone } from 'three/addons/utils/SkeletonUtils.js';

import { makeBus } from './bus.js';

/** Meshes are merged within squares of the ground, by default this many along each side, so that those out of sight can be left out. */
const SQUARES = 4;

/** The colour of the sky. */
export const SKY = new Color(0x9fb9d6);

/** The contents of a GLB. */
export interface World {
  readonly name: string;
  readonly root: Object3D;
  readonly box: Box3;
  /** Whether it is the city that comes with the page: it has a bus and a truth. */
  readonly isCity: boolean;
  /** Whether something in it moves; a bake leaves that out. */
  readonly isAnimated: boolean;
}

/** The world in a separate scene. */
export interface Stage {
  readonly scene: Scene;
  readonly sun: DirectionalLight;
  readonly sky: HemisphereLight;
  readonly statics: Object3D;
  readonly bus: Mesh | null;
  readonly materials: readonly Material[];
  readonly box: Box3;
}

/** Loads the city that comes with the page. Its meshes are merged within `squares` along each side. */
export async function loadCity(squares = SQUARES): Promise<World> {
  const { scene } = await new GLTFLoader().loadAsync('city.glb');
  return world('city.glb', scene, { isCity: true, isAnimated: false }, squares);
}

/**
 * Reads a GLB.
 *
 * @throws Error if it cannot be read, or has no mesh.
 */
export async function readWorld(name: string, bytes: ArrayBuffer): Promise<World> {
  const { scene, animations } = await new GLTFLoader().parseAsync(bytes, '');
  return world(name, scene, { isCity: false, isAnimated: animations.length > 0 });
}

function world(name: string, root: Object3D, kind: Pick<World, 'isCity' | 'isAnimated'>, squares = SQUARES): World {
  root.updateMatrixWorld(true);
  const box = new Box3().setFromObject(root);
  if (box.isEmpty()) throw new Error('it has no mesh');
  const lights: Object3D[] = [];
  root.traverse((object) => {
    if ((object as Partial<Light>).isLight === true) lights.push(object);
  });
  for (const light of lights) light.removeFromParent();
  merge(root, box, squares);
  return { name, root, box, ...kind };
}

/** Puts a world into a separate scene; geometries are shared with other scenes, materials are not. */
export function makeStage({ root, box, isCity }: World, towardsSun: Vector3): Stage {
  const scene = new Scene();
  scene.background = SKY;
  const statics = clone(root);
  const copies = new Map<Material, Material>();
  const copy = (material: Material): Material => {
    const known = copies.get(material) ?? material.clone();
    copies.set(material, known);
    return known;
  };
  statics.traverse((object) => {
    if (!(object instanceof Mesh)) return;
    object.material = Array.isArray(object.material) ? object.material.map(copy) : copy(object.material as Material);
    object.castShadow = true;
    object.receiveShadow = true;
  });
  const bus = isCity ? makeBus() : null;
  const sun = new DirectionalLight(0xfff3e0, 3.4);
  box.getCenter(sun.target.position);
  sun.position.copy(sun.target.position).addScaledVector(towardsSun, box.getSize(new Vector3()).length());
  const sky = new HemisphereLight(0xc4d8f2, 0x8d8275, 1.2);
  scene.add(statics, sun, sun.target, sky);
  if (bus !== null) scene.add(bus);
  const materials = [...copies.values(), ...(bus === null ? [] : [bus.material])];
  return { scene, sun, sky, statics, bus, materials, box };
}

/** Frees everything that a scene does not share. */
export function disposeStage({ scene, sun, materials }: Stage): void {
  for (const material of materials) material.dispose();
  sun.dispose();
  scene.clear();
}

/** Frees a world. */
export function disposeWorld({ root }: World): void {
  root.traverse((object) => {
    if (object instanceof Mesh) (object.geometry as BufferGeometry).dispose();
  });
}

/** Merges static meshes of one material that are near each other. Meshes of other kinds stay as they are. */
function merge(root: Object3D, box: Box3, squares: number): void {
  const size = box.getSize(new Vector3());
  const square = Math.max(size.x, size.z) / squares;
  const flat = new Map<BufferGeometry, BufferGeometry>();
  const heaps = new Map<string, { material: Material; geometries: BufferGeometry[] }>();
  const merged: Mesh[] = [];
  const middle = new Vector3();
  root.traverse((object) => {
    if (!(object instanceof Mesh) || !isPlain(object)) return;
    const mesh = object as Mesh<BufferGeometry, Material>;
    const source = flat.get(mesh.geometry) ?? withNormals(mesh);
    flat.set(mesh.geometry, source);
    const geometry = source.clone().applyMatrix4(mesh.matrixWorld);
    geometry.computeBoundingBox();
    geometry.boundingBox!.getCenter(middle);
    const place = [middle.x, middle.z].map((value) => Math.floor(value / square));
    const form = Object.entries(geometry.attributes).map(([name, { itemSize }]) => `${name}${itemSize}`);
    const key = [mesh.material.uuid, ...place, ...form.sort(), geometry.index === null].join(' ');
    const heap = heaps.get(key) ?? { material: mesh.material, geometries: [] };
    heap.geometries.push(geometry);
    heaps.set(key, heap);
    merged.push(mesh);
  });
  for (const mesh of merged) mesh.removeFromParent();
  const group = new Group();
  for (const { material, geometries } of heaps.values()) {
    (material as MeshStandardMaterial).flatShading = false;
    group.add(new Mesh(mergeGeometries(geometries), material));
  }
  // Merged positions already include the matrices of their meshes.
  group.applyMatrix4(root.matrixWorld.clone().invert());
  root.add(group);
  root.updateMatrixWorld(true);
}

/** Whether a mesh is static, and of a form that can be moved and merged. */
function isPlain(mesh: Mesh): boolean {
  const { geometry, material, matrixWorld, children } = mesh;
  return (
    !('isSkinnedMesh' in mesh || 'isInstancedMesh' in mesh || Array.isArray(material)) &&
    children.length === 0 &&
    Object.keys(geometry.morphAttributes).length === 0 &&
    matrixWorld.determinant() > 0 &&
    Object.values(geometry.attributes).every(({ array }) => array instanceof Float32Array) &&
    !Object.values(geometry.attributes).some((attribute) => 'isInterleavedBufferAttribute' in attribute)
  );
}

/** Returns a mesh's geometry with normals: its own, or those of its triangles. */
function withNormals({ geometry }: Mesh): BufferGeometry {
  if (geometry.hasAttribute('normal')) return geometry;
  const open = geometry.index === null ? geometry.clone() : geometry.toNonIndexed();
  open.computeVertexNormals();
  return open;
}
