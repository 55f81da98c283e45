// Draws a level square, seen from straight above, and returns the visibility at each pixel: the picture with shadows,
// divided by the one without.

import * as THREE from 'three';

import { encode, renderers } from './renderers.js';

/** Number of pixels along a side, if a task names no other. */
const SIDE = 256;

const lookUps = () => import('adumbra-three/look-ups');

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

/** Loses the context of a WebGLRenderer, and has it back, as after a phone's sleep. */
async function loseContext(renderer) {
  const canvas = renderer.domElement;
  const extension = renderer.getContext().getExtension('WEBGL_lose_context');
  for (const [name, act] of [['lost', 'loseContext'], ['restored', 'restoreContext']]) {
    const done = new Promise((resolve) => canvas.addEventListener(`webglcontext${name}`, resolve, { once: true }));
    extension[act]();
    await done;
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}

/** Gives an object a morph target: it is half as large until it is morphed, and then as before. */
function morph(object) {
  const { geometry: shape } = object;
  const whole = shape.attributes.position.clone();
  shape.scale(0.5, 0.5, 0.5);
  shape.morphAttributes.position = [whole];
  object.updateMorphTargets();
  object.morphTargetInfluences[0] = 1;
}

/** Clips everything below the ground, where nothing is visible. */
async function clip({ renderer }, object) {
  const below = [new THREE.Plane(new THREE.Vector3(0, 1, 0), 1)];
  if (renderer.isWebGLRenderer) {
    renderer.localClippingEnabled = true;
    object.material.clippingPlanes = below;
    return object;
  }
  const { ClippingGroup } = await import('three/webgpu');
  const group = new ClippingGroup();
  group.clippingPlanes = below;
  return group.add(object);
}

/** Splits a camera into two, as for the eyes of a headset: each draws its half of the picture. */
function split(camera, side) {
  const eyes = [0, 1].map((i) => {
    const eye = camera.clone();
    Object.assign(eye, i === 0 ? { right: 0 } : { left: 0 });
    // Each is at a different place, and looks at its half of the picture.
    const middle = (eye.left + eye.right) / 2;
    eye.position.x += middle;
    Object.assign(eye, { left: eye.left - middle, right: eye.right - middle, viewport: new THREE.Vector4((i * side) / 2, 0, side / 2, side) });
    eye.updateProjectionMatrix();
    eye.updateMatrixWorld();
    return eye;
  });
  const both = new THREE.ArrayCamera(eyes);
  both.copy(camera, false);
  both.cameras = eyes;
  both.projectionMatrix.copy(camera.projectionMatrix);
  both.projectionMatrixInverse.copy(camera.projectionMatrixInverse);
  return both;
}

/**
 * Draws and returns the visibility of each pixel, from the top left, row by row. Settings of `later` are set
 * one after the other, each with a separate picture. `cycles` detach the shadows and attach those of one of
 * the files.
 */
window.draw = async (task) => {
  const { backend, files: urls, lookUp, height, middle, width, pixelsAcross = SIDE } = task;
  const { ShadowFileLoader } = await import('adumbra-three');
  const files = task.stream
    ? [await openStreamed(urls[0], task.stream)]
    : await Promise.all(urls.map((url) => new ShadowFileLoader().loadAsync(url)));
  const parts = await renderers[backend]({ ...task, side: pixelsAcross });
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
  object.scale.setScalar(task.shown ?? width);
  // Seen from behind, a double-sided surface faces the camera too.
  if (task.side === 'double') object.rotation.x = Math.PI;
  object.receiveShadow = true;
  object.frustumCulled = false;
  if (task.morphs) morph(object);
  scene.add(task.clips ? await clip(parts, object) : object);
  const camera = new THREE.OrthographicCamera(-width / 2, width / 2, width / 2, -width / 2, 1, 200);
  camera.position.set(middle[0], height + 90, middle[1]);
  camera.up.set(0, 0, -1);
  camera.lookAt(middle[0], height, middle[1]);

  if (task.rig) putInRig(camera, scene, task.rig);

  const eyes = task.eyes ? split(camera, pixelsAcross) : camera;
  const frame = () => {
    parts.renderer.setRenderTarget(parts.target);
    parts.renderer.render(scene, eyes);
  };
  const picture = async () => {
    frame();
    const { pixels, isBottomFirst } = await parts.read();
    const red = new Float32Array(pixelsAcross ** 2);
    for (let y = 0; y < pixelsAcross; y += 1) {
      const row = isBottomFirst ? pixelsAcross - 1 - y : y;
      for (let x = 0; x < pixelsAcross; x += 1) red[pixelsAcross * y + x] = pixels[4 * (pixelsAcross * row + x)];
    }
    return red;
  };
  const texts = await lookUps();
  const options = { lookUp: texts[lookUp], ...task.settings };
  const root = new THREE.Group();
  const twin = new THREE.Group();
  scene.add(root, twin);
  const choice = task.placements ? [files[0], files[0]].map((file, i) => ({ file, root: [root, twin][i] })) : files;
  let baked = parts.attach({ scene, light, files: choice, ...options });
  const drawn = [await picture()];
  for (const [i, placement] of (task.placements ?? []).entries()) {
    // The two copies answer in turn.
    const [here, there] = i % 2 === 0 ? [root, twin] : [twin, root];
    here.matrix.fromArray(placement).decompose(here.position, here.quaternion, here.scale);
    there.copy(here).position.x += 1e4 * here.scale.x;
    see(here, { object, camera, height, middle, width });
    drawn.push(await picture());
  }
  if (task.loses) {
    await loseContext(parts.renderer);
    drawn.push(await picture());
  }
  for (const settings of task.later ?? []) {
    baked.setOptions(settings);
    drawn.push(await picture());
  }
  const places = [];
  for (const place of task.stream ? (task.places ?? [middle]) : []) {
    object.position.set(place[0], height, place[1]);
    camera.position.set(place[0], height + 90, place[1]);
    places.push(await streamAll(files[0], camera, frame, { ...task, middle: place }));
    drawn.push(await picture());
  }
  const memory = [];
  for (let cycle = 0; cycle < (task.cycles ?? 0); cycle += 1) {
    baked.dispose();
    light.castShadow = false;
    await picture();
    memory.push({ ...parts.renderer.info.memory, shaders: parts.renderer.info.programs?.length });
    // Use another file each time, so that a look-up in a removed file would show.
    const file = files[(cycle + 1) % files.length];
    baked = parts.attach({ scene, light, files: [file], ...options });
    drawn.push(await picture());
  }
  object.receiveShadow = false;
  material.needsUpdate = true;
  const unshadowed = await picture();
  const visibility = (red) => red.map((value, i) => value / unshadowed[i]);
  parts.renderer.dispose();
  if (task.stream) files[0].dispose();
  return { visibility: drawn.map(visibility).map(encode), memory, places };
};

/** Puts a camera, where it is, below a group with a scale. Until 0.180 three's views are scaled with it. */
function putInRig(camera, scene, scale) {
  const rig = new THREE.Group();
  rig.position.set(7, -3, 5);
  rig.scale.setScalar(scale);
  scene.add(rig);
  rig.updateMatrixWorld();
  rig.attach(camera);
  camera.scale.setScalar(1);
  if (parseInt(THREE.REVISION, 10) >= 180) return;
  for (const side of ['left', 'right', 'top', 'bottom', 'near', 'far']) camera[side] /= scale;
  camera.updateProjectionMatrix();
}

/** Moves the drawn object and the camera with a root. */
function see({ matrix, position, quaternion, scale: { x: scale } }, { object, camera, height, middle, width }) {
  for (const [each, y] of [
    [object, height],
    [camera, height + 90],
  ]) {
    each.position.set(middle[0], y, middle[1]).applyMatrix4(matrix);
    each.quaternion.copy(quaternion);
  }
  object.scale.setScalar(width * scale);
  camera.quaternion.multiply(new THREE.Quaternion().setFromAxisAngle(new THREE.Vector3(1, 0, 0), -Math.PI / 2));
  const half = (width / 2) * scale;
  Object.assign(camera, { left: -half, right: half, top: half, bottom: -half, near: scale, far: 200 * scale });
  camera.updateProjectionMatrix();
}

async function openStreamed(url, options) {
  const { StreamedShadowFile } = await import('adumbra-three/stream');
  return StreamedShadowFile.open(url, options);
}

/**
 * Draws frames until everything that the camera needs is resident. Returns the answers on the CPU at its
 * pixels and the levels that gave them, the longest task of the page meanwhile, and the file's statistics.
 */
async function streamAll(file, camera, frame, { settings, cpu, height, middle, width, shown, pixelsAcross = SIDE }) {
  const atFirst = file.stats;
  // The task that has drawn and read the first picture is over.
  await new Promise((done) => setTimeout(done, 100));
  const tasks = [];
  const observer = new PerformanceObserver((list) => tasks.push(...list.getEntries().map(({ duration }) => duration)));
  observer.observe({ type: 'longtask' });
  let longestUpdate = 0;
  for (let still = 0, frames = 0; still < 20 && frames < 3000; frames += 1) {
    const before = performance.now();
    file.update(camera, pixelsAcross);
    longestUpdate = Math.max(longestUpdate, performance.now() - before);
    // Some frames are drawn meanwhile. Reading pixels would wait for the GPU.
    if (shown || frames % 10 === 0) frame();
    await new Promise(requestAnimationFrame);
    still = file.stats.missing === 0 && file.stats.underWay === 0 ? still + 1 : 0;
  }
  observer.disconnect();
  const sampler = file.sampler(cpu ?? settings);
  const across = (n) => ((n + 0.5) / pixelsAcross - 0.5) * width;
  const [answers, levels] = [new Float32Array(pixelsAcross ** 2), {}];
  for (let i = 0; i < pixelsAcross ** 2; i += 1) {
    const point = { x: middle[0] + across(i % pixelsAcross), y: height, z: middle[1] + across(Math.floor(i / pixelsAcross)) };
    answers[i] = sampler.visibility(point, { x: 0, y: 1, z: 0 });
    const level = sampler.levelAt(point, { x: 0, y: 1, z: 0 });
    levels[level] = (levels[level] ?? 0) + 1;
  }
  return { answers: encode(answers), levels, longestTask: Math.max(0, ...tasks), longestUpdate, atFirst, atLast: file.stats };
}

window.isReady = true;
