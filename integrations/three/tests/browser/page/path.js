// Draws a level square, seen from straight above, at moments of a sun path. Returns the visibility at each
// pixel, and the visibility from look-ups on the CPU.

import * as THREE from 'three';
import { SunPathFile } from 'adumbra-three/path';

import { encode, renderers } from './renderers.js';

/** Number of pixels along a side: few, since software draws them. */
const SIDE = 64;

window.draw = async ({ backend, url, moments, height, width, filter }) => {
  const path = await SunPathFile.open(url);
  const parts = await renderers[backend]({ side: SIDE });
  const scene = new THREE.Scene();
  const light = new THREE.DirectionalLight(0xffffff, 1);
  scene.add(light, light.target);
  const square = new THREE.Mesh(new THREE.PlaneGeometry(width, width).rotateX(-Math.PI / 2), new THREE.MeshLambertMaterial());
  square.position.y = height;
  square.receiveShadow = true;
  scene.add(square);
  const camera = new THREE.OrthographicCamera(-width / 2, width / 2, width / 2, -width / 2, 1, 200);
  camera.position.set(0, height + 90, 0);
  camera.up.set(0, 0, -1);
  camera.lookAt(0, height, 0);
  const baked = parts.attach({ scene, light, files: path, filter });

  const across = (n) => ((n + 0.5) / SIDE - 0.5) * width;
  const drawn = [];
  for (const { seconds, waits } of moments) {
    if (waits) await path.load(seconds);
    else path.update(seconds);
    // Take both now, because keys arrive while pixels are read.
    const [{ stats }, sampler] = [path, path.sampler({ filter })];
    parts.renderer.setRenderTarget(parts.target);
    parts.renderer.render(scene, camera);
    // The light has followed the path.
    const { isActive } = baked;
    const { pixels, isBottomFirst } = await parts.read();
    const [found, expected] = [new Float32Array(SIDE * SIDE), new Float32Array(SIDE * SIDE)];
    for (let y = 0; y < SIDE; y += 1) {
      const row = isBottomFirst ? SIDE - 1 - y : y;
      for (let x = 0; x < SIDE; x += 1) {
        // A level surface of this material has the sun's height over π.
        found[SIDE * y + x] = (pixels[4 * (SIDE * row + x)] * Math.PI) / path.grid.sun[1];
        expected[SIDE * y + x] = sampler.visibility({ x: across(x), y: height, z: across(y) }, { x: 0, y: 1, z: 0 });
      }
    }
    drawn.push({ found: encode(found), expected: encode(expected), isActive, stats });
  }
  baked.dispose();
  parts.renderer.dispose();
  path.dispose();
  return drawn;
};

window.isReady = true;
