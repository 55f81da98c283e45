// What attaching a file does to lights, materials and scenes of WebGLRenderer, without a GPU.

import { DirectionalLight, Group, Material, Mesh, MeshLambertMaterial, Scene, ShaderChunk, ShaderLib, ShaderMaterial, Vector3 } from 'three';
import type { WebGLProgramParametersWithUniforms, WebGLRenderer } from 'three';
import { afterEach, expect, test } from 'vitest';

import { BakedShadowFile } from '../../src/index.js';
import { attachBakedShadow } from '../../src/webgl/index.js';
import type { AttachedShadow } from '../../src/webgl/index.js';
import { validBytes } from './vectors.js';

const file = new BakedShadowFile(validBytes('upright_depths'));
const LAMBERT = ShaderLib.lambert.fragmentShader;

const attached: AttachedShadow[] = [];
afterEach(() => {
  for (const each of attached.splice(0)) each.dispose();
});

function attach(scene: Scene, options = {}): AttachedShadow {
  const shadow = attachBakedShadow(scene, new DirectionalLight(), file, options);
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

/** What three would compile. */
function compiled(material: Material, fragmentShader = LAMBERT) {
  const shader = { fragmentShader, uniforms: {} as Record<string, { value: unknown }> };
  material.onBeforeCompile(shader as unknown as WebGLProgramParametersWithUniforms, {} as WebGLRenderer);
  return shader;
}

/** How many look-ups there are in a text. */
function lookUps(fragmentShader: string, prefix = 'adumbra1'): number {
  return fragmentShader.split(`${prefix}_visibility( ${prefix}_p`).length - 1;
}

test('isActive leaves the direction that is drawn', () => {
  const { scene, material } = world();
  const light = new DirectionalLight();
  const shadow = attachBakedShadow(scene, light, file);
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
  attached.push(attachBakedShadow(new Scene(), light, file));
  const towards = light.getWorldPosition(new Vector3()).sub(light.target.getWorldPosition(new Vector3())).normalize();
  expect(towards.distanceTo(new Vector3(...file.grid.sun))).toBeLessThan(1e-6);
});

test('what is attached after dispose stays as it is', () => {
  const { scene, material } = world();
  const shadow = attach(scene);
  expect(lookUps(compiled(material).fragmentShader)).toBeGreaterThan(0);
  shadow.dispose();
  expect(shadow.isActive).toBe(false);
  shadow.attach(scene);
  expect(compiled(material).fragmentShader).toBe(LAMBERT);
  expect(material.onBeforeCompile).toBe(Material.prototype.onBeforeCompile);
});

test('a scene is as it was, in whatever order its shadows come and go', () => {
  const { scene } = world();
  const before = scene.onBeforeRender;
  let last = attach(scene);
  const hook = scene.onBeforeRender;
  for (let swap = 0; swap < 3; swap += 1) {
    const next = attach(scene);
    last.dispose();
    expect(scene.onBeforeRender).toBe(hook);
    last = next;
  }
  last.dispose();
  expect(scene.onBeforeRender).toBe(before);
});

test('a hook of a scene that comes later goes on being called', () => {
  const { scene } = world();
  const shadow = attach(scene);
  const ours = scene.onBeforeRender;
  const calls: string[] = [];
  scene.onBeforeRender = (...all) => {
    calls.push('later');
    ours.apply(scene, all);
  };
  shadow.dispose();
  attach(scene);
  (scene.onBeforeRender as () => void)();
  expect(calls).toEqual(['later']);
});

test('attach gives a material its shadow back that another hook has overwritten', () => {
  const { scene, material } = world();
  const shadow = attach(scene);
  const once = lookUps(compiled(material).fragmentShader);
  material.onBeforeCompile = (shader) => void (shader.fragmentShader = `// theirs\n${shader.fragmentShader}`);
  expect(lookUps(compiled(material).fragmentShader)).toBe(0);
  shadow.attach(scene);
  shadow.attach(scene);
  const { fragmentShader } = compiled(material);
  expect(fragmentShader).toContain('// theirs');
  expect(lookUps(fragmentShader)).toBe(once);
});

test('attach does not look up twice where a later hook calls the earlier one', () => {
  const { scene, material } = world();
  const shadow = attach(scene);
  const once = lookUps(compiled(material).fragmentShader);
  const ours = material.onBeforeCompile;
  material.onBeforeCompile = (shader, renderer) => ours.call(material, shader, renderer);
  shadow.attach(scene);
  expect(lookUps(compiled(material).fragmentShader)).toBe(once);
});

test('detach takes the shadows from a part of the world', () => {
  const { scene, mesh, material } = world();
  const other = world();
  scene.add(new Group().add(other.mesh));
  const shadow = attach(scene);
  shadow.detach(mesh);
  expect(compiled(material).fragmentShader).toBe(LAMBERT);
  expect(material.onBeforeCompile).toBe(Material.prototype.onBeforeCompile);
  expect(lookUps(compiled(other.material).fragmentShader)).toBeGreaterThan(0);
});

test('hooks of others between those of two lights tell programs apart', () => {
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

test('a shader with a loop of its own has one look-up, whatever is commented out', () => {
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
])('a shader with %s is left alone, and named', (_, text) => {
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
