// What a shadow does with either renderer, without a GPU: both are the same to a page.

import { DirectionalLight, Group, Mesh, MeshLambertMaterial, Scene, SkinnedMesh } from 'three';
import type { DataTexture, Object3D, Texture, WebGLProgramParametersWithUniforms, WebGLRenderer } from 'three';
import type { NodeFrame } from 'three/webgpu';
import { describe, expect, test } from 'vitest';

import { BakedShadowFile } from '../../src/index.js';
import { soft } from '../../src/look-ups/index.js';
import { attachBakedShadow } from '../../src/webgl/index.js';
import type { BakedShadow, BakedShadowOptions } from '../../src/webgl/index.js';
import { BakedShadowNode } from '../../src/webgpu/index.js';
import { validBytes } from './vectors.js';

const file = new BakedShadowFile(validBytes('upright_depths'));

/** Words of a row of parameters: width of the filter, first term of the bias, cone of the sun, number of files in use. */
const [FILTER, BIAS, CONE, FILE_COUNT] = [96, 88, 97, 105];

/** A shadow in a scene of its own. */
interface Shown {
  readonly shadow: BakedShadow;
  readonly light: DirectionalLight;
  /** The texture of parameters that the GPU has. */
  readonly headers: DataTexture;
  /** Has done what comes before a frame. */
  frame(): void;
}

/** A light in a scene that WebGLRenderer draws. */
function webgl(options: BakedShadowOptions): Shown {
  const material = new MeshLambertMaterial();
  const light = new DirectionalLight();
  const scene = new Scene().add(light, light.target, new Mesh(undefined, material)) as Scene;
  const shadow = attachBakedShadow(scene, light, file, options);
  const shader = { fragmentShader: '#include <lights_fragment_begin>\n#include <normal_fragment_begin>\nvoid main() {}', uniforms: {} };
  material.onBeforeCompile(shader as unknown as WebGLProgramParametersWithUniforms, {} as WebGLRenderer);
  const uniforms = Object.entries(shader.uniforms as Record<string, { value: DataTexture }>);
  const headers = uniforms.find(([name]) => name.endsWith('_headers'))![1].value;
  const frame = (): void => {
    scene.updateMatrixWorld();
    (scene.onBeforeRender as () => void)();
  };
  return { shadow, light, headers, frame };
}

/** A light in a scene that WebGPURenderer draws. */
function webgpu(options: BakedShadowOptions): Shown {
  const light = new DirectionalLight();
  const scene = new Scene().add(light, light.target) as Scene;
  const shadow = new BakedShadowNode(light, { file, ...options });
  let headers: Texture | null = null;
  const renderer = { initTexture: (texture: Texture) => (headers = texture) };
  const frame = (): void => {
    scene.updateMatrixWorld();
    shadow.updateBefore({ renderer, scene } as unknown as NodeFrame);
  };
  frame();
  return { shadow, light, headers: headers! as DataTexture, frame };
}

/** The words of the parameters. */
function wordsOf({ headers }: Shown): Uint32Array {
  return headers.image.data as Uint32Array;
}

/** The bits of a 32-bit floating-point number. */
function bitsOf(value: number): number {
  return new Uint32Array(new Float32Array([value]).buffer)[0]!;
}

describe.each([
  ['WebGLRenderer', webgl],
  ['WebGPURenderer', webgpu],
])('%s', (_, show) => {
  test('options that are left out stay, and undefined is the default', () => {
    const shown = show({ filter: 9 });
    const words = wordsOf(shown);
    expect(words[FILTER]).toBe(9);
    shown.shadow.setOptions({ bias: { constantTexels: 4, slopeTexels: 2, normalOffsetTexels: 1 } });
    expect([words[FILTER], words[BIAS]]).toEqual([9, bitsOf(4)]);
    shown.shadow.setOptions({ filter: 3 });
    expect([words[FILTER], words[BIAS]]).toEqual([3, bitsOf(4)]);
    shown.shadow.setOptions({ filter: undefined });
    expect([words[FILTER], words[BIAS]]).toEqual([5, bitsOf(4)]);
    shown.shadow.dispose();
  });

  test('softness changes with the soft look-up', () => {
    const shown = show({ lookUp: soft });
    const words = wordsOf(shown);
    const before = words[CONE];
    shown.shadow.setOptions({ softnessDegrees: 2 });
    const after = words[CONE];
    expect(after).not.toBe(before);
    shown.shadow.setOptions({ bias: { constantTexels: 4, slopeTexels: 2, normalOffsetTexels: 1 } });
    expect([words[CONE], words[BIAS]]).toEqual([after, bitsOf(4)]);
    expect(() => shown.shadow.setOptions({ filter: 3 })).toThrow(RangeError);
    shown.shadow.dispose();
  });

  test.each([{ filter: 4 as 5 }, { softnessDegrees: 1 }, { bias: { constantTexels: NaN, slopeTexels: 0, normalOffsetTexels: 0 } }])(
    'options out of their range change nothing: %o',
    (options) => {
      const shown = show({ filter: 9 });
      const before = wordsOf(shown).slice();
      expect(() => shown.shadow.setOptions(options)).toThrow(RangeError);
      shown.shadow.setOptions({});
      expect(wordsOf(shown)).toEqual(before);
      shown.shadow.dispose();
    },
  );

  test('isActive tells where the light is, and changes nothing', () => {
    const shown = show({});
    const { shadow, light, headers } = shown;
    shown.frame();
    const [words, version] = [wordsOf(shown).slice(), headers.version];
    expect([shadow.isActive, words[FILE_COUNT]]).toEqual([true, 1]);
    light.position.negate();
    light.updateMatrixWorld();
    expect([shadow.isActive, shadow.isActive]).toEqual([false, false]);
    expect([wordsOf(shown), headers.version]).toEqual([words, version]);
    shown.frame();
    expect([shadow.isActive, wordsOf(shown)[FILE_COUNT]]).toEqual([false, 0]);
    light.position.negate();
    shown.frame();
    expect([shadow.isActive, wordsOf(shown)[FILE_COUNT]]).toEqual([true, 1]);
    shadow.dispose();
    expect(shadow.isActive).toBe(false);
  });

  test('what is added below a static root later casts no more from the next frame on', () => {
    const [city, street, house, lamp] = [new Group(), new Group(), caster(), caster()];
    const shown = show({ statics: city.add(street) });
    street.add(house.add(lamp));
    // As a page may do after it has added it.
    const late = new Mesh();
    street.add(late);
    late.castShadow = true;
    shown.frame();
    expect([house, lamp, late].map(({ castShadow }) => castShadow)).toEqual([false, false, false]);
    const sign = caster();
    lamp.add(sign);
    shown.frame();
    expect(sign.castShadow).toBe(false);
    shown.shadow.dispose();
    expect([house, lamp, late, sign].map(({ castShadow }) => castShadow)).toEqual([true, true, true, true]);
  });

  test('what moves, and what does not cast, stays as it is below a static root', () => {
    const city = new Group();
    const shown = show({ statics: city });
    const [walker, car, glass] = [Object.assign(new SkinnedMesh(), { castShadow: true }), caster(), new Mesh()];
    car.userData['adumbra'] = { cast: true };
    city.add(walker, car, glass);
    shown.frame();
    expect([walker, car, glass].map(({ castShadow }) => castShadow)).toEqual([true, true, false]);
    shown.shadow.dispose();
    expect([walker, car, glass].map(({ castShadow }) => castShadow)).toEqual([true, true, false]);
  });

  test('what goes from a static root casts again, with all below it', () => {
    const [city, street, house, lamp] = [new Group(), new Group(), caster(), caster()];
    const shown = show({ statics: city.add(street.add(house.add(lamp))) });
    shown.frame();
    expect([house, lamp].map(({ castShadow }) => castShadow)).toEqual([false, false]);
    street.remove(house);
    expect([house, lamp].map(({ castShadow }) => castShadow)).toEqual([true, true]);
    // Nothing is left behind that would follow it.
    const sign = caster();
    lamp.add(sign);
    shown.frame();
    expect([house, lamp, sign].map(({ castShadow }) => castShadow)).toEqual([true, true, true]);
    for (const object of [house, lamp]) expect(listeners(object)).toBe(0);
    city.add(house);
    shown.frame();
    expect([house, lamp, sign].map(({ castShadow }) => castShadow)).toEqual([false, false, false]);
    shown.shadow.dispose();
    expect([house, lamp, sign].map(({ castShadow }) => castShadow)).toEqual([true, true, true]);
    for (const object of [city, street, house, lamp, sign]) expect(listeners(object)).toBe(0);
  });

  test('what is added and goes again before a frame casts, alone or with what it is below', () => {
    const [city, street, house, lamp] = [new Group(), new Group(), caster(), caster()];
    const shown = show({ statics: city.add(street) });
    street.add(lamp);
    city.remove(street);
    city.add(house).remove(house);
    shown.frame();
    expect([house, lamp].map(({ castShadow }) => castShadow)).toEqual([true, true]);
    shown.shadow.dispose();
  });

  test('what was added and drawn goes with what it is below', () => {
    const [city, street, lamp] = [new Group(), new Group(), caster()];
    const shown = show({ statics: city.add(street) });
    street.add(lamp);
    shown.frame();
    city.remove(street);
    shown.frame();
    expect(lamp.castShadow).toBe(true);
    shown.shadow.dispose();
  });

  test('what is added after the last frame is let go as well', () => {
    const [city, house] = [new Group(), caster()];
    const shown = show({ statics: city });
    city.add(house);
    shown.shadow.dispose();
    shown.frame();
    expect([house.castShadow, listeners(house), listeners(city)]).toEqual([true, 0, 0]);
  });

  test('what is added while the light is elsewhere casts until it comes back', () => {
    const [city, house] = [new Group(), caster()];
    const shown = show({ statics: city });
    shown.light.position.negate();
    city.add(house);
    shown.frame();
    expect(house.castShadow).toBe(true);
    shown.light.position.negate();
    shown.frame();
    expect(house.castShadow).toBe(false);
    shown.shadow.dispose();
    expect(house.castShadow).toBe(true);
  });

  test('a root below another one stays a root when it goes from there', () => {
    const [city, house] = [new Group(), caster()];
    const shown = show({ statics: [city.add(house), house] });
    city.remove(house);
    shown.frame();
    expect(house.castShadow).toBe(false);
    shown.shadow.dispose();
    expect(house.castShadow).toBe(true);
  });

  test('two lights share what is added later', () => {
    const [city, house] = [new Group(), caster()];
    const [first, second] = [show({ statics: city }), show({ statics: city })];
    second.light.position.negate();
    city.add(house);
    for (const each of [first, second]) each.frame();
    expect(house.castShadow).toBe(true);
    second.light.position.negate();
    second.frame();
    expect(house.castShadow).toBe(false);
    first.shadow.dispose();
    expect(house.castShadow).toBe(false);
    second.light.position.negate();
    second.frame();
    expect(house.castShadow).toBe(true);
    second.shadow.dispose();
    expect(house.castShadow).toBe(true);
  });
});

/** An object that casts. */
function caster(): Mesh {
  return Object.assign(new Mesh(), { castShadow: true });
}

/** How many listeners an object has for children that come and go. */
function listeners(object: Object3D): number {
  const { _listeners: all = {} } = object as unknown as { _listeners?: Record<string, unknown[]> };
  return (all['childadded']?.length ?? 0) + (all['childremoved']?.length ?? 0);
}
