// Several renderers and scenes, materials of all kinds, and objects that a glTF file animates.

import { AnimationClip, DirectionalLight, Group, Mesh, MeshLambertMaterial, NumberKeyframeTrack, OrthographicCamera, PerspectiveCamera, RawShaderMaterial, Scene, ShaderLib } from 'three';
import type { Material, WebGLProgramParametersWithUniforms, WebGLRenderer } from 'three';
import type { NodeFrame } from 'three/webgpu';
import { describe, expect, test } from 'vitest';

import { GLTFBakedShadow } from '../../src/gltf/index.js';
import { moves } from '../../src/light/statics.js';
import { attachBakedShadow } from '../../src/webgl/index.js';
import { BakedShadowNode } from '../../src/webgpu/index.js';
import { drawWithWebGL, webglRenderer } from './shown.js';
import { caster, compiled, drawFrom, file, keepWarnings, lookUps } from './situations.js';

const warnings = keepWarnings();

describe('several renderers and scenes', () => {
  test('maps that two renderers have frozen are drawn anew in both', () => {
    const [scene, light, city, house] = [new Scene(), new DirectionalLight(), new Group(), caster()];
    scene.add(light, light.target, city.add(house));
    const shadow = attachBakedShadow(scene, light, { file, statics: city });
    const renderers = [webglRenderer(), webglRenderer()] as (ReturnType<typeof webglRenderer> & { shadowMap: { needsUpdate?: boolean } })[];
    const redrawn = renderers.map((renderer) => {
      drawWithWebGL(scene, renderer);
      return renderer.shadowMap.needsUpdate ?? false;
    });
    shadow.dispose();
    expect(redrawn).toEqual([true, true]);
    expect(renderers.map(({ shadowMap }) => shadowMap.needsUpdate)).toEqual([true, true]);
  });

  test('a mask in a scene that the sun has left has no shadow of it', () => {
    const [scene, light, material] = [new Scene(), new DirectionalLight(), new MeshLambertMaterial()];
    scene.add(light, new Mesh(undefined, material));
    const shadow = attachBakedShadow(scene, light, { file });
    const uniforms = compiled(material).uniforms;
    const intensity = Object.entries(uniforms).find(([key]) => key.endsWith('_intensity'))![1];
    const drawn: unknown[] = [];
    drawWithWebGL(scene, webglRenderer(), () => drawn.push(intensity.value));
    new Scene().add(light);
    drawWithWebGL(scene, webglRenderer(), () => drawn.push(intensity.value));
    shadow.dispose();
    expect(drawn).toEqual([1, 0]);
  });

  test('a light that is attached in its next scene leaves the one before', () => {
    const [one, two, light, material] = [new Scene(), new Scene(), new DirectionalLight(), new MeshLambertMaterial()];
    one.add(light, new Mesh(undefined, material));
    two.add(new Mesh(undefined, material));
    const first = attachBakedShadow(one, light, { file });
    drawWithWebGL(one, webglRenderer());
    two.add(light);
    const second = attachBakedShadow(two, light, { file });
    drawWithWebGL(two, webglRenderer());
    const count = lookUps(compiled(material).fragmentShader);
    const active = [first.isActive, second.isActive];
    first.dispose();
    second.dispose();
    expect([active, count]).toEqual([[false, true], 2]);
  });

  test('a scene within the scene that is drawn is warned of', () => {
    const [outer, inner, light] = [new Scene(), new Scene(), new DirectionalLight()];
    outer.add(inner.add(light, light.target));
    const shadow = attachBakedShadow(inner, light, { file });
    expect(warnings()).toMatch(/the Scene that is drawn/);
    shadow.dispose();
  });
});

describe('WebGPURenderer alone', () => {
  /** A light with a shadow node, attached as in an app. */
  function nodeWorld() {
    const [scene, light, city, house] = [new Scene(), new DirectionalLight(), new Group(), caster()];
    light.castShadow = true;
    scene.add(light, light.target, city.add(house));
    const node = new BakedShadowNode(light, { file, statics: city });
    light.shadow.shadowNode = node;
    /** A frame. Three asks the node only while the light has it. */
    const frame = (map: DirectionalLight, camera: object = new PerspectiveCamera()): boolean => {
      scene.updateMatrixWorld();
      let casts = true;
      drawFrom(scene, {}, camera, () => {
        if ((light.shadow.shadowNode as unknown) === node) node.updateBefore({ renderer: {}, scene } as unknown as NodeFrame);
        map.shadow.updateMatrices(map);
        drawFrom(scene, {}, map.shadow.camera, () => (casts = house.castShadow));
      });
      return casts;
    };
    return { scene, light, house, node, frame };
  }

  test('castShadow is restored after compileAsync, which ends no drawing', async () => {
    const { scene, light, house, node, frame } = nodeWorld();
    frame(light);
    const camera = new OrthographicCamera();
    camera.position.set(...file.grid.sun);
    camera.lookAt(0, 0, 0);
    camera.updateMatrixWorld();
    (scene.onBeforeRender as (...all: unknown[]) => void)({}, scene, camera);
    await Promise.resolve();
    expect(house.castShadow).toBe(true);
    node.dispose();
  });
});

describe('materials of WebGLRenderer', () => {
  function world(material: Material) {
    const [scene, light, mesh] = [new Scene(), new DirectionalLight(), new Mesh(undefined, material)];
    scene.add(light, light.target, mesh);
    const shadow = attachBakedShadow(scene, light, { file });
    return { scene, light, mesh, shadow };
  }

  test.each(['lambert', 'phong', 'toon', 'standard', 'physical'] as const)('%s has the look-up', (name) => {
    const material = new MeshLambertMaterial();
    const { shadow } = world(material);
    const count = lookUps(compiled(material, ShaderLib[name].fragmentShader).fragmentShader);
    shadow.dispose();
    expect(count).toBe(2);
  });

  test('GLSL of WebGL 1 in a RawShaderMaterial is not changed', () => {
    const material = new RawShaderMaterial({ lights: true });
    const { shadow } = world(material);
    const text = 'precision highp float;\n#include <common>\n#include <lights_pars_begin>\nvoid main() {\n  vec3 geometryPosition = vec3( 0.0 );\n  vec3 nonPerturbedNormal = vec3( 0.0 );\n  #include <lights_fragment_begin>\n}';
    const { fragmentShader } = compiled(material, text, { isRawShaderMaterial: true, glslVersion: null });
    const { skipped } = shadow;
    shadow.dispose();
    expect([fragmentShader, skipped]).toEqual([text, ['RawShaderMaterial']]);
  });

  test('a derived material, as troika makes it, has the look-up', () => {
    const base = new MeshLambertMaterial();
    const { scene, mesh, shadow } = world(base);
    const theirs = function (this: Material, shader: WebGLProgramParametersWithUniforms, renderer: WebGLRenderer): void {
      base.onBeforeCompile.call(this, shader, renderer);
      shader.fragmentShader += '// derived';
    };
    const derived = Object.create(base, {
      _listeners: { value: undefined, writable: true },
      onBeforeCompile: { get: () => theirs, set: () => undefined, configurable: true },
    }) as Material;
    (mesh as Mesh).material = derived;
    drawWithWebGL(scene, webglRenderer());
    const { fragmentShader } = compiled(derived);
    shadow.dispose();
    expect([lookUps(fragmentShader), fragmentShader.includes('// derived')]).toEqual([2, true]);
    expect(lookUps(compiled(derived).fragmentShader)).toBe(0);
  });

  test('a material that is disposed during a drawing has the shadows in the next', () => {
    const material = new MeshLambertMaterial();
    const { scene, shadow } = world(material);
    drawWithWebGL(scene, webglRenderer(), () => material.dispose());
    drawWithWebGL(scene, webglRenderer());
    const count = lookUps(compiled(material).fragmentShader);
    shadow.dispose();
    expect(count).toBe(2);
  });

  test('a growing list of materials is hooked, customDepthMaterial not', () => {
    const [first, second, depth] = [new MeshLambertMaterial(), new MeshLambertMaterial(), new MeshLambertMaterial()];
    const { scene, mesh, shadow } = world(first);
    const list = [first];
    Object.assign(mesh, { material: list });
    mesh.customDepthMaterial = depth;
    drawWithWebGL(scene, webglRenderer());
    list.push(second);
    drawWithWebGL(scene, webglRenderer());
    const counts = [first, second, depth].map((each) => lookUps(compiled(each).fragmentShader));
    shadow.dispose();
    expect(counts).toEqual([2, 2, 0]);
  });
});

test('nodes that a glTF file animates are marked as movers', async () => {
  const scene = new Group();
  const mill = caster('mill');
  scene.add(mill);
  const animations = [new AnimationClip('turn', 1, [new NumberKeyframeTrack('mill.rotation[y]', [0, 1], [0, 1])])];
  const parser = { options: { manager: undefined, path: '', requestHeader: {} } };
  await new GLTFBakedShadow(parser as never, () => undefined).afterRoot({ scenes: [scene], scene, animations } as never);
  expect(moves(mill)).toBe(true);
});
