// Draws a level square, seen from straight above, and returns the visibility at each pixel: the picture with shadows,
// divided by the one without.

import * as THREE from 'three';

/** Number of pixels along a side. */
const SIDE = 256;

const lookUps = () => import('adumbra-three/look-ups');

/** The parts that differ between renderers. */
const renderers = {
  async webgpu(options) {
    return nodeRenderer(options, false);
  },
  async webgl2(options) {
    return nodeRenderer(options, true);
  },
  async webgl({ depth }) {
    const { attachBakedShadow } = await import('adumbra-three/webgl');
    const renderer = new THREE.WebGLRenderer({ ...depthOptions(depth) });
    const target = new THREE.WebGLRenderTarget(SIDE, SIDE, { type: THREE.FloatType });
    return {
      renderer,
      target,
      attach({ scene, light, files, ...options }) {
        return attachBakedShadow(scene, light, files, options);
      },
      async read() {
        const pixels = new Float32Array(4 * SIDE * SIDE);
        renderer.readRenderTargetPixels(target, 0, 0, SIDE, SIDE, pixels);
        return { pixels, isBottomFirst: true };
      },
    };
  },
};

async function nodeRenderer({ depth }, forceWebGL) {
  const { WebGPURenderer, RenderTarget } = await import('three/webgpu');
  const { BakedShadowNode } = await import('adumbra-three/webgpu');
  const renderer = new WebGPURenderer({ forceWebGL, ...depthOptions(depth) });
  await renderer.init();
  if ('isWebGPUBackend' in renderer.backend === forceWebGL) throw new Error('another backend than asked for');
  renderer.shadowMap.enabled = true;
  const target = new RenderTarget(SIDE, SIDE, { type: THREE.FloatType });
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
      const pixels = await renderer.readRenderTargetPixelsAsync(target, 0, 0, SIDE, SIDE);
      return { pixels, isBottomFirst: forceWebGL };
    },
  };
}

function depthOptions(depth) {
  return { logarithmicDepthBuffer: depth === 'logarithmic', reversedDepthBuffer: depth === 'reversed' };
}

const materials = {
  standard: (o) => new THREE.MeshStandardMaterial({ roughness: 1, ...o }),
  physical: (o) => new THREE.MeshPhysicalMaterial({ roughness: 1, clearcoat: 0.5, ...o }),
  lambert: (o) => new THREE.MeshLambertMaterial(o),
  phong: (o) => new THREE.MeshPhongMaterial({ specular: 0, ...o }),
  toon: (o) => new THREE.MeshToonMaterial(o),
};

/** A square of 2 × 2 units, in the plane of x and z and facing up. */
function geometry() {
  return new THREE.PlaneGeometry(2, 2).rotateX(-Math.PI / 2);
}

const objects = {
  mesh: (material) => new THREE.Mesh(geometry(), material),
  instanced(material) {
    const mesh = new THREE.InstancedMesh(geometry(), material, 2);
    for (const i of [0, 1]) mesh.setMatrixAt(i, new THREE.Matrix4().makeTranslation(2 * i - 1, 0, 0));
    return mesh;
  },
  batched(material) {
    const mesh = new THREE.BatchedMesh(2, 8, 12, material);
    const id = mesh.addGeometry(geometry());
    for (const i of [0, 1]) {
      mesh.setMatrixAt(mesh.addInstance(id), new THREE.Matrix4().makeTranslation(2 * i - 1, 0, 0));
    }
    return mesh;
  },
  skinned(material) {
    const shape = geometry();
    const count = shape.attributes.position.count;
    shape.setAttribute('skinIndex', new THREE.Uint16BufferAttribute(new Uint16Array(4 * count), 4));
    const weights = new Float32Array(4 * count).map((_, i) => (i % 4 === 0 ? 1 : 0));
    shape.setAttribute('skinWeight', new THREE.Float32BufferAttribute(weights, 4));
    const mesh = new THREE.SkinnedMesh(shape, material);
    const bone = new THREE.Bone();
    mesh.add(bone);
    mesh.bind(new THREE.Skeleton([bone]));
    return mesh;
  },
};

/**
 * Draws and returns the visibility of each pixel, from the top left, row by row. Settings of `later` are set one after
 * the other, each with a picture of its own. `cycles` detach the shadows and attach those of one of the files.
 */
window.draw = async (task) => {
  const { backend, files: urls, lookUp, height, middle, width } = task;
  const { ShadowFileLoader } = await import('adumbra-three');
  const files = await Promise.all(urls.map((url) => new ShadowFileLoader().loadAsync(url)));
  const parts = await renderers[backend](task);
  const scene = new THREE.Scene();
  const light = new THREE.DirectionalLight(0xffffff, 1);
  scene.add(light, light.target);
  const material = materials[task.material ?? 'standard']({
    side: task.side === 'double' ? THREE.DoubleSide : THREE.FrontSide,
    transparent: task.transparent === true,
    opacity: task.transparent === true ? 0.5 : 1,
  });
  const object = objects[task.object ?? 'mesh'](material);
  object.position.set(middle[0], height, middle[1]);
  object.scale.setScalar(width);
  // Seen from behind, a double-sided surface faces the camera all the same.
  if (task.side === 'double') object.rotation.x = Math.PI;
  object.receiveShadow = true;
  object.frustumCulled = false;
  scene.add(object);
  const camera = new THREE.OrthographicCamera(-width / 2, width / 2, width / 2, -width / 2, 1, 200);
  camera.position.set(middle[0], height + 90, middle[1]);
  camera.up.set(0, 0, -1);
  camera.lookAt(middle[0], height, middle[1]);

  const picture = async () => {
    parts.renderer.setRenderTarget(parts.target);
    parts.renderer.render(scene, camera);
    const { pixels, isBottomFirst } = await parts.read();
    const red = new Float32Array(SIDE * SIDE);
    for (let y = 0; y < SIDE; y += 1) {
      const row = isBottomFirst ? SIDE - 1 - y : y;
      for (let x = 0; x < SIDE; x += 1) red[SIDE * y + x] = pixels[4 * (SIDE * row + x)];
    }
    return red;
  };
  const texts = await lookUps();
  const options = { lookUp: texts[lookUp], ...task.settings };
  let baked = parts.attach({ scene, light, files, ...options });
  const drawn = [await picture()];
  for (const settings of task.later ?? []) {
    baked.setOptions(settings);
    drawn.push(await picture());
  }
  const memory = [];
  for (let cycle = 0; cycle < (task.cycles ?? 0); cycle += 1) {
    baked.dispose();
    light.castShadow = false;
    await picture();
    memory.push({ ...parts.renderer.info.memory, shaders: parts.renderer.info.programs?.length });
    // Another file each time, so that a look-up in one that is gone is seen.
    const file = files[(cycle + 1) % files.length];
    baked = parts.attach({ scene, light, files: [file], ...options });
    drawn.push(await picture());
  }
  object.receiveShadow = false;
  material.needsUpdate = true;
  const unshadowed = await picture();
  const visibility = (red) => red.map((value, i) => value / unshadowed[i]);
  parts.renderer.dispose();
  return { visibility: drawn.map(visibility).map(encode), memory };
};

function encode(floats) {
  const bytes = new Uint8Array(floats.buffer);
  let text = '';
  for (let at = 0; at < bytes.length; at += 32768) text += String.fromCharCode(...bytes.subarray(at, at + 32768));
  return btoa(text);
}

window.isReady = true;
