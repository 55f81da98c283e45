// Situations of the light in apps: where it is, which objects carry it, and when it does not shine.

import { DirectionalLight, Group, Scene } from 'three';
import { describe, expect, test } from 'vitest';

import { RENDERERS } from './shown.js';
import { castIn, caster, file, keepWarnings, offSun, towards } from './situations.js';

keepWarnings();

describe.each(RENDERERS)('%s', (name, show) => {
  const isWebGL = name === 'WebGLRenderer';

  describe('the light', () => {
    test('a black sun lets statics cast', () => {
      const [city, house] = [new Group(), caster()];
      const shown = show({ statics: city.add(house) });
      shown.light.color.set(0);
      expect(castIn(shown, house)).toEqual([true]);
      expect(shown.shadow.isActive).toBe(false);
    });

    test('a sun moved to another scene lets statics cast in the first', () => {
      const [city, house] = [new Group(), caster()];
      const shown = show({ statics: city.add(house) });
      new Scene().add(shown.light);
      expect(castIn(shown, house)).toEqual([true]);
    });

    // WebGPURenderer does not draw the sun's map then.
    test.runIf(isWebGL)('a sun on a layer that the camera does not draw lets statics cast', () => {
      const [city, house] = [new Group(), caster()];
      const shown = show({ statics: city.add(house) });
      shown.light.layers.set(1);
      expect(castIn(shown, house)).toEqual([true]);
    });

    test('a target deeper below the light: the light turns, and does not run away', () => {
      const light = new DirectionalLight();
      light.position.set(0, 10, 0);
      const shown = show({}, file, light);
      const arm = new Group();
      light.add(arm.add(light.target));
      light.target.position.set(0, -1, -1);
      for (let i = 0; i < 20; i += 1) shown.frame();
      expect.soft(light.position.length()).toBeLessThan(100);
      expect(offSun(light)).toBeLessThan(1e-5);
      expect(shown.shadow.isActive).toBe(true);
    });

    test.each([
      ['stretched', [1, 2, 3]],
      ['mirrored', [-1, 1, 1]],
    ] as const)('a light that carries its target is aligned below a %s parent', (_, scale) => {
      const light = new DirectionalLight();
      light.add(light.target);
      light.target.position.set(0, 0, -1);
      const shown = show({}, file, light);
      const rig = new Group();
      shown.scene.add(rig.add(light.add(light.target)));
      rig.rotation.set(0.3, 0.5, 0.2);
      rig.scale.fromArray([...scale]);
      for (let i = 0; i < 3; i += 1) shown.frame();
      expect(offSun(light)).toBeLessThan(1e-5);
      expect(shown.shadow.isActive).toBe(true);
    });

    test('a light is aligned while its target moves below it and back', () => {
      const light = new DirectionalLight();
      light.position.set(5, 5, 0);
      const shown = show({}, file, light);
      shown.frame();
      light.add(light.target);
      light.target.position.set(0, 0, -1);
      shown.frame();
      expect(offSun(light)).toBeLessThan(1e-5);
      shown.scene.add(light.target);
      light.target.position.set(0, 0, 0);
      shown.frame();
      expect(offSun(light)).toBeLessThan(1e-5);
      shown.shadow.dispose();
      expect(light.position.toArray()).toEqual([5, 5, 0]);
      expect(light.quaternion.toArray()).toEqual([0, 0, 0, 1]);
    });

    test('a light below its own target stays aligned while that turns', () => {
      const light = new DirectionalLight();
      const shown = show({}, file, light);
      const player = new Group();
      shown.scene.add(player);
      player.add(light);
      light.target = player;
      for (let i = 0; i < 10; i += 1) {
        player.rotation.y += 0.3;
        player.position.x += 10;
        shown.frame();
        expect([shown.shadow.isActive, offSun(light) < 1e-5]).toEqual([true, true]);
      }
      expect(towards(light).length()).toBeLessThan(3);
    });

    test('a light in a group that has no size for a while stays finite', () => {
      const light = new DirectionalLight();
      light.position.set(0, 30, 40);
      const shown = show({}, file, light);
      const rig = new Group();
      rig.position.set(0, 10, 0);
      shown.scene.add(rig.add(light));
      rig.scale.setScalar(0);
      shown.frame();
      shown.frame();
      expect.soft(light.position.toArray().every(Number.isFinite)).toBe(true);
      expect.soft(light.matrixWorld.elements.every(Number.isFinite)).toBe(true);
      rig.scale.setScalar(1);
      shown.frame();
      expect.soft([shown.shadow.isActive, offSun(light) < 1e-5]).toEqual([true, true]);
      expect.soft(towards(light).length()).toBeGreaterThan(30);
      shown.shadow.dispose();
      expect(light.position.toArray()).toEqual([0, 30, 40]);
    });

    test('alignment recovers from a NaN position', () => {
      const shown = show({});
      shown.light.position.set(NaN, 0, 0);
      shown.frame();
      shown.frame();
      expect([shown.shadow.isActive, offSun(shown.light) < 1e-5]).toEqual([true, true]);
    });

    test('a light.shadow that the app replaces is respected', () => {
      const [city, house] = [new Group(), caster()];
      const shown = show({ statics: city.add(house) });
      shown.frame();
      shown.light.shadow = shown.light.shadow.clone();
      shown.light.shadow.intensity = 0;
      expect(castIn(shown, house)).toEqual([true]);
      shown.light.shadow.intensity = 1;
      shown.light.copy(new DirectionalLight());
      shown.scene.add(shown.light.target);
      expect(castIn(shown, house)).toEqual([false]);
      shown.shadow.dispose();
      expect(shown.light.position.toArray()).toEqual([0, 1, 0]);
    });
  });
});
