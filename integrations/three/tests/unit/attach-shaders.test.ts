// Shaders of materials of WebGLRenderer in a scene that has a file attached, without a GPU.

import { DirectionalLight, Group, Matrix3, MeshLambertMaterial, Object3D, ShaderChunk, ShaderLib, ShaderMaterial, Vector3 } from 'three';
import type { Material, Matrix4, WebGLProgramParametersWithUniforms, WebGLRenderer } from 'three';
import { afterEach, expect, test, vi } from 'vitest';

import { attachBakedShadow } from '../../src/webgl/index.js';
import { LAMBERT, attach, attached, compiled, disposeAttached, file, frame, lookUps, world } from './attaching.js';
import { drawWithWebGL, webglRenderer } from './shown.js';

afterEach(disposeAttached);

const OWN_LOOP = `
#include <lights_pars_begin>
void main() {
  #include <normal_fragment_begin>
  vec3 geometryPosition = - vViewPosition;
  // #include <lights_fragment_begin>
  IncidentLight directLight;
  DirectionalLight directionalLight = directionalLights[ 0 ];
  getDirectionalLightInfo( directionalLight, directLight );
}`;

test('a ShaderMaterial keeps its uniforms, and its clone has the shadows', () => {
  const { scene, mesh, material } = world(new ShaderMaterial({ lights: true, uniforms: { height: { value: 3 } } }));
  const shadow = attach(scene);
  const { uniforms } = material as ShaderMaterial;
  const shader = { fragmentShader: OWN_LOOP, vertexShader: '', uniforms };
  material.onBeforeCompile(shader as unknown as WebGLProgramParametersWithUniforms, {} as WebGLRenderer);
  expect(Object.keys(uniforms)).toEqual(['height']);
  // Three finds the value that the page sets later.
  uniforms['height'] = { value: 4 };
  expect(shader.uniforms['height']).toBe(uniforms['height']);
  expect(shader.uniforms).toHaveProperty('adumbra1_words');
  mesh.material = material.clone();
  frame(scene);
  expect(lookUps(compiled(mesh.material, OWN_LOOP).fragmentShader)).toBe(1);
  shadow.dispose();
  expect(Object.keys((mesh.material as ShaderMaterial).uniforms)).toEqual(['height']);
});

test('a shader with a custom loop has one look-up, despite comments', () => {
  const { scene, material } = world(new ShaderMaterial({ lights: true }));
  attach(scene);
  const { fragmentShader } = compiled(material, OWN_LOOP);
  expect(lookUps(fragmentShader)).toBe(1);
  expect(fragmentShader).toContain('// #include <lights_fragment_begin>');
});

test.each([
  ['no normal', OWN_LOOP.replace('#include <normal_fragment_begin>', 'vec3 normal = vNormal;')],
  ['no position', OWN_LOOP.replace('vec3 geometryPosition', 'vec3 p')],
  ['no light', OWN_LOOP.replace(/getDirectionalLightInfo.*/, '')],
])('a shader with %s is not changed, and is listed in skipped', (_, text) => {
  const { scene, material } = world(new ShaderMaterial({ lights: true, name: 'theirs' }));
  const shadow = attach(scene);
  const { fragmentShader, uniforms } = compiled(material, text);
  expect(fragmentShader).toBe(text);
  expect(uniforms).toEqual({});
  expect(shadow.skipped).toEqual(['theirs']);
});

/** The chunk that the addon CSM of a version of three puts in place of three's own. */
async function chunkOfCsm(three: string): Promise<string> {
  const { CSMShader } = (await import(`${three}/examples/jsm/csm/CSMShader.js`)) as { CSMShader: Record<string, string> };
  return CSMShader['lights_fragment_begin']!;
}

test.each([
  ['three', async () => ShaderChunk.lights_fragment_begin, 2],
  ['CSM of 0.187', () => chunkOfCsm('three'), 6],
  ['CSM of 0.183', () => chunkOfCsm('three-183'), 5],
  ['CSM of 0.166', () => chunkOfCsm('three-166'), 5],
])('the chunk of %s has a look-up at each light', async (_, chunk, places) => {
  const { scene, material } = world();
  attach(scene);
  const { lights_fragment_begin } = ShaderChunk;
  ShaderChunk.lights_fragment_begin = await chunk();
  try {
    expect(lookUps(compiled(material).fragmentShader)).toBe(places);
  } finally {
    ShaderChunk.lights_fragment_begin = lights_fragment_begin;
  }
});

/** A shader with a mask, as in the addon `Water`. */
const WATER = `
#include <lights_pars_begin>
#include <shadowmask_pars_fragment>
void main() {
  gl_FragColor = vec4( getShadowMask() );
}`;

test.each([
  ['ShadowMaterial', ShaderLib.shadow.fragmentShader, ShaderLib.shadow.vertexShader],
  ['a mask', WATER, 'void main() {\n  gl_Position = projectionMatrix * modelViewMatrix * vec4( position, 1.0 );\n}'],
])('%s has the look-ups of two lights in its mask', (_, fragment, vertex) => {
  const { scene, material } = world(new ShaderMaterial({ lights: true }));
  const shadows = [attach(scene), attach(scene)];
  const { fragmentShader, vertexShader, uniforms } = compiled(material, fragment, vertex);
  for (const prefix of ['adumbra1', 'adumbra2']) {
    expect(fragmentShader.split(`${prefix}_visibility( bakedShadowPosition`)).toHaveLength(2);
    expect(uniforms).toHaveProperty(`${prefix}_headers`);
    // The original mask is still called.
    expect(fragmentShader).toContain(`float ${prefix}_mask() {`);
    expect(fragmentShader).toContain(`return ${prefix}_mask() * mix`);
  }
  expect(fragmentShader.match(/float getShadowMask\(\) \{/g)).toHaveLength(1);
  expect(vertexShader.match(/varying highp vec3 bakedShadowPosition;/g)).toHaveLength(1);
  expect(vertexShader.trimEnd().endsWith('}')).toBe(true);
  expect(shadows.flatMap(({ skipped }) => skipped)).toEqual([]);
});

test('a mask has no shadow of a sun that does not shine', () => {
  const { scene, material } = world();
  const light = new DirectionalLight();
  scene.add(light);
  attached.push(attachBakedShadow(scene, light, { file }));
  const uniforms = (): Record<string, { value: unknown }> => compiled(material).uniforms;
  const intensities = (): unknown[] => {
    let drawn: unknown;
    drawWithWebGL(scene, webglRenderer(), () => (drawn = uniforms()['adumbra1_intensity']!.value));
    // Other scenes may draw the material afterwards.
    return [drawn, uniforms()['adumbra1_intensity']!.value];
  };
  expect(intensities()).toEqual([1, 0]);
  light.visible = false;
  expect(intensities()).toEqual([0, 0]);
  light.visible = true;
  expect(intensities()).toEqual([1, 0]);
  scene.remove(light);
  expect(intensities()).toEqual([0, 0]);
});

test('materials without lights are neither changed nor listed', () => {
  const { scene, material } = world(new ShaderMaterial());
  const shadow = attach(scene);
  for (const name of ['basic', 'points', 'sprite'] as const) {
    const text = ShaderLib[name].fragmentShader;
    expect(compiled(material, text)).toMatchObject({ fragmentShader: text, uniforms: {} });
  }
  expect(shadow.skipped).toEqual([]);
});

test('a material that is skipped is warned of once', () => {
  const warn = vi.spyOn(console, 'warn').mockImplementation(() => undefined);
  const { scene, material } = world(new ShaderMaterial({ lights: true, name: 'grass' }));
  attach(scene);
  for (let time = 0; time < 2; time += 1) compiled(material, OWN_LOOP.replace('vec3 geometryPosition', 'vec3 p'));
  expect(warn.mock.calls).toEqual([[expect.stringContaining("'grass' is not lit as three's own are")]]);
  warn.mockRestore();
});

test('the look-up asks for 32 bits, and restores the precision', () => {
  const { scene, material } = world(new MeshLambertMaterial({ precision: 'mediump' }));
  attach(scene);
  const shader = { fragmentShader: LAMBERT, vertexShader: 'void main() {}', uniforms: {}, precision: 'mediump' };
  material.onBeforeCompile(shader as unknown as WebGLProgramParametersWithUniforms, {} as WebGLRenderer);
  const [high, look, back, main] = ['precision highp int;', 'float adumbra1_visibility(', 'precision mediump int;', 'void main()'].map((part) =>
    shader.fragmentShader.indexOf(part),
  );
  expect([high! >= 0, high! < look!, look! < back!, back! < main!]).toEqual([true, true, true, true]);
});

/** The position and the direction that the GLSL computes from three's values, for a view matrix. */
function worldFromView(view: Matrix4, pView: Vector3, nView: Vector3): { p: Vector3; n: Vector3 } {
  const m = new Matrix3().setFromMatrix4(view);
  const columns = [0, 1, 2].map((i) => new Vector3().fromArray(m.elements, 3 * i));
  const s = columns.reduce((sum, column) => sum.add(column.clone().multiply(column)), new Vector3());
  const rows = m.clone().transpose();
  const from = pView.clone().sub(new Vector3().setFromMatrixPosition(view)).divide(s);
  return { p: from.applyMatrix3(rows), n: nView.clone().applyMatrix3(rows).normalize() };
}

test('a camera below a scaled rig has the same positions and normals', () => {
  const rig = new Group();
  rig.scale.set(2, 0.5, 3);
  rig.rotation.set(0.3, 1, -0.4);
  rig.position.set(5, -7, 11);
  const camera = new Object3D();
  camera.position.set(1, 2, 3);
  rig.add(camera).updateMatrixWorld(true);
  const view = camera.matrixWorld.clone().invert();
  const [p, n] = [new Vector3(30, 4, -20), new Vector3(1, 2, -2).normalize()];
  const nView = n.clone().applyMatrix3(new Matrix3().getNormalMatrix(view)).normalize();
  const found = worldFromView(view, p.clone().applyMatrix4(view), nView);
  expect(found.p.distanceTo(p)).toBeLessThan(1e-9);
  expect(found.n.distanceTo(n)).toBeLessThan(1e-9);
  // The shader has the formulas computed above.
  const { fragmentShader } = compiled(attachedWorld());
  for (const line of [
    'mat3 adumbra1_m = mat3( viewMatrix );',
    'vec3 adumbra1_s = adumbra1_m[ 0 ] * adumbra1_m[ 0 ] + adumbra1_m[ 1 ] * adumbra1_m[ 1 ] + adumbra1_m[ 2 ] * adumbra1_m[ 2 ];',
    'vec3 adumbra1_p = ( ( geometryPosition - viewMatrix[ 3 ].xyz ) / adumbra1_s ) * adumbra1_m;',
    'vec3 adumbra1_n = normalize( nonPerturbedNormal * adumbra1_m );',
  ]) {
    expect(fragmentShader).toContain(line);
  }
});

/** A material of a scene that has a shadow. */
function attachedWorld(): Material {
  const { scene, material } = world();
  attach(scene);
  return material;
}
