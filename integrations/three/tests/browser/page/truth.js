// Draws a scene with a shadow file from the camera of a truth file, and returns the visibility at each pixel: the picture
// with shadows, divided by the one without.

import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { OBJLoader } from 'three/addons/loaders/OBJLoader.js';
import { PLYLoader } from 'three/addons/loaders/PLYLoader.js';

import { ShadowFileLoader } from 'adumbra-three';

/** Size of the truth's pictures. */
const WIDTH = 320;
const HEIGHT = 240;

const ONLY_MIDDLES = { stencilWrite: true, stencilFunc: THREE.EqualStencilFunc, stencilRef: 1 };
const TARGET = { type: THREE.FloatType, stencilBuffer: true };

const loaders = {
  glb: async (url) => (await new GLTFLoader().loadAsync(url)).scene,
  obj: (url) => new OBJLoader().loadAsync(url),
  ply: async (url) => new THREE.Mesh(await new PLYLoader().loadAsync(url)),
};

/** Returns a scene with flat normals and one material, seen from both sides. */
async function load(url) {
  const root = await loaders[url.split('.').pop()](url);
  const material = new THREE.MeshLambertMaterial({ side: THREE.DoubleSide, ...ONLY_MIDDLES });
  const flat = new Map();
  root.traverse((object) => {
    if (!object.isMesh) return;
    const { geometry } = object;
    if (!flat.has(geometry)) {
      const bare = new THREE.BufferGeometry();
      bare.setAttribute('position', geometry.attributes.position);
      bare.setIndex(geometry.index);
      const faces = bare.index === null ? bare : bare.toNonIndexed();
      faces.computeVertexNormals();
      flat.set(geometry, faces);
    }
    Object.assign(object, { geometry: flat.get(geometry), material, receiveShadow: true });
  });
  return root;
}

/** Points that mark, in the stencil buffer, the pixel in the middle of each square of `scale` × `scale`. */
function middles(scale) {
  const middle = (scale - 1) / 2;
  const positions = new Float32Array(3 * WIDTH * HEIGHT);
  for (let i = 0; i < WIDTH * HEIGHT; i += 1) {
    const [x, y] = [i % WIDTH, Math.floor(i / WIDTH)];
    positions.set([scale * x + middle + 0.5, scale * y + middle + 0.5, 0], 3 * i);
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
  const mark = { stencilWrite: true, stencilRef: 1, stencilZPass: THREE.ReplaceStencilOp };
  const material = new THREE.PointsMaterial({ size: 1, sizeAttenuation: false, colorWrite: false, depthWrite: false, ...mark });
  return new THREE.Points(geometry, material);
}

const renderers = {
  webgpu: (width, height) => nodeRenderer(width, height, false),
  webgl2: (width, height) => nodeRenderer(width, height, true),
  async webgl(width, height) {
    const { attachBakedShadow } = await import('adumbra-three/webgl');
    const renderer = new THREE.WebGLRenderer();
    const target = new THREE.WebGLRenderTarget(width, height, TARGET);
    return {
      renderer,
      target,
      bake: (scene, light, file, options) => attachBakedShadow(scene, light, file, options),
      async read() {
        const pixels = new Float32Array(4 * width * height);
        renderer.readRenderTargetPixels(target, 0, 0, width, height, pixels);
        return { pixels, isBottomFirst: true };
      },
    };
  },
};

async function nodeRenderer(width, height, forceWebGL) {
  const { WebGPURenderer, RenderTarget } = await import('three/webgpu');
  const { BakedShadowNode } = await import('adumbra-three/webgpu');
  const renderer = new WebGPURenderer({ forceWebGL });
  await renderer.init();
  renderer.shadowMap.enabled = true;
  const target = new RenderTarget(width, height, TARGET);
  return {
    renderer,
    target,
    bake(_scene, light, file, options) {
      light.castShadow = true;
      light.shadow.shadowNode = new BakedShadowNode(light, { file, ...options });
    },
    async read() {
      const pixels = await renderer.readRenderTargetPixelsAsync(target, 0, 0, width, height);
      return { pixels, isBottomFirst: forceWebGL };
    },
  };
}

/**
 * Draws `scene` with `file`. Returns the visibility of each pixel from the top left, as Base64 of 32-bit numbers. Pictures
 * are `scale` times as large, an odd number, and the pixel in the middle of each square, which has the same centre, is all
 * that is drawn of it.
 */
window.draw = async ({ backend, scene: sceneUrl, file: fileUrl, eye, target: aim, fov, scale }) => {
  const [root, file] = await Promise.all([load(sceneUrl), new ShadowFileLoader().loadAsync(fileUrl)]);
  const { renderer, target, bake, read } = await renderers[backend](scale * WIDTH, scale * HEIGHT);
  const scene = new THREE.Scene();
  const light = new THREE.DirectionalLight(0xffffff, Math.PI);
  scene.add(root, light, light.target);
  const camera = new THREE.PerspectiveCamera(fov, WIDTH / HEIGHT);
  camera.position.set(...eye);
  camera.lookAt(...aim);
  const { center, radius } = new THREE.Box3().setFromObject(root).getBoundingSphere(new THREE.Sphere());
  camera.near = 1e-3 * camera.position.distanceTo(new THREE.Vector3(...aim));
  camera.far = camera.position.distanceTo(center) + radius;
  camera.updateProjectionMatrix();
  bake(scene, light, file, { filter: 1 });
  const marks = middles(scale);
  const middle = (scale - 1) / 2;
  const flat = new THREE.OrthographicCamera(0, scale * WIDTH, scale * HEIGHT, 0, -1, 1);
  const depth = new THREE.MeshBasicMaterial({ side: THREE.DoubleSide, colorWrite: false, ...ONLY_MIDDLES });
  Object.assign(depth, { polygonOffset: true, polygonOffsetFactor: 0.1, polygonOffsetUnits: 1 });
  const red = async () => {
    renderer.setRenderTarget(target);
    renderer.autoClear = true;
    renderer.render(marks, flat);
    renderer.autoClear = false;
    // Depths first, so that look-ups are made for what is seen alone.
    scene.overrideMaterial = depth;
    renderer.render(scene, camera);
    scene.overrideMaterial = null;
    renderer.render(scene, camera);
    const { pixels, isBottomFirst } = await read();
    return Float32Array.from({ length: WIDTH * HEIGHT }, (_, i) => {
      const [x, y] = [i % WIDTH, Math.floor(i / WIDTH)];
      const row = scale * (isBottomFirst ? HEIGHT - 1 - y : y) + middle;
      return pixels[4 * (row * scale * WIDTH + scale * x + middle)];
    });
  };
  const shadowed = await red();
  root.traverse((object) => {
    object.receiveShadow = false;
    if (object.isMesh) object.material.needsUpdate = true;
  });
  const open = await red();
  renderer.dispose();
  return encode(shadowed.map((value, i) => value / open[i]));
};

function encode(floats) {
  const bytes = new Uint8Array(floats.buffer);
  let text = '';
  for (let at = 0; at < bytes.length; at += 32768) text += String.fromCharCode(...bytes.subarray(at, at + 32768));
  return btoa(text);
}

window.isReady = true;
