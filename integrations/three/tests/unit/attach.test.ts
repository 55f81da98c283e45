// Effects of attaching a file on lights, materials and scenes of WebGLRenderer, without a GPU.

import {
  DirectionalLight,
  Group,
  Material,
  Matrix3,
  Mesh,
  MeshLambertMaterial,
  Object3D,
  Scene,
  ShaderChunk,
  ShaderLib,
  ShaderMaterial,
  Vector3,
} from 'three';
import type { Matrix4, WebGLProgramParametersWithUniforms, WebGLRenderer } from 'three';
import type { NodeFrame } from 'three/webgpu';
import { afterEach, expect, test, vi } from 'vitest';

import { BakedShadowFile } from '../../src/index.js';
import { attachBakedShadow } from '../../src/webgl/index.js';
import { BakedShadowNode } from '../../src/webgpu/index.js';
import type { AttachedShadow } from '../../src/webgl/index.js';
import { drawWithWebGL, webglRenderer } from './shown.js';
import { validBytes } from './vectors.js';

const file = new BakedShadowFile(validBytes('upright_depths'));
const LAMBERT = ShaderLib.lambert.fragmentShader;

const attached: AttachedShadow[] = [];
afterEach(() => {
  for (const each of attached.splice(0)) each.dispose();
});

function attach(scene: Scene, options = {}): AttachedShadow {
  const shadow = attachBakedShadow(scene, new DirectionalLight(), { file, ...options });
  attached.push(shadow);
  return shadow;
}

/** A scene with one mesh. */
function world(material: Material = new MeshLambertMaterial()) {
  const scene = new Scene();
  const mesh = new Mesh(undefined, material);
  scene.add(mesh);
  return { scene, mesh, material };
}

/** The shader that three would compile. */
function compiled(material: Material, fragmentShader = LAMBERT, vertexShader = 'void main() {}') {
  const shader = { fragmentShader, vertexShader, uniforms: {} as Record<string, { value: unknown }> };
  material.onBeforeCompile(shader as unknown as WebGLProgramParametersWithUniforms, {} as WebGLRenderer);
  return shader;
}

/** How many look-ups there are in a text. */
function lookUps(fragmentShader: string, prefix = 'adumbra1'): number {
  return fragmentShader.split(`${prefix}_visibility( ${prefix}_p`).length - 1;
}

test('isActive does not change the direction that is drawn', () => {
  const { scene, material } = world();
  const light = new DirectionalLight();
  const shadow = attachBakedShadow(scene, light, { file });
  attached.push(shadow);
  const { value } = compiled(material).uniforms['adumbra1_towards_light'] as { value: Vector3 };
  const drawn = value.clone();
  light.position.negate();
  light.updateMatrixWorld();
  expect(shadow.isActive).toBe(false);
  expect(value).toEqual(drawn);
});

test.each([
  ['moves around its target', (light: DirectionalLight) => new Scene().add(light.target)],
  ['turns with the target that it carries', (light: DirectionalLight) => light.add(light.target)],
])('a light below a turned parent %s', (_, place) => {
  const light = new DirectionalLight();
  light.target.position.set(1, -3, 2);
  place(light);
  const parent = new Group().add(light);
  parent.position.set(30, 0, -5);
  parent.rotation.set(0.4, 1.1, -0.3);
  attached.push(attachBakedShadow(new Scene(), light, { file }));
  const towards = light.getWorldPosition(new Vector3()).sub(light.target.getWorldPosition(new Vector3())).normalize();
  expect(towards.distanceTo(new Vector3(...file.grid.sun))).toBeLessThan(1e-6);
});

test('nothing is hooked again after dispose', () => {
  const { scene, material } = world();
  const shadow = attach(scene);
  expect(lookUps(compiled(material).fragmentShader)).toBeGreaterThan(0);
  shadow.dispose();
  expect(shadow.isActive).toBe(false);
  (scene.onBeforeRender as () => void)();
  expect(compiled(material).fragmentShader).toBe(LAMBERT);
  expect(material.onBeforeCompile).toBe(Material.prototype.onBeforeCompile);
});

test('the scene is restored after shadows that overlap have ended', () => {
  const { scene } = world();
  const { onBeforeRender, onAfterRender } = scene;
  let last = attach(scene);
  for (let swap = 0; swap < 3; swap += 1) {
    const next = attach(scene);
    last.dispose();
    last = next;
  }
  last.dispose();
  expect(scene).toMatchObject({ onBeforeRender, onAfterRender });
  for (const name of ['onBeforeRender', 'onAfterRender']) expect(Object.hasOwn(scene, name)).toBe(false);
});

/** Draws a frame. */
function frame(scene: Scene): void {
  drawWithWebGL(scene, webglRenderer());
}

test.each([
  ['that comes later', (_: Material, later: Material) => later],
  ['that is a clone', (material: Material) => material.clone()],
])('a material %s has the shadows from the next frame on', (_, make) => {
  const { scene, mesh, material } = world();
  attach(scene);
  frame(scene);
  mesh.material = make(material, new MeshLambertMaterial());
  frame(scene);
  expect(lookUps(compiled(mesh.material).fragmentShader)).toBe(2);
  // A page may copy the hook too.
  const copied = Object.assign(material.clone(), { onBeforeCompile: material.onBeforeCompile });
  mesh.material = copied;
  frame(scene);
  expect(lookUps(compiled(copied).fragmentShader)).toBe(2);
});

test('copied hooks keep the programs of their materials apart', () => {
  const { scene, mesh, material } = world();
  const { mesh: other, material: second } = world();
  scene.add(other);
  material.onBeforeCompile = (shader) => void (shader.fragmentShader += '// red');
  second.onBeforeCompile = (shader) => void (shader.fragmentShader += '// green');
  attach(scene);
  const [red, green] = [material, second].map((each) => Object.assign(each.clone(), { onBeforeCompile: each.onBeforeCompile }));
  expect(red!.customProgramCacheKey()).not.toBe(green!.customProgramCacheKey());
  mesh.material = red!;
  other.material = green!;
  frame(scene);
  expect(red!.customProgramCacheKey()).not.toBe(green!.customProgramCacheKey());
  expect(compiled(green!).fragmentShader).toContain('// green');
});

test('a deleted hook is restored in the next frame', () => {
  const { scene, material } = world();
  attach(scene);
  // Three's addon CSM does the same on dispose.
  delete (material as Partial<Material>).onBeforeCompile;
  expect(lookUps(compiled(material).fragmentShader)).toBe(0);
  frame(scene);
  expect(lookUps(compiled(material).fragmentShader)).toBe(2);
});

test('a later hook may replace the uniforms by a copy', () => {
  const { scene, material } = world();
  attach(scene);
  const ours = material.onBeforeCompile;
  const shader = { fragmentShader: LAMBERT, vertexShader: '', uniforms: { diffuse: { value: 1 } } as Record<string, { value: unknown }> };
  material.onBeforeCompile = (each, renderer) => {
    ours(each, renderer);
    each.uniforms = { ...each.uniforms, time: { value: 0 } };
  };
  material.onBeforeCompile(shader as unknown as WebGLProgramParametersWithUniforms, {} as WebGLRenderer);
  expect(Object.keys(shader.uniforms)).toEqual(expect.arrayContaining(['diffuse', 'adumbra1_words', 'time']));
});

test('missing materials are skipped, and overrideMaterial has the shadows', () => {
  const { scene, mesh } = world();
  attach(scene);
  Object.assign(mesh, { material: [undefined, new MeshLambertMaterial()] });
  scene.add(Object.assign(new Object3D(), { material: null, visible: false }));
  scene.overrideMaterial = new MeshLambertMaterial();
  frame(scene);
  expect(lookUps(compiled(scene.overrideMaterial).fragmentShader)).toBe(2);
});

test('a material that is no longer drawn is released', () => {
  const { scene, mesh, material } = world();
  attach(scene);
  scene.remove(mesh);
  for (let i = 0; i < 250; i += 1) frame(scene);
  expect(Object.hasOwn(material, 'onBeforeCompile')).toBe(false);
  scene.add(mesh);
  frame(scene);
  expect(lookUps(compiled(material).fragmentShader)).toBe(2);
});

test('another renderer or kind of shadow on the light does no harm', () => {
  const warn = vi.spyOn(console, 'warn').mockImplementation(() => undefined);
  const { scene } = world();
  const light = new DirectionalLight();
  scene.add(light);
  const node = new BakedShadowNode(light, { file });
  node.updateBefore({ renderer: null, scene } as unknown as NodeFrame);
  attached.push(attachBakedShadow(scene, light, { file }));
  drawWithWebGL(scene, {});
  expect(warn.mock.calls.filter(([text]) => String(text).includes('is for WebGLRenderer'))).toHaveLength(1);
  node.dispose();
  // A late call from three does not hook the scene again.
  node.updateBefore({ renderer: null, scene } as unknown as NodeFrame);
  attached.pop()!.dispose();
  expect(Object.hasOwn(scene, 'onBeforeRender')).toBe(false);
  warn.mockRestore();
});

test('a disposed material is released, and hooked again when drawn', () => {
  const { scene, mesh, material } = world();
  attach(scene);
  const { length } = listenersOf(material);
  expect(length).toBe(1);
  material.dispose();
  expect([Object.hasOwn(material, 'onBeforeCompile'), listenersOf(material).length]).toEqual([false, 0]);
  scene.remove(mesh);
  frame(scene);
  expect(Object.hasOwn(material, 'onBeforeCompile')).toBe(false);
  scene.add(mesh);
  frame(scene);
  expect(lookUps(compiled(material).fragmentShader)).toBe(2);
});

/** The listeners to a material's `dispose` event. */
function listenersOf(material: Material): unknown[] {
  return (material as unknown as { _listeners?: Record<string, unknown[]> })._listeners?.['dispose'] ?? [];
}

test('materials are not disposed, and are as they were after dispose', () => {
  const { scene, material } = world();
  let isDisposed = false;
  material.addEventListener('dispose', () => (isDisposed = true));
  const shadow = attach(scene);
  shadow.dispose();
  expect(isDisposed).toBe(false);
  for (const name of ['onBeforeCompile', 'customProgramCacheKey']) expect(Object.hasOwn(material, name)).toBe(false);
  expect(listenersOf(material)).toHaveLength(1);
});

test('a kept program gets the uniforms of a shadow attached again', () => {
  const { scene, material } = world();
  const renderer = webglRenderer();
  const first = attach(scene);
  const [{ uniforms }, key] = [compiled(material), material.customProgramCacheKey()];
  const kept = renderer.properties.get(material);
  kept['uniforms'] = uniforms;
  first.dispose();
  expect(uniforms['adumbra1_words']!.value).toBeNull();
  // Three may or may not compile the material without the shadow in between.
  for (const between of [{ diffuse: { value: 1 } }, uniforms]) {
    kept['uniforms'] = between;
    kept['uniformsList'] = [];
    const again = attach(scene);
    expect(material.customProgramCacheKey()).toBe(key);
    drawWithWebGL(scene, renderer);
    const now = kept['uniforms'] as typeof uniforms;
    expect(now['adumbra1_words']!.value).not.toBeNull();
    expect([kept['uniformsList'], now['diffuse']]).toEqual([null, between['diffuse']]);
    again.dispose();
  }
});

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

test('a light that is attached again has its shadow once', () => {
  const { scene, material } = world();
  const light = new DirectionalLight();
  scene.add(light);
  const [first, second] = [0, 1].map(() => attachBakedShadow(scene, light, { file }));
  attached.push(second!);
  const { fragmentShader, uniforms } = compiled(material);
  expect(fragmentShader.match(/adumbra\d+_visibility\( adumbra\d+_p/g)).toHaveLength(2);
  expect(Object.keys(uniforms)).toHaveLength(4);
  expect([first!.isActive, second!.isActive]).toEqual([false, true]);
  first!.dispose();
  expect(second!.isActive).toBe(true);
});

test('refuses a part of a scene, and a scene of another three', () => {
  const light = new DirectionalLight();
  expect(() => attachBakedShadow(new Group() as unknown as Scene, light, { file })).toThrow(/to the Scene that is drawn/);
  const { scene } = world();
  const foreign = Object.setPrototypeOf(Object.assign({}, scene), {}) as Scene;
  expect(() => attachBakedShadow(foreign, light, { file })).toThrow(/another copy of three/);
});

test('refuses a call without { file }, and a root that is not with its file', () => {
  const light = new DirectionalLight();
  const attach = attachBakedShadow as (...theirs: unknown[]) => void;
  for (const options of [{}, file, [file], { filter: 5 }]) {
    expect(() => attach(new Scene(), light, options)).toThrow(/give file/);
  }
  expect(() => attach(new Scene(), light, { file, root: new Group() })).toThrow(/file: \{ file, root \}/);
});

test('hooks that a page gives a material later are called, and stay after dispose', () => {
  const { scene, material } = world();
  const shadow = attach(scene);
  const once = lookUps(compiled(material).fragmentShader);
  const theirs: Material['onBeforeCompile'] = (shader) => void (shader.fragmentShader = `// theirs\n${shader.fragmentShader}`);
  const before = material.customProgramCacheKey();
  material.onBeforeCompile = theirs;
  expect(material.customProgramCacheKey()).not.toBe(before);
  const { fragmentShader } = compiled(material);
  expect(fragmentShader).toContain('// theirs');
  expect(lookUps(fragmentShader)).toBe(once);
  shadow.dispose();
  expect(material.onBeforeCompile).toBe(theirs);
});

test('a later hook that calls the earlier one adds no second look-up', () => {
  const { scene, material } = world();
  attach(scene);
  const once = lookUps(compiled(material).fragmentShader);
  const ours = material.onBeforeCompile;
  material.onBeforeCompile = (shader, renderer) => ours.call(material, shader, renderer);
  expect(lookUps(compiled(material).fragmentShader)).toBe(once);
});

test('foreign hooks between those of two lights keep programs apart', () => {
  const scene = new Scene();
  const materials = ['red', 'green'].map((name) => {
    const { mesh, material } = world();
    scene.add(mesh);
    return { name, material };
  });
  attach(scene);
  for (const { name, material } of materials) {
    const ours = material.onBeforeCompile;
    const theirs = { red: 'rgb.gb *= 0.0', green: 'rgb.rb *= 0.0' }[name]!;
    material.onBeforeCompile = new Function('ours', `return (...all) => { ours(...all); '${theirs}'; }`)(ours) as typeof ours;
  }
  attach(scene);
  const keys = materials.map(({ material }) => material.customProgramCacheKey());
  expect(keys[0]).not.toBe(keys[1]);
  expect(lookUps(compiled(materials[0]!.material).fragmentShader, 'adumbra2')).toBeGreaterThan(0);
});

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
