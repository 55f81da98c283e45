// WebGPURenderer, on WebGPU or on WebGL2.

import { FloatType, Vector3 } from 'three';
import { RenderTarget, WebGPURenderer } from 'three/webgpu';
import { CSMShadowNode } from 'three/addons/csm/CSMShadowNode.js';
import { BakedShadowNode } from 'adumbra-three/webgpu';

import type { Drawing, RendererKind } from './drawing.js';
import { fitToMover, follow } from './mover-light.js';
import { CSM, Reach, fitToBox } from './stock-shadows.js';

/** Opens WebGPURenderer. */
export async function open(
  kind: Exclude<RendererKind, 'webgl'>,
  canvas: HTMLCanvasElement,
  antialias: boolean,
): Promise<Drawing> {
  const renderer = new WebGPURenderer({ canvas, antialias, forceWebGL: kind === 'webgl2' });
  await renderer.init();
  renderer.shadowMap.enabled = true;
  let height = 1;

  return {
    kind,
    setSize(width, newHeight, pixelRatio) {
      height = newHeight;
      renderer.setPixelRatio(pixelRatio);
      renderer.setSize(width, height, false);
    },
    draw(scene, camera, from, to) {
      renderer.setScissorTest(true);
      renderer.setScissor(from, 0, to - from, height);
      renderer.render(scene, camera);
    },
    async read(scene, camera, width, rows) {
      const target = new RenderTarget(width, rows, { type: FloatType });
      renderer.setRenderTarget(target);
      renderer.render(scene, camera);
      renderer.setRenderTarget(null);
      const pixels = (await renderer.readRenderTargetPixelsAsync(target, 0, 0, width, rows)) as Float32Array;
      target.dispose();
      return kind === 'webgl2' ? upsideDown(pixels, width, rows) : pixels;
    },
    bake({ sun, statics, bus }, file, lookUp, settings) {
      const towardsSun = new Vector3(...file.grid.sun);
      sun.castShadow = true;
      fitToMover(sun);
      if (bus !== null) follow(sun, bus, towardsSun);
      const options = { file, statics, ...settings, ...(lookUp === undefined ? {} : { lookUp }) };
      const node = new BakedShadowNode(sun, bus === null ? options : { ...options, movers: 'shadow' });
      sun.shadow.shadowNode = node;
      return {
        update() {
          if (bus !== null) follow(sun, bus, towardsSun);
        },
        setIntensity(intensity) {
          sun.shadow.intensity = intensity;
        },
        setOptions: (changed) => node.setOptions(changed),
        dispose: () => node.dispose(),
      };
    },
    stock({ sun, box }, technique, camera) {
      sun.castShadow = true;
      const { shadow } = sun;
      const common = { setOptions() {} };
      if (technique === 'default') {
        fitToBox(sun, box);
        return {
          ...common,
          update() {},
          setIntensity(intensity) {
            shadow.intensity = intensity;
          },
          dispose() {},
        };
      }
      const reach = new Reach(box);
      reach.follow(camera);
      const margin = box.getSize(new Vector3()).length();
      shadow.mapSize.set(CSM.size, CSM.size);
      shadow.bias = CSM.bias;
      shadow.normalBias = CSM.normalBias;
      shadow.camera.near = 1;
      shadow.camera.far = 4 * margin;
      const csm = new CSMShadowNode(sun, { cascades: CSM.cascades, maxFar: reach.metres, lightMargin: margin });
      shadow.shadowNode = csm;
      return {
        ...common,
        update(seen) {
          if (!reach.follow(seen) || csm.mainFrustum === null) return;
          csm.maxFar = reach.metres;
          csm.updateFrustums();
        },
        setIntensity(intensity) {
          for (const { shadow: own } of csm.lights) if (own !== undefined) own.intensity = intensity;
        },
        dispose() {
          // The node does not dispose the maps of its cascades.
          for (const { shadow: own } of csm.lights) own?.dispose();
          csm.dispose();
        },
      };
    },
    onLost(callback) {
      renderer.onDeviceLost = callback;
    },
    loop: (frame) => void renderer.setAnimationLoop(frame),
  };
}

/** Reverses the order of rows. */
function upsideDown(pixels: Float32Array, width: number, height: number): Float32Array {
  const row = 4 * width;
  const turned = new Float32Array(pixels.length);
  for (let y = 0; y < height; y += 1) turned.set(pixels.subarray(y * row, (y + 1) * row), (height - 1 - y) * row);
  return turned;
}
