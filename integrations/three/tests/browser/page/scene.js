// A small world with a sun that is drawn from straight above, and the plays of `scene.test.ts` in it: each sets something
// up, draws, and returns what it saw.
//
// The ground is level at y = 0. A wall, which is in the files, casts to the one side or the other, and so
// does a box that hovers and is in no file. Visibility at a point is red, green or blue there, divided by the
// value of an unshadowed ground.

import * as THREE from 'three';

import { ShadowFileLoader } from 'adumbra-three';

/** Number of pixels along a side, and the metres that they show. */
const SIDE = 128;
const WIDTH = 32;

/** Directions towards the suns. `a` and `b` are those of the files, `none` is that of no file. All have y = 0.8. */
const SUNS = { a: [0.6, 0.8, 0], b: [-0.6, 0.8, 0], none: [0, 0.8, 0.6] };

/** Points on the ground: in the shadow of wall or box under a sun, or under none. */
const POINTS = {
  wallA: [-2.5, -5],
  wallB: [2.5, -5],
  wallNone: [0, -9.5],
  boxA: [-2.2, 5],
  boxB: [2.2, 5],
  boxNone: [0, 1],
  open: [10, 10],
};

/** Irradiance times reflectance of the ground, without a shadow. */
const LIT = 0.8;

const renderers = {
  webgpu: () => nodeRenderer(false),
  webgl2: () => nodeRenderer(true),
  async webgl() {
    const { attachBakedShadow } = await import('adumbra-three/webgl');
    const renderer = new THREE.WebGLRenderer();
    renderer.shadowMap.enabled = true;
    const target = new THREE.WebGLRenderTarget(SIDE, SIDE, { type: THREE.FloatType });
    return {
      renderer,
      target,
      bake(scene, light, file, { movers, ...options } = {}) {
        light.castShadow = movers !== undefined;
        return attachBakedShadow(scene, light, { file, ...options });
      },
      async read() {
        const pixels = new Float32Array(4 * SIDE * SIDE);
        renderer.readRenderTargetPixels(target, 0, 0, SIDE, SIDE, pixels);
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
  if ('isWebGPUBackend' in renderer.backend === forceWebGL) throw new Error('another backend than asked for');
  renderer.shadowMap.enabled = true;
  const target = new RenderTarget(SIDE, SIDE, { type: THREE.FloatType });
  return {
    renderer,
    target,
    bake(_scene, light, file, options = {}) {
      light.castShadow = true;
      return (light.shadow.shadowNode = new BakedShadowNode(light, { file, ...options }));
    },
    async read() {
      const pixels = await renderer.readRenderTargetPixelsAsync(target, 0, 0, SIDE, SIDE);
      return { pixels, isBottomFirst: forceWebGL };
    },
  };
}

/** One renderer for each back end serves all plays. */
const started = {};

const box = (x, y, z, material) => new THREE.Mesh(new THREE.BoxGeometry(x, y, z), material);

const plane = (up = 1) => new THREE.PlaneGeometry(40, 40).rotateX((-up * Math.PI) / 2);

const white = () => new THREE.MeshLambertMaterial();

/** Everything that is drawn, and its renderer. */
async function world(backend) {
  started[backend] ??= renderers[backend]();
  const parts = await started[backend];
  const { renderer, target } = parts;
  const scene = new THREE.Scene();
  const camera = new THREE.OrthographicCamera(-WIDTH / 2, WIDTH / 2, WIDTH / 2, -WIDTH / 2, 1, 100);
  camera.position.set(0, 50, 0);
  camera.up.set(0, 0, -1);
  camera.lookAt(0, 0, 0);

  const statics = new THREE.Group();
  const ground = new THREE.Mesh(plane(), white());
  ground.receiveShadow = true;
  const wall = box(2, 4, 6, white());
  wall.position.set(0, 2, -5);
  statics.add(ground, wall);
  const mover = box(2, 2, 6, white());
  mover.position.set(0, 2, 5);
  mover.visible = false;
  scene.add(statics, mover);
  const drawn = { wall: 0, mover: 0 };
  for (const [name, each] of Object.entries({ wall, mover })) {
    each.castShadow = true;
    each.receiveShadow = true;
    each.onBeforeShadow = () => (drawn[name] += 1);
  }

  const sunLight = (color = 0xffffff) => {
    const light = new THREE.DirectionalLight(color, Math.PI);
    Object.assign(light.shadow.camera, { left: -20, right: 20, top: 20, bottom: -20, near: 1, far: 100 });
    light.shadow.mapSize.set(512, 512);
    light.shadow.bias = -0.002;
    scene.add(light, light.target);
    turn(light, 'a');
    return light;
  };

  /** Draws; returns all three colours of all pixels, from the top left, and how often wall and box were drawn as casters. */
  const draw = async () => {
    Object.assign(drawn, { wall: 0, mover: 0 });
    renderer.setRenderTarget(target);
    renderer.render(scene, camera);
    const { pixels, isBottomFirst } = await parts.read();
    const colours = new Float32Array(3 * SIDE * SIDE);
    for (let i = 0; i < SIDE * SIDE; i += 1) {
      const y = Math.floor(i / SIDE);
      const from = (isBottomFirst ? SIDE - 1 - y : y) * SIDE + (i % SIDE);
      for (let c = 0; c < 3; c += 1) colours[3 * i + c] = pixels[4 * from + c];
    }
    return { colours, casters: { ...drawn } };
  };

  /** Draws; returns the visibility at the named points by name, and the casters. */
  const look = async (channel = 0) => {
    const { colours, casters } = await draw();
    return { ...lookAt(colours, channel), casters };
  };

  const bake = (light, file, options) => parts.bake(scene, light, file, options);
  return { renderer, scene, camera, statics, ground, wall, mover, sunLight, draw, look, bake };
}

function lookAt(colours, channel) {
  const pixel = (metres) => Math.floor((metres / WIDTH + 0.5) * SIDE);
  const at = ([x, z]) => colours[3 * (SIDE * pixel(z) + pixel(x)) + channel] / LIT;
  return Object.fromEntries(Object.entries(POINTS).map(([name, point]) => [name, Math.round(1000 * at(point)) / 1000]));
}

/** Makes a light shine from a sun. */
function turn(light, sun) {
  light.position.set(...SUNS[sun]).multiplyScalar(40);
}

const load = (...names) => Promise.all(names.map((name) => new ShadowFileLoader().loadAsync(`/files/${name}.adumbra`)));

const plays = {
  async movers(backend) {
    const w = await world(backend);
    const [file] = await load('a');
    const light = w.sunLight();
    w.mover.visible = true;
    const baked = w.bake(light, file, { statics: w.statics, movers: 'shadow' });
    const beside = await w.look();
    light.shadow.intensity = 0.5;
    const half = await w.look();
    light.shadow.intensity = 1;
    const cast = w.wall.castShadow;
    baked.dispose();
    light.castShadow = false;
    return { beside, half, cast, gone: await w.look() };
  },

  async filesAlone(backend) {
    const w = await world(backend);
    const [file] = await load('a');
    const light = w.sunLight();
    w.mover.visible = true;
    w.bake(light, file, { statics: w.statics });
    const seen = await w.look();
    light.shadow.intensity = 0.25;
    const faint = await w.look();
    light.shadow.intensity = 1;
    w.ground.receiveShadow = false;
    w.ground.material.needsUpdate = true;
    return { seen, faint, without: await w.look(), hasMap: Boolean(light.shadow.map) };
  },

  async turning(backend) {
    const w = await world(backend);
    const [file] = await load('a');
    const light = w.sunLight();
    w.mover.visible = true;
    const baked = w.bake(light, file, { statics: w.statics, movers: 'shadow', align: false });
    const states = [];
    for (const sun of ['a', 'none', 'a', 'b']) {
      turn(light, sun);
      states.push({ ...(await w.look()), isActive: baked.isActive });
    }
    return states;
  },

  async comingAndGoing(backend) {
    const w = await world(backend);
    const [file] = await load('a');
    w.statics.remove(w.wall);
    w.mover.visible = true;
    w.bake(w.sunLight(), file, { statics: w.statics, movers: 'shadow' });
    const states = [await w.look()];
    w.statics.add(w.wall);
    states.push(await w.look());
    w.scene.add(w.wall);
    states.push(await w.look());
    return states;
  },

  async severalSuns(backend) {
    const w = await world(backend);
    const files = await load('a', 'b');
    const light = w.sunLight();
    const baked = w.bake(light, files, { statics: w.statics });
    const states = [];
    for (const sun of ['a', 'b', 'none', 'b']) {
      turn(light, sun);
      states.push({ ...(await w.look()), isActive: baked.isActive });
    }
    return states;
  },

  async twoLights(backend) {
    const w = await world(backend);
    const [a, b] = await load('a', 'b');
    const lights = [w.sunLight(0xff0000), w.sunLight(0x00ff00)];
    turn(lights[1], 'b');
    const bakes = [a, b].map((file, i) => w.bake(lights[i], file, { statics: w.statics, movers: 'shadow', align: false }));
    const look = async () => {
      const { colours, casters } = await w.draw();
      return { red: lookAt(colours, 0), green: lookAt(colours, 1), casters };
    };
    const both = await look();
    turn(lights[0], 'none');
    const oneTurned = await look();
    turn(lights[0], 'a');
    const back = await look();
    bakes[1].dispose();
    lights[1].castShadow = false;
    const first = await look();
    bakes[0].dispose();
    lights[0].castShadow = false;
    return { both, oneTurned, back, first, none: await look() };
  },

  async sunLight(backend) {
    const { SunLight } = await import('three/addons/lights/SunLight.js');
    const w = await world(backend);
    const [file] = await load('a');
    const light = new SunLight(0xffffff, Math.PI);
    light.shadow.mapSize.set(512, 512);
    w.scene.add(light);
    turn(light, 'b');
    w.mover.visible = true;
    let movers = () => 'shadow';
    let refusal = '';
    if (backend !== 'webgl') {
      const { SunLightNode } = await import('three/addons/lights/SunLightNode.js');
      const { sunShadow } = await import('three/addons/lights/SunShadowNode.js');
      SunLight.registerNode(SunLightNode);
      refusal = thrown(() => w.bake(light, file, { movers: movers() })).message;
      movers = () => sunShadow(light);
    }
    let baked = w.bake(light, file, { statics: w.statics, movers: movers() });
    const aligned = await w.look();
    baked.dispose();
    baked = w.bake(light, file, { statics: w.statics, movers: movers(), align: false });
    turn(light, 'none');
    return { refusal, aligned, turned: await w.look(), isActive: baked.isActive };
  },

  async cascades(backend) {
    const { CSMShadowNode } = await import('three/addons/csm/CSMShadowNode.js');
    const w = await world(backend);
    const [file] = await load('a');
    const light = w.sunLight();
    w.mover.visible = true;
    light.shadow.camera.far = 300;
    const movers = new CSMShadowNode(light, { cascades: 2, maxFar: 100 });
    const baked = w.bake(light, file, { statics: w.statics, movers, align: false });
    const beside = await w.look();
    turn(light, 'none');
    const turned = await w.look();
    const { length } = w.scene.children;
    baked.dispose();
    light.castShadow = false;
    return { beside, turned, gone: await w.look(), lightsLeft: length - w.scene.children.length };
  },

  async cascadesOfWebGL() {
    const { CSM } = await import('three/addons/csm/CSM.js');
    const w = await world('webgl');
    const [file] = await load('a');
    w.mover.visible = true;
    const csm = new CSM({
      camera: w.camera,
      parent: w.scene,
      cascades: 2,
      lightDirection: new THREE.Vector3(...SUNS.a).negate(),
      lightIntensity: Math.PI,
      shadowBias: -0.0002,
      lightFar: 500,
    });
    for (const each of [w.ground, w.wall, w.mover]) csm.setupMaterial(each.material);
    const baked = w.bake(csm.lights[0], file, { align: false, statics: w.statics, movers: 'shadow' });
    w.camera.updateMatrixWorld();
    const look = (fade) => {
      csm.fade = fade;
      csm.updateFrustums();
      csm.update();
      return w.look();
    };
    const beside = await look(false);
    const faded = await look(true);
    w.mover.castShadow = false;
    const alone = await look(false);
    csm.lightDirection.set(...SUNS.none).negate();
    const turned = await look(false);
    csm.lightDirection.set(...SUNS.a).negate();
    baked.dispose();
    return { beside, faded, alone, turned, gone: await look(false) };
  },

  async runTime(backend) {
    const w = await world(backend);
    const [a, b] = await load('a', 'b');
    const light = w.sunLight();
    let baked = w.bake(light, a, { filter: 1 });
    const states = [await w.look()];
    baked.setOptions({ filter: 9, bias: { constantTexels: 4, slopeTexels: 2, normalOffsetTexels: 1 } });
    states.push(await w.look());
    baked.dispose();
    baked = w.bake(light, b);
    states.push(await w.look());
    // The light goes on casting, now with three's own shadow map.
    baked.dispose();
    light.castShadow = true;
    states.push(await w.look());
    baked = w.bake(light, a);
    states.push(await w.look());
    return { states, refusal: thrown(() => baked.setOptions({ filter: 4 })).name };
  },

  async switchedOff(backend) {
    const w = await world(backend);
    const [a, b] = await load('a', 'b');
    const light = w.sunLight();
    w.mover.visible = true;
    let baked = w.bake(light, a, { statics: w.statics, movers: 'shadow' });
    const states = [];
    for (const castShadow of [true, false, true]) {
      light.castShadow = castShadow;
      states.push(await w.look());
    }
    // Another shadow in its place, without disposing the one before.
    baked = w.bake(light, b, { statics: w.statics, movers: 'shadow' });
    states.push(await w.look());
    baked.dispose();
    light.castShadow = false;
    states.push(await w.look());
    return states;
  },

  async compileAsync(backend) {
    const w = await world(backend);
    const [file] = await load('a');
    w.bake(w.sunLight(), file);
    await w.renderer.compileAsync(w.scene, w.camera);
    return w.look();
  },

  async materials(backend) {
    const w = await world(backend);
    const [file] = await load('a');
    const light = w.sunLight();
    // So large a step along the normal shows which normal it is.
    const bias = { constantTexels: 1, slopeTexels: 1, normalOffsetTexels: 12 };
    w.bake(light, file, { filter: 1, bias });
    /** The visibility of all pixels that are lit. */
    const visibility = async () => {
      const pictures = [];
      for (const [shadow, intensity] of [
        [1, Math.PI],
        [0, Math.PI],
        [0, 0],
      ]) {
        Object.assign(light, { intensity });
        light.shadow.intensity = shadow;
        pictures.push((await w.draw()).colours);
      }
      Object.assign(light, { intensity: Math.PI });
      const [shadowed, open, off] = pictures;
      return shadowed.map((value, i) => (value - off[i]) / (open[i] - off[i])).filter((_, i) => i % 3 === 0);
    };
    const plain = await visibility();
    const shadowed = plain.filter((value) => value < 0.5).length;
    const off = {};
    for (const [name, make] of Object.entries(surfaces)) {
      const { material, geometry = plane(), fog = null } = make();
      Object.assign(w.ground, { material, geometry });
      w.scene.fog = fog;
      const found = await visibility();
      off[name] = found.filter((value, i) => !(Math.abs(value - plain[i]) < 0.01)).length;
    }
    return { shadowed, off };
  },

  async hooks() {
    const w = await world('webgl');
    const files = await load('a', 'b');
    const light = w.sunLight(0xff0000);
    const paint = (channel, value) => `#include <opaque_fragment>\n gl_FragColor.${channel} = ${value};`;
    const hook = (channel, value) => (shader) => {
      shader.fragmentShader = shader.fragmentShader.replace('#include <opaque_fragment>', paint(channel, value));
    };
    // Two functions of one text, and keys that tell them apart.
    w.ground.material.onBeforeCompile = hook('g', '0.8');
    w.ground.material.customProgramCacheKey = () => 'green';
    // Two functions of different texts.
    const other = new THREE.Mesh(new THREE.PlaneGeometry(2, 2).rotateX(-Math.PI / 2), white());
    other.position.set(POINTS.open[0], 0.01, POINTS.open[1]);
    other.material.onBeforeCompile = (shader) => {
      shader.fragmentShader = shader.fragmentShader.replace('#include <opaque_fragment>', `${paint('b', '0.4')} // other`);
    };
    w.scene.add(other);
    const third = other.clone();
    third.material = white();
    third.position.set(POINTS.boxA[0], 0.01, POINTS.boxA[1]);
    w.scene.add(third);

    const look = async () => {
      const { colours } = await w.draw();
      return { red: lookAt(colours, 0), green: lookAt(colours, 1), blue: lookAt(colours, 2) };
    };
    let baked = w.bake(light, files[0]);
    const earlier = await look();
    baked.dispose();
    const gone = await look();
    baked = w.bake(light, files[0]);
    const again = await look();
    // A later hook that calls the one that it finds; its twin has none.
    const { onBeforeCompile: found } = third.material;
    third.material.onBeforeCompile = (shader, renderer) => {
      found(shader, renderer);
      shader.fragmentShader = shader.fragmentShader.replace('#include <opaque_fragment>', paint('g', '0.4'));
    };
    third.material.needsUpdate = true;
    const later = await look();
    baked.dispose();
    return { earlier, gone, again, later, laterGone: await look() };
  },

  async disposalOrders() {
    const w = await world('webgl');
    const files = await load('a', 'b');
    const states = [];
    for (const order of [
      [0, 1],
      [1, 0],
    ]) {
      const lights = [w.sunLight(0xff0000), w.sunLight(0x00ff00)];
      const bakes = files.map((file, i) => w.bake(lights[i], file));
      for (const i of [undefined, ...order]) {
        bakes[i]?.dispose();
        const { colours } = await w.draw();
        states.push([lookAt(colours, 0).wallA, lookAt(colours, 1).wallB]);
      }
      w.scene.remove(...lights);
    }
    return { states, isRestored: w.ground.material.onBeforeCompile === THREE.Material.prototype.onBeforeCompile };
  },

  async shaderMaterials() {
    const w = await world('webgl');
    const [file] = await load('a');
    const light = w.sunLight();
    const own = new THREE.ShaderMaterial({
      name: 'own',
      vertexShader: 'void main() { gl_Position = projectionMatrix * modelViewMatrix * vec4( position, 1.0 ); }',
      fragmentShader: 'void main() { gl_FragColor = vec4( 0.4 ); }',
    });
    const { vertexShader, fragmentShader, uniforms } = THREE.ShaderLib.lambert;
    const lit = new THREE.ShaderMaterial({
      name: 'lit',
      lights: true,
      uniforms: THREE.UniformsUtils.clone(uniforms),
      vertexShader,
      fragmentShader: fragmentShader.replace('void main() {', 'void main( )\n{'),
    });
    w.ground.material = lit;
    const patch = new THREE.Mesh(new THREE.PlaneGeometry(1, 1).rotateX(-Math.PI / 2), own);
    patch.position.set(POINTS.wallA[0], 0.01, POINTS.wallA[1]);
    w.scene.add(patch);
    const baked = w.bake(light, file);
    const covered = await w.look();
    patch.visible = false;
    const { skipped } = baked;
    const bare = await w.look();
    const late = new THREE.Mesh(plane(), white());
    late.position.y = 0.01;
    late.receiveShadow = true;
    w.scene.add(late);
    return { covered, skipped, bare, late: await w.look() };
  },

  /** Grounds that show a mask of all shadows: three's own, and as the addon Water has it. */
  async masks() {
    const w = await world('webgl');
    const [file] = await load('a');
    const light = w.sunLight();
    w.mover.visible = true;
    w.bake(light, file, { statics: w.statics, movers: 'shadow' });
    w.scene.background = new THREE.Color(LIT, LIT, LIT);
    w.wall.material.colorWrite = w.mover.material.colorWrite = false;
    w.wall.material.depthWrite = w.mover.material.depthWrite = false;
    const { uniforms } = THREE.ShaderLib.lambert;
    const water = new THREE.ShaderMaterial({
      lights: true,
      uniforms: THREE.UniformsUtils.clone(uniforms),
      vertexShader: `#include <common>
#include <shadowmap_pars_vertex>
void main() {
  #include <beginnormal_vertex>
  #include <defaultnormal_vertex>
  #include <begin_vertex>
  #include <project_vertex>
  #include <worldpos_vertex>
  #include <shadowmap_vertex>
}`,
      fragmentShader: `#include <common>
#include <packing>
#include <lights_pars_begin>
#include <shadowmap_pars_fragment>
#include <shadowmask_pars_fragment>
void main() {
  gl_FragColor = vec4( vec3( ${LIT.toFixed(1)} * getShadowMask() ), 1.0 );
}`,
    });
    const states = [];
    for (const material of [new THREE.ShadowMaterial(), water]) {
      w.ground.material = material;
      states.push(await w.look());
      light.shadow.intensity = 0.5;
      states.push(await w.look());
      light.shadow.intensity = 1;
      light.visible = false;
      states.push(await w.look());
      light.visible = true;
      w.ground.receiveShadow = false;
      states.push(await w.look());
      w.ground.receiveShadow = true;
    }
    return states;
  },

  /** Actions of an app after it has attached a file. */
  async afterwards(backend) {
    const w = await world(backend);
    const [a, b] = await load('a', 'b');
    const light = w.sunLight();
    w.mover.visible = true;
    w.wall.castShadow = false;
    const baked = w.bake(light, a, { statics: w.statics, movers: 'shadow' });
    const states = { atFirst: await w.look() };
    w.wall.castShadow = true;
    w.ground.material = white();
    states.late = await w.look();
    // A clone casts, for it is in no file.
    const clone = w.wall.clone();
    clone.position.set(-8, 2, 10);
    clone.onBeforeShadow = () => (states.clones = (states.clones ?? 0) + 1);
    w.scene.add(clone);
    await w.draw();
    w.scene.remove(clone);
    // The light follows something.
    light.target.position.set(3, 0, 1);
    light.position.set(30, 43, 9);
    states.followed = await w.look();
    light.target.position.set(0, 0, 0);
    turn(light, 'a');
    baked.setFiles([a, b]);
    states.two = await w.look();
    baked.setFiles(b);
    states.other = await w.look();
    baked.setFiles(a);
    await w.draw();
    // The map is frozen while the file is in use, and then the sun goes down and the moon comes.
    light.shadow.autoUpdate = false;
    states.frozen = await w.look();
    light.visible = false;
    const moon = w.sunLight();
    turn(moon, 'none');
    moon.castShadow = true;
    states.night = await w.look();
    w.scene.remove(moon);
    light.visible = true;
    light.shadow.autoUpdate = true;
    light.dispose();
    light.castShadow = false;
    states.disposed = await w.look();
    return states;
  },

  async gltf(backend, name) {
    const { GLTFLoader } = await import('three/addons/loaders/GLTFLoader.js');
    const { GLTFBakedShadow } = await import('adumbra-three/gltf');
    const { Sampler } = await import('adumbra-three');
    const w = await world(backend);
    w.scene.clear();
    const attached = [];
    const loader = new GLTFLoader();
    loader.register((parser) => new GLTFBakedShadow(parser, (shadow) => attached.push(shadow)));
    const { scene } = await loader.loadAsync(`/files/${name}`);
    const [{ light, file, gltf, ...options }] = attached;
    // A square of 120 m alone, over the ground of the city; all else would hide it.
    const [height, width] = [0.25, 120];
    Object.assign(w.camera, { left: -width / 2, right: width / 2, top: width / 2, bottom: -width / 2 });
    w.camera.updateProjectionMatrix();
    scene.traverse((object) => (object.visible = !object.isMesh));
    const square = new THREE.Mesh(plane(), white());
    square.scale.set(3, 1, 3);
    square.position.y = height;
    square.receiveShadow = true;
    w.scene.add(scene, square);
    w.bake(light, file, options);
    const { colours } = await w.draw();
    light.shadow.intensity = 0;
    const { colours: open } = await w.draw();
    const sampler = new Sampler(file, { filter: options.filter ?? 5 });
    const across = (n) => ((n + 0.5) / SIDE - 0.5) * width;
    let [off, shadowed] = [0, 0];
    for (let i = 0; i < SIDE * SIDE; i += 1) {
      const point = { x: across(i % SIDE), y: height, z: across(Math.floor(i / SIDE)) };
      const wanted = sampler.visibility(point, { x: 0, y: 1, z: 0 });
      shadowed += Number(wanted < 0.5);
      off += Number(!(Math.abs(colours[3 * i] / open[3 * i] - wanted) <= 0.004));
    }
    return { off, shadowed, pixels: SIDE * SIDE, lights: attached.length, filter: options.filter, ofScene: gltf.scene === scene };
  },

  async gltfFails(name) {
    const { GLTFLoader } = await import('three/addons/loaders/GLTFLoader.js');
    const { GLTFBakedShadow } = await import('adumbra-three/gltf');
    const loader = new GLTFLoader();
    const fail = (error) => {
      throw error;
    };
    loader.register((parser) => new GLTFBakedShadow(parser, () => undefined, fail));
    return rejection(loader.loadAsync(`/files/${name}`));
  },

  async badFiles(backend, urls) {
    const w = await world(backend);
    const [file] = await load('a');
    w.bake(w.sunLight(), file);
    const before = await w.look();
    const errors = {};
    for (const url of urls) errors[url] = await rejection(new ShadowFileLoader().loadAsync(`/files/${url}`));
    const after = await w.look();
    const [good] = await load('b');
    const light = w.sunLight();
    w.scene.remove(w.scene.children.find((child) => child.isLight && child !== light));
    w.bake(light, good);
    return { before, errors, after, another: await w.look() };
  },

  async loading() {
    const loader = new ShadowFileLoader();
    const never = rejection(loader.loadAsync('/files/never'));
    loader.abort();
    const controller = new AbortController();
    loader.signal = controller.signal;
    const neither = rejection(loader.loadAsync('/files/never-again'));
    controller.abort();
    loader.signal = null;
    const progress = [];
    const file = await loader.loadAsync('/files/a.adumbra', ({ loaded }) => progress.push(loaded));
    return { aborted: [await never, await neither], last: progress.at(-1), byteLength: file.byteLength };
  },
};

/** Grounds of several materials. */
const surfaces = {
  normalMapped() {
    const bumps = new Uint8Array(4 * 64).map((_, i) => [128 + ((i * 37) % 41) - 20, 128 + ((i * 53) % 41) - 20, 250, 255][i % 4]);
    const normalMap = new THREE.DataTexture(bumps, 8, 8);
    normalMap.needsUpdate = true;
    return { material: new THREE.MeshStandardMaterial({ normalMap, roughness: 1 }) };
  },
  inFog: () => ({ material: white(), fog: new THREE.Fog(0x808080, 1, 100) }),
  vertexColoured() {
    const geometry = plane();
    const colours = [1, 0.5, 0, 0.2, 1, 0, 0.5, 0, 1, 1, 1, 1];
    geometry.setAttribute('color', new THREE.Float32BufferAttribute(colours, 3));
    return { material: new THREE.MeshLambertMaterial({ vertexColors: true }), geometry };
  },
  flat: () => ({ material: new THREE.MeshStandardMaterial({ flatShading: true, roughness: 1 }) }),
  backSide: () => ({ material: new THREE.MeshLambertMaterial({ side: THREE.BackSide }), geometry: plane(-1) }),
  flatFromBehind: () => ({
    material: new THREE.MeshStandardMaterial({ side: THREE.DoubleSide, flatShading: true, roughness: 1 }),
    geometry: plane(-1),
  }),
};

function thrown(action) {
  try {
    action();
  } catch (error) {
    return { name: error.name, message: error.message };
  }
  return { name: 'none', message: '' };
}

async function rejection(promise) {
  const error = await promise.then(
    () => ({ name: 'none' }),
    (reason) => reason,
  );
  const { name, kind, url, message } = error;
  return { name, kind, url, message };
}

/** Runs a play. */
window.play = (name, ...options) => plays[name](...options);

window.isReady = true;
