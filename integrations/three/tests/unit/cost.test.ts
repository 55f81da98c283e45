// The cost of a shadow when nothing changes: no object, material or program is touched without need.

import { BufferGeometry, DirectionalLight, Group, Mesh, MeshLambertMaterial, Scene } from 'three';
import { expect, test } from 'vitest';

import { BakedShadowFile } from '../../src/index.js';
import { attachBakedShadow } from '../../src/webgl/index.js';
import { drawWithWebGL, webglRenderer } from './shown.js';
import { validBytes } from './vectors.js';

const [OBJECTS, MATERIALS, DRAWINGS] = [10_000, 500, 60];

test('an unchanged scene is only traversed', () => {
  const [scene, city, sun] = [new Scene(), new Group(), new DirectionalLight()];
  const materials = Array.from({ length: MATERIALS }, () => new MeshLambertMaterial());
  const geometry = new BufferGeometry();
  for (let i = 0; i < OBJECTS; i += 1) city.add(Object.assign(new Mesh(geometry, materials[i % MATERIALS]), { castShadow: true }));
  scene.add(city, sun);
  attachBakedShadow(scene, sun, { file: new BakedShadowFile(validBytes('upright_depths')), statics: city });
  const renderer = webglRenderer();
  drawWithWebGL(scene, renderer);
  const versions = materials.map(({ version }) => version);
  const hooks = materials.map((material) => Object.getOwnPropertyDescriptor(material, 'onBeforeCompile')!.get);
  const milliseconds: Record<'shadow' | 'matrices', number[]> = { shadow: [], matrices: [] };
  let resting = 0;
  for (let i = 0; i < DRAWINGS; i += 1) {
    const start = performance.now();
    scene.updateMatrixWorld();
    const middle = performance.now();
    drawWithWebGL(scene, renderer, i === 0 ? () => (resting = city.children.filter(({ castShadow }) => !castShadow).length) : undefined);
    milliseconds.matrices.push(middle - start);
    milliseconds.shadow.push(performance.now() - middle);
  }
  expect(resting).toBe(OBJECTS);
  expect(city.children.every(({ castShadow }) => castShadow)).toBe(true);
  expect(materials.map(({ version }) => version)).toEqual(versions);
  expect(materials.map((material) => Object.getOwnPropertyDescriptor(material, 'onBeforeCompile')!.get)).toEqual(hooks);
  // A drawing updates matrices as well.
  const median = (values: number[]): number => values.sort((a, b) => a - b)[DRAWINGS / 2]!;
  const [all, matrices] = [median(milliseconds.shadow), median(milliseconds.matrices)];
  console.log(`${OBJECTS} objects of ${MATERIALS} materials: ${(all - matrices).toFixed(2)} ms per drawing, beside ${matrices.toFixed(2)} ms of updateMatrixWorld`);
});
