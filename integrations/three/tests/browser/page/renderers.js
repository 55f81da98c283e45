// The differences between renderers, for pages that read their pictures.

import * as THREE from 'three';

/** The parts that differ between renderers, which draw `side` × `side` pixels. */
export const renderers = {
  async webgpu(options) {
    return nodeRenderer(options, false);
  },
  async webgl2(options) {
    return nodeRenderer(options, true);
  },
  async webgl({ depth, side }) {
    const { attachBakedShadow } = await import('adumbra-three/webgl');
    const renderer = new THREE.WebGLRenderer({ ...depthOptions(depth) });
    const target = new THREE.WebGLRenderTarget(side, side, { type: THREE.FloatType });
    return {
      renderer,
      target,
      attach({ scene, light, files, ...options }) {
        return attachBakedShadow(scene, light, { file: files, ...options });
      },
      async read() {
        const pixels = new Float32Array(4 * side * side);
        renderer.readRenderTargetPixels(target, 0, 0, side, side, pixels);
        return { pixels, isBottomFirst: true };
      },
    };
  },
};

async function nodeRenderer({ depth, side }, forceWebGL) {
  const { WebGPURenderer, RenderTarget } = await import('three/webgpu');
  const { BakedShadowNode } = await import('adumbra-three/webgpu');
  const renderer = new WebGPURenderer({ forceWebGL, ...depthOptions(depth) });
  await renderer.init();
  if ('isWebGPUBackend' in renderer.backend === forceWebGL) throw new Error('another backend than asked for');
  renderer.shadowMap.enabled = true;
  const target = new RenderTarget(side, side, { type: THREE.FloatType });
  return {
    renderer,
    target,
    attach({ light, files, scene: _scene, ...options }) {
      light.castShadow = true;
      const node = new BakedShadowNode(light, { file: files, ...options });
      light.shadow.shadowNode = node;
      return node;
    },
    async read() {
      const pixels = await renderer.readRenderTargetPixelsAsync(target, 0, 0, side, side);
      return { pixels, isBottomFirst: forceWebGL };
    },
  };
}

function depthOptions(depth) {
  return { logarithmicDepthBuffer: depth === 'logarithmic', reversedDepthBuffer: depth === 'reversed' };
}

/** Returns numbers as text that a test can take. */
export function encode(floats) {
  const bytes = new Uint8Array(floats.buffer);
  let text = '';
  for (let at = 0; at < bytes.length; at += 32768) text += String.fromCharCode(...bytes.subarray(at, at + 32768));
  return btoa(text);
}
