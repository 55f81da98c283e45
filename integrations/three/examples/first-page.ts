import { ShadowFileLoader } from 'adumbra-three';
import { BakedShadowNode } from 'adumbra-three/webgpu';
import { AmbientLight, Color, DirectionalLight, PerspectiveCamera, Scene } from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { WebGPURenderer } from 'three/webgpu';

const renderer = new WebGPURenderer({ antialias: true });
renderer.shadowMap.enabled = true;
renderer.setSize(innerWidth, innerHeight);
document.body.style.margin = '0';
document.body.replaceChildren(renderer.domElement);

const scene = new Scene();
scene.background = new Color(0x8fb3d9);
const sun = new DirectionalLight(0xffffff, 3);
sun.castShadow = true;
scene.add(sun, sun.target, new AmbientLight(0xffffff, 0.6));

const city = await new GLTFLoader().loadAsync('city.glb');
city.scene.traverse((object) => (object.receiveShadow = true));
scene.add(city.scene);

const file = await new ShadowFileLoader().loadAsync('city.adumbra');
sun.shadow.shadowNode = new BakedShadowNode(sun, { file });

const camera = new PerspectiveCamera(60, innerWidth / innerHeight, 0.5, 3000);
camera.position.set(-150, 38, 175);
camera.lookAt(-75, 4, 75);
renderer.setAnimationLoop(() => renderer.render(scene, camera));
