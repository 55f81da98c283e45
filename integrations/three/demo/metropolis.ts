// The page of the streamed city: a flight over 2 × 2 km, within a budget of memory.

import { Fog, Group, PerspectiveCamera, Vector3 } from 'three';
import { StreamedShadowFile } from 'adumbra-three/stream';

import { element, say } from './dom.js';
import type { Drawing, RendererKind, Shadows } from './drawing.js';
import { ROUND, fly } from './flight.js';
import { megabytes } from './read-outs.js';
import { available, open } from './renderers.js';
import { SKY, loadCity, makeStage } from './scene.js';
import type { Stage, World } from './scene.js';

/** The budgets of the slider, MB. */
const BUDGETS = [2, 4, 8, 16, 32, 64];
/** Milliseconds between changes of the numbers, so that they can be read. */
const CHANGE = 250;

const parameters = new URLSearchParams(location.search);
/** Pixels of the canvas per CSS pixel. */
const pixels = (): number => Number(parameters.get('pixels')) || Math.min(devicePixelRatio, 2);
/** Metres beyond which everything is haze. */
const HAZE = Number(parameters.get('haze')) || 1000;
const canvas = element('canvas', HTMLCanvasElement);
const budget = element('budget', HTMLInputElement);
const flyButton = element('fly', HTMLButtonElement);

/** A place of a copy of the city. */
interface Place {
  readonly x: number;
  readonly z: number;
  readonly quarterTurns: number;
}

/** Loads the city, and puts its copies beside each other. */
async function loadMetropolis(): Promise<World> {
  const [city, places] = await Promise.all([loadCity(2), fetch('metropolis.json').then((response) => response.json() as Promise<Place[]>)]);
  const root = new Group();
  for (const { x, z, quarterTurns } of places) {
    const copy = city.root.clone();
    copy.position.set(x, 0, z);
    copy.rotation.y = (quarterTurns * Math.PI) / 2;
    root.add(copy);
  }
  root.updateMatrixWorld(true);
  const box = city.box.clone();
  for (const { x, z } of places) box.union(city.box.clone().translate(new Vector3(x, 0, z)));
  return { name: 'metropolis', root, box, isCity: false, isAnimated: false };
}

/** All that is drawn. */
class Page {
  readonly #drawing: Drawing;
  readonly #stage: Stage;
  readonly #camera = new PerspectiveCamera(50, 1, 0.5, HAZE + 100);
  #file: StreamedShadowFile;
  #shadows: Shadows;
  #isFlying = !matchMedia('(prefers-reduced-motion: reduce)').matches;
  #isOpening = false;
  #seconds = Number(parameters.get('seconds')) || 0;
  #before: number | undefined;
  #written = 0;

  constructor(drawing: Drawing, world: World, file: StreamedShadowFile) {
    this.#drawing = drawing;
    this.#file = file;
    this.#stage = makeStage(world, new Vector3(...file.grid.sun));
    this.#stage.scene.fog = new Fog(SKY, HAZE / 2, HAZE);
    this.#shadows = this.#light(file);
    addEventListener('resize', () => this.#resize());
    this.#resize();
    budget.addEventListener('change', () => void this.#reopen());
    flyButton.addEventListener('click', () => {
      this.#isFlying = !this.#isFlying;
      this.#showFlight();
    });
    element('jump', HTMLButtonElement).addEventListener('click', () => {
      this.#seconds += ROUND / 2.7;
    });
    this.#showFlight();
    drawing.onLost(() => say('The GPU was lost. Reload the page to go on.', 'error'));
    drawing.loop((now) => this.#frame(now));
  }

  /** Gives the light a file. */
  #light(file: StreamedShadowFile): Shadows {
    file.addEventListener('error', ({ error }) => say(`${error.message}; a coarser level is shown`, 'error'));
    file.addEventListener('changed', ({ error }) => say(error.message, 'error'));
    return this.#drawing.bake(this.#stage, file, undefined, { filter: 5 });
  }

  #resize(): void {
    const { clientWidth, clientHeight } = document.documentElement;
    this.#drawing.setSize(clientWidth, clientHeight, pixels());
    this.#camera.aspect = clientWidth / clientHeight;
    this.#camera.updateProjectionMatrix();
  }

  #showFlight(): void {
    flyButton.textContent = this.#isFlying ? 'Stop the flight' : 'Fly on';
  }

  /** Opens the file with the budget of the slider, and again if the budget has changed meanwhile. */
  async #reopen(): Promise<void> {
    if (this.#isOpening) return;
    this.#isOpening = true;
    try {
      let opened: number;
      do {
        opened = budgetOfSlider();
        const file = await openFile(opened);
        const before = { file: this.#file, shadows: this.#shadows };
        before.shadows.dispose();
        before.file.dispose();
        this.#file = file;
        this.#shadows = this.#light(file);
      } while (opened !== budgetOfSlider());
    } catch (error) {
      say(error instanceof Error ? error.message : String(error), 'error');
    } finally {
      this.#isOpening = false;
    }
  }

  #frame(now: number): void {
    const passed = this.#before === undefined ? 0 : (now - this.#before) / 1000;
    this.#before = now;
    if (this.#isFlying) this.#seconds += Math.min(passed, 0.25);
    const ahead = fly(this.#camera, this.#seconds);
    this.#file.update(this.#camera, innerHeight * pixels());
    this.#shadows.update(this.#camera);
    this.#drawing.draw(this.#stage.scene, this.#camera, 0, document.documentElement.clientWidth);
    if (now - this.#written > CHANGE) {
      this.#written = now;
      this.#write(ahead);
    }
    document.documentElement.dataset['drawn'] = 'true';
  }

  #write(ahead: Vector3): void {
    const { stats, byteLength } = this.#file;
    const { requests, fetchedBytes, usedBytes, poolBytes, missing, chosen, levels } = stats;
    const sampler = this.#file.sampler({ filter: 1 });
    /** Edge of a texel of the level that answers at a point of the ground. */
    const texelAt = (point: Vector3): string => {
      const answering = sampler.levelAt(point);
      return `${(100 * levels.find(({ level }) => level === answering)!.texel).toFixed(0)} cm`;
    };
    write('fetched', `${megabytes(fetchedBytes)} of ${megabytes(byteLength)}`);
    write('requests', String(requests));
    write('held', `${megabytes(usedBytes)} of ${megabytes(poolBytes)}`);
    write('texel', `${texelAt(this.#camera.position.clone().setY(0))}, ${texelAt(ahead)}`);
    write('levels', levels.map(({ resident, bundles }) => `${resident}/${bundles}`).join(', '));
    write('missing', `${missing} of ${chosen}`);
  }
}

/** Writes one number. */
function write(name: string, text: string): void {
  element(`read-${name}`, HTMLElement).textContent = text;
}

/** Returns the budget of the slider, bytes. */
function budgetOfSlider(): number {
  const megabytesOf = BUDGETS[Number(budget.value)]!;
  element('budget-says', HTMLOutputElement).value = `${megabytesOf} MB`;
  return megabytesOf * 1e6;
}

function openFile(bytes: number): Promise<StreamedShadowFile> {
  return StreamedShadowFile.open('metropolis.adumbra', { budgetBytes: bytes });
}

/** Lets people choose another renderer, which reloads the page. */
function offerRenderers(kind: RendererKind): void {
  const renderer = element('renderer', HTMLSelectElement);
  renderer.value = kind;
  renderer.addEventListener('change', () => {
    parameters.set('renderer', renderer.value);
    location.search = parameters.toString();
  });
}

async function begin(): Promise<void> {
  const asked = BUDGETS.indexOf(Number(parameters.get('budget')));
  if (asked >= 0) budget.value = String(asked);
  budget.addEventListener('input', budgetOfSlider);
  const named = parameters.get('renderer');
  const wanted: RendererKind = named === 'webgl' || named === 'webgl2' ? named : 'webgpu';
  const kind = await available(wanted);
  offerRenderers(kind);
  const [drawing, world, file] = await Promise.all([open(kind, canvas, pixels() >= 1), loadMetropolis(), openFile(budgetOfSlider())]);
  element('file-texel', HTMLElement).textContent = `${(100 * file.grid.voxelSize).toFixed(1)} cm`;
  say(kind === wanted ? '' : 'This browser or machine has no WebGPU, so WebGL2 draws.');
  new Page(drawing, world, file);
}

begin().catch((error: unknown) => {
  say(`The page cannot begin: ${error instanceof Error ? error.message : String(error)}`, 'error');
});
