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

const TARGET = { type: THREE.FloatType };

const loaders = {
  glb: async (url) => (await new GLTFLoader().loadAsync(url)).scene,
  obj: (url) => new OBJLoader().loadAsync(url),
  ply: async (url) => new THREE.Mesh(await new PLYLoader().loadAsync(url)),
};

/** Returns a scene with flat normals and one material, seen from both sides. */
async function load(url) {
  const root = await loaders[url.split('.').pop()](url);
  const material = new THREE.MeshLambertMaterial({ side: THREE.DoubleSide });
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

const renderers = {
  webgpu: () => nodeRenderer(false),
  webgl2: () => nodeRenderer(true),
  async webgl() {
    const { attachBakedShadow } = await import('adumbra-three/webgl');
    const renderer = new THREE.WebGLRenderer();
    const target = new THREE.WebGLRenderTarget(WIDTH, HEIGHT, TARGET);
    return {
      renderer,
      target,
      bake: (scene, light, file, options) => attachBakedShadow(scene, light, { file, ...options }),
      async read() {
        const pixels = new Float32Array(4 * WIDTH * HEIGHT);
        renderer.readRenderTargetPixels(target, 0, 0, WIDTH, HEIGHT, pixels);
        return { pixels, isBottomFirst: true };
      },
    };
  },
};

async function nodeRenderer(forceWebGL) {
  const { WebGPURenderer, RenderTarget } = await import('three/webgpu');
  const { BakedShadowNode } = await import('adumbra-three/webgpu');
  const renderer = new WebGPURenderer({ forceWebGL });
  await renderer.init();
  renderer.shadowMap.enabled = true;
  const target = new RenderTarget(WIDTH, HEIGHT, TARGET);
  return {
    renderer,
    target,
    bake(_scene, light, file, options) {
      light.castShadow = true;
      light.shadow.shadowNode = new BakedShadowNode(light, { file, ...options });
    },
    async read() {
      const pixels = await renderer.readRenderTargetPixelsAsync(target, 0, 0, WIDTH, HEIGHT);
      return { pixels, isBottomFirst: forceWebGL };
    },
  };
}

/** Draws `scene` with `file`. Returns the visibility of each pixel from the top left, as Base64 of 32-bit numbers. */
window.draw = async ({ backend, scene: sceneUrl, file: fileUrl, eye, target: aim, fov }) => {
  const [root, file] = await Promise.all([load(sceneUrl), new ShadowFileLoader().loadAsync(fileUrl)]);
  const { renderer, target, bake, read } = await renderers[backend]();
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
  const red = async () => {
    renderer.setRenderTarget(target);
    renderer.render(scene, camera);
    const { pixels, isBottomFirst } = await read();
    return Float32Array.from({ length: WIDTH * HEIGHT }, (_, i) => {
      const [x, y] = [i % WIDTH, Math.floor(i / WIDTH)];
      const row = isBottomFirst ? HEIGHT - 1 - y : y;
      return pixels[4 * (row * WIDTH + x)];
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
