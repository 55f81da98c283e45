// WebGLRenderer.

import { FloatType, ShaderChunk, Vector3, WebGLRenderTarget, WebGLRenderer } from 'three';
import type { Material } from 'three';
import { CSM as Cascades } from 'three/addons/csm/CSM.js';
import { attachBakedShadow } from 'adumbra-three/webgl';

import type { Drawing } from './drawing.js';
import { fitToMover, follow } from './mover-light.js';
import { CSM, Reach, fitToBox } from './stock-shadows.js';

/** Opens WebGLRenderer. */
export function open(canvas: HTMLCanvasElement, antialias: boolean): Drawing {
  const renderer = new WebGLRenderer({ canvas, antialias });
  renderer.shadowMap.enabled = true;
  let height = 1;

  return {
    kind: 'webgl',
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
      const target = new WebGLRenderTarget(width, rows, { type: FloatType });
      const pixels = new Float32Array(4 * width * rows);
      renderer.setRenderTarget(target);
      renderer.render(scene, camera);
      const row = 4 * width;
      for (let y = 0; y < rows; y += 1) {
        const line = pixels.subarray(row * y, row * (y + 1));
        renderer.readRenderTargetPixels(target, 0, rows - 1 - y, width, 1, line);
      }
      renderer.setRenderTarget(null);
      target.dispose();
      return pixels;
    },
    bake({ scene, sun, statics, bus }, file, lookUp, settings) {
      const towardsSun = new Vector3(...file.grid.sun);
      sun.castShadow = bus !== null;
      fitToMover(sun);
      if (bus !== null) follow(sun, bus, towardsSun);
      const options = { statics, ...settings, ...(lookUp === undefined ? {} : { lookUp }) };
      const attached = attachBakedShadow(scene, sun, { file, ...options });
      return {
        update() {
          if (bus !== null) follow(sun, bus, towardsSun);
        },
        setIntensity(intensity) {
          sun.shadow.intensity = intensity;
        },
        setOptions: (changed) => attached.setOptions(changed),
        dispose: () => attached.dispose(),
      };
    },
    stock({ scene, sun, box, materials }, technique, camera) {
      const common = { setOptions() {} };
      if (technique === 'default') {
        sun.castShadow = true;
        fitToBox(sun, box);
        return {
          ...common,
          update() {},
          setIntensity(intensity) {
            sun.shadow.intensity = intensity;
          },
          dispose() {},
        };
      }
      const reach = new Reach(box);
      reach.follow(camera);
      const margin = box.getSize(new Vector3()).length();
      const { csm, chunks } = cascades({
        camera,
        parent: scene,
        cascades: CSM.cascades,
        maxFar: reach.metres,
        shadowMapSize: CSM.size,
        shadowBias: CSM.bias,
        lightDirection: sun.target.position.clone().sub(sun.position).normalize(),
        lightIntensity: sun.intensity,
        lightFar: 4 * margin,
        lightMargin: margin,
      });
      for (const light of csm.lights) {
        light.color.copy(sun.color);
        light.shadow.normalBias = CSM.normalBias;
      }
      for (const material of materials) setUp(csm, chunks, material);
      // Each cascade has its own light. These lights replace the sun.
      sun.removeFromParent();
      return {
        ...common,
        update(seen) {
          if (reach.follow(seen)) {
            csm.maxFar = reach.metres;
            csm.updateFrustums();
          }
          csm.update();
        },
        setIntensity(intensity) {
          for (const { shadow } of csm.lights) shadow.intensity = intensity;
        },
        dispose() {
          for (const light of csm.lights) light.dispose();
          csm.remove();
          csm.dispose();
        },
      };
    },
    onLost(callback) {
      canvas.addEventListener('webglcontextlost', callback);
    },
    loop: (frame) => renderer.setAnimationLoop(frame),
  };
}

/** Texts of three's shaders. */
type Chunks = Pick<typeof ShaderChunk, 'lights_fragment_begin' | 'lights_pars_begin'>;

/**
 * Makes cascades, which change three's shaders for all materials. The change is undone here, and the changed
 * texts are returned.
 */
function cascades(settings: ConstructorParameters<typeof Cascades>[0]): { csm: Cascades; chunks: Chunks } {
  const { lights_fragment_begin, lights_pars_begin } = ShaderChunk;
  const csm = new Cascades(settings);
  const chunks = { ...ShaderChunk };
  Object.assign(ShaderChunk, { lights_fragment_begin, lights_pars_begin });
  return { csm, chunks };
}

/** Gives one material the shaders of cascades. */
function setUp(csm: Cascades, chunks: Chunks, material: Material): void {
  csm.setupMaterial(material);
  const { onBeforeCompile } = material;
  material.onBeforeCompile = (shader, renderer) => {
    for (const name of ['lights_fragment_begin', 'lights_pars_begin'] as const) {
      shader.fragmentShader = shader.fragmentShader.replace(`#include <${name}>`, () => chunks[name]);
    }
    onBeforeCompile.call(material, shader, renderer);
  };
}
