// Behaviour of a shadow with either renderer, without a GPU: both are the same to a page.

import { Group } from 'three';
import { describe, expect, test, vi } from 'vitest';

import { BakedShadowFile, LookUpTexture, placedGrid } from '../../src/index.js';
import { soft } from '../../src/look-ups/index.js';
import { RENDERERS } from './shown.js';
import type { Shown } from './shown.js';
import { validBytes } from './vectors.js';

const file = new BakedShadowFile(validBytes('upright_depths'));

/** Words of a row of parameters: width of the filter, first term of the bias, cone of the sun, number of files in use. */
const [FILTER, BIAS, CONE, FILE_COUNT] = [96, 88, 97, 105];

/** The words of the parameters. */
function wordsOf({ headers }: Shown): Uint32Array {
  return headers().image.data as Uint32Array;
}

/** The bits of a 32-bit floating-point number. */
function bitsOf(value: number): number {
  return new Uint32Array(new Float32Array([value]).buffer)[0]!;
}

describe.each(RENDERERS)('%s', (name, show) => {
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

  test('sunDegrees changes with the soft look-up', () => {
    const shown = show({ lookUp: soft });
    const words = wordsOf(shown);
    const before = words[CONE];
    shown.shadow.setOptions({ sunDegrees: 2 });
    const after = words[CONE];
    expect(after).not.toBe(before);
    shown.shadow.setOptions({ bias: { constantTexels: 4, slopeTexels: 2, normalOffsetTexels: 1 } });
    expect([words[CONE], words[BIAS]]).toEqual([after, bitsOf(4)]);
    expect(() => shown.shadow.setOptions({ filter: 3 })).toThrow(RangeError);
    shown.shadow.dispose();
  });

  test.each([{ filter: 4 as 5 }, { sunDegrees: 1 }, { bias: { constantTexels: NaN, slopeTexels: 0, normalOffsetTexels: 0 } }])(
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

  test('isActive follows the light, and changes nothing', () => {
    const shown = show({ align: false });
    const { shadow, light, headers } = shown;
    light.position.set(...file.grid.sun);
    shown.frame();
    const [words, version] = [wordsOf(shown).slice(), headers().version];
    expect([shadow.isActive, words[FILE_COUNT]]).toEqual([true, 1]);
    light.position.negate();
    light.updateMatrixWorld();
    expect([shadow.isActive, shadow.isActive]).toEqual([false, false]);
    expect([wordsOf(shown), headers().version]).toEqual([words, version]);
    shown.frame();
    expect([shadow.isActive, wordsOf(shown)[FILE_COUNT]]).toEqual([false, 0]);
    light.position.negate();
    shown.frame();
    expect([shadow.isActive, wordsOf(shown)[FILE_COUNT]]).toEqual([true, 1]);
    shadow.dispose();
    expect(shadow.isActive).toBe(false);
  });

  test('a file follows its root, and the light is turned to the sun there', () => {
    const city = new Group();
    city.position.set(30, -2, 7);
    city.rotation.y = 0.7;
    city.scale.setScalar(0.1);
    const shown = show({}, { file, root: city });
    shown.frame();
    expect([shown.shadow.isActive, wordsOf(shown)[FILE_COUNT]]).toEqual([true, 1]);
    const sun = placedGrid(file.grid, city.matrixWorld.elements).sun;
    const towards = shown.light.position.clone().normalize();
    expect(Math.hypot(towards.x - sun[0], towards.y - sun[1], towards.z - sun[2])).toBeLessThan(1e-6);
    const expected = (): number[] => {
      const placement = city.matrixWorld.elements;
      return [...new LookUpTexture(file, 8192, { filter: 5, placement }).header.subarray(0, 104)];
    };
    expect([...wordsOf(shown).subarray(0, 104)]).toEqual(expected());
    // The root moves on, and options do not affect its placement.
    city.position.x += 5;
    city.scale.setScalar(3);
    shown.frame();
    expect([...wordsOf(shown).subarray(0, 104)]).toEqual(expected());
    shown.shadow.setOptions({ filter: 5 });
    expect([...wordsOf(shown).subarray(0, 104)]).toEqual(expected());
    // The sun and the light turn with the root. There is no warning, because the app has not turned the
    // light.
    const warn = vi.spyOn(console, 'warn').mockImplementation(() => undefined);
    city.rotation.y += 0.3;
    shown.frame();
    expect([shown.shadow.isActive, wordsOf(shown)[FILE_COUNT]]).toEqual([true, 1]);
    expect(warn).not.toHaveBeenCalled();
    warn.mockRestore();
    shown.shadow.dispose();
  });

  test('one file may be in several places, and in none that it cannot follow', () => {
    const [here, there, wide] = [new Group(), new Group(), new Group()];
    there.position.x = 500;
    wide.scale.x = 2;
    wide.name = 'wide';
    const said = vi.spyOn(console, 'warn').mockImplementation(() => undefined);
    const shown = show({}, [{ file, root: here }, { file, root: there }, { file, root: wide }]);
    shown.frame();
    shown.frame();
    expect(wordsOf(shown)[FILE_COUNT]).toBe(2);
    const anchors = [0, 1].map((row) => new Float32Array(wordsOf(shown).buffer)[128 * row + 4]!);
    expect(anchors[1]! - anchors[0]!).toBeCloseTo(500, 3);
    expect(said.mock.calls.filter(([text]) => /'wide'.*scales by 2, 1, 1/.test(String(text)))).toHaveLength(1);
    said.mockRestore();
    shown.shadow.dispose();
  });

  test('other files take the place of the earlier ones', () => {
    const shown = show({ filter: 3 }, [file, file]);
    const [city, turned] = [new Group(), new Group()];
    turned.rotation.y = 0.5;
    shown.frame();
    expect(shown.shadow.status).toEqual({ filesInUse: 2, missing: 0, degrees: expect.closeTo(0, 4) as number });
    shown.shadow.setOptions({ filter: 9 });
    shown.shadow.setFiles({ file, root: city });
    city.position.x = 70;
    shown.frame();
    expect(shown.shadow.status.filesInUse).toBe(1);
    const words = wordsOf(shown);
    expect([words[FILTER], words[FILE_COUNT]]).toEqual([9, 1]);
    const { header } = new LookUpTexture(file, 8192, { filter: 9, placement: city.matrixWorld.elements });
    expect([...words.subarray(0, 96)]).toEqual([...header.subarray(0, 96)]);
    const before = shown.headers();
    expect(() => shown.shadow.setFiles(Array.from({ length: 9 }, () => file))).toThrow(/up to 8 files/);
    expect(shown.headers()).toBe(before);
    // A file with another sun is not in use.
    shown.shadow.setFiles([file, { file, root: turned }]);
    shown.light.position.set(...file.grid.sun);
    shown.frame();
    expect(shown.shadow.status).toMatchObject({ filesInUse: 1, missing: 0 });
    shown.shadow.dispose();
    shown.shadow.setFiles(file);
    expect(shown.shadow.status.filesInUse).toBe(0);
  });

  test('a root that is stretched later does not affect the others', () => {
    const warn = vi.spyOn(console, 'warn').mockImplementation(() => undefined);
    const [here, there] = [new Group(), new Group()];
    const shown = show({}, [{ file, root: here }, { file, root: there }]);
    shown.frame();
    there.scale.x = 2;
    shown.frame();
    here.position.x = 5;
    shown.frame();
    expect(shown.shadow.status).toMatchObject({ filesInUse: 1, missing: 1 });
    shown.shadow.setOptions({ filter: 9 });
    expect(wordsOf(shown)[FILTER]).toBe(9);
    there.scale.x = 1;
    shown.frame();
    expect(shown.shadow.status).toMatchObject({ filesInUse: 2, missing: 0 });
    shown.shadow.dispose();
    warn.mockRestore();
  });

  test('a moved static root is warned of, unless a file follows it', () => {
    const warn = vi.spyOn(console, 'warn').mockImplementation(() => undefined);
    const said = (): number => warn.mock.calls.filter(([text]) => String(text).includes("in statics is moved, turned or scaled")).length;
    const [still, small] = [new Group(), new Group()];
    small.scale.setScalar(0.01);
    for (const shown of [show({ statics: still }), show({}, { file, root: small })]) {
      shown.frame();
      shown.shadow.dispose();
    }
    expect(said()).toBe(0);
    const shown = show({ statics: [still, small] });
    shown.frame();
    shown.frame();
    // Once per page, whichever the renderer.
    expect(said()).toBe(name === 'WebGLRenderer' ? 1 : 0);
    shown.shadow.dispose();
    warn.mockRestore();
  });
});
