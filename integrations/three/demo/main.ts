// The page: puts the parts together.

import { PerspectiveCamera, Vector3 } from 'three';
import { FILTER_WIDTHS, ShadowFileLoader } from 'adumbra-three';
import type { BakedShadowFile, FilterWidth } from 'adumbra-three';
import type { LookUp } from 'adumbra-three/look-ups';

import { Controls } from './controls.js';
import type { Way } from './controls.js';
import { Divider } from './divider.js';
import { choose, element, onChoice, say } from './dom.js';
import type { Drawing, FileSettings, RendererKind } from './drawing.js';
import { takeFiles } from './drop.js';
import type { Read } from './drop.js';
import { DepthPasses, bakedHalf, stockHalf } from './halves.js';
import type { Half } from './halves.js';
import { ReadOuts, megabytes, write } from './read-outs.js';
import { available, open } from './renderers.js';
import { disposeWorld, loadCity } from './scene.js';
import type { World } from './scene.js';
import { TECHNIQUE_NAMES } from './stock-shadows.js';
import type { Technique } from './stock-shadows.js';
import { compare, loadTruth } from './truth.js';

/** The parts that are in the picture. */
type Mode = 'divider' | 'file' | 'stock';

const EYE = new Vector3(-150, 38, 175);
const TARGET = new Vector3(-75, 4, 75);
const ON_FOOT = [new Vector3(-126, 1.85, 128), new Vector3(-100, 8, 100)] as const;

/** Seconds of the bus' way before the page begins: it comes down the sunny street. */
const BUS_START = 32;

const parameters = new URLSearchParams(location.search);
/** Pixels of the canvas per CSS pixel. */
const pixels = (): number => Number(parameters.get('pixels')) || Math.min(devicePixelRatio, 2);
const isPhone = matchMedia('(max-width: 640px)').matches;
const panel = element('panel', HTMLDetailsElement);
const canvas = element('canvas', HTMLCanvasElement);
const filter = element('filter', HTMLSelectElement);
const softness = element('softness', HTMLSelectElement);
const technique = element('technique', HTMLSelectElement);
const truthButton = element('truth', HTMLButtonElement);
const busButton = element('bus', HTMLButtonElement);

/** All that is drawn. */
class Page {
  readonly #drawing: Drawing;
  readonly #camera = new PerspectiveCamera(45, 1, 0.3, 2000);
  readonly #controls = new Controls(this.#camera, canvas);
  readonly #divider = new Divider();
  readonly #readOuts = new ReadOuts();
  readonly #passes = { file: new DepthPasses(), stock: new DepthPasses() };
  #world: World;
  #file: BakedShadowFile | null;
  #fileName = 'city.adumbra';
  #lookUp: LookUp | undefined;
  #mode: Mode = 'divider';
  #baked: Half | null = null;
  #stock: Half | null = null;
  #isDriving = !matchMedia('(prefers-reduced-motion: reduce)').matches;
  #seconds = BUS_START;
  #before: number | undefined;
  #isComparing = false;

  constructor(drawing: Drawing, world: World, file: BakedShadowFile) {
    this.#drawing = drawing;
    this.#world = world;
    this.#file = file;
    addEventListener('resize', () => this.#resize());
    this.#resize();
    this.#showHome();
    this.#rebuild();
    this.#listen();
    this.#showBus();
    drawing.onLost(() => say('The GPU was lost. Reload the page to go on.', 'error'));
    drawing.loop((now) => this.#frame(now));
  }

  /** Softness or filter, as the panel has them. */
  get #settings(): FileSettings {
    if (this.#lookUp?.isSoft === true) return { sunDegrees: Number(softness.value) };
    return { filter: Number(filter.value) as FilterWidth };
  }

  get #hasTruth(): boolean {
    return this.#world.isCity && this.#file !== null;
  }

  #listen(): void {
    onChoice('mode', (mode) => {
      this.#mode = mode as Mode;
      this.#rebuild();
    });
    onChoice('way', (way) => {
      this.#controls.way = way as Way;
      canvas.focus();
    });
    technique.addEventListener('change', () => {
      this.#drop('stock');
      this.#rebuild();
    });
    filter.addEventListener('change', () => this.#baked?.setOptions(this.#settings));
    softness.addEventListener('change', () => void this.#soften());
    element('home', HTMLButtonElement).addEventListener('click', () => this.#showHome());
    busButton.addEventListener('click', () => {
      this.#isDriving = !this.#isDriving;
      this.#showBus();
    });
    truthButton.addEventListener('click', () => void this.#compare());
    takeFiles(
      (read) => void this.#take(read),
      (message) => say(message, 'error'),
    );
  }

  #resize(): void {
    const { clientWidth, clientHeight } = document.documentElement;
    this.#drawing.setSize(clientWidth, clientHeight, pixels());
    this.#camera.aspect = clientWidth / clientHeight;
    // A narrow window sees as much of the street as a wide one.
    this.#camera.fov = this.#camera.aspect < 1 ? 60 : 45;
    this.#camera.updateProjectionMatrix();
  }

  /** Puts the camera where the page begins. */
  #showHome(): void {
    choose('way', 'orbit');
    this.#controls.way = 'orbit';
    const { box, isCity } = this.#world;
    this.#controls.fit(box);
    this.#controls.onFoot = isCity ? ON_FOOT : null;
    const middle = box.getCenter(new Vector3());
    const away = box.getSize(new Vector3()).length();
    if (isCity) this.#controls.look(EYE, TARGET);
    else this.#controls.look(middle.clone().add(new Vector3(-0.5, 0.35, 0.6).multiplyScalar(away)), middle);
  }

  #showBus(): void {
    busButton.disabled = !this.#world.isCity;
    busButton.textContent = this.#isDriving ? 'Stop the bus' : 'Let the bus go';
  }

  #drop(which: 'baked' | 'stock' | 'both'): void {
    if (which !== 'stock') {
      this.#baked?.dispose();
      this.#baked = null;
    }
    if (which !== 'baked') {
      this.#stock?.dispose();
      this.#stock = null;
    }
  }

  #makeBaked(): Half {
    return bakedHalf(this.#drawing, this.#world, this.#file, this.#lookUp, this.#settings, this.#passes.file);
  }

  #makeStock(): Half {
    const kind = technique.value as Technique;
    return stockHalf(this.#drawing, this.#world, this.#file, kind, this.#camera, this.#passes.stock);
  }

  /**
   * Makes the halves that the picture needs, and frees a half that it does not need, so that it adds nothing
   * to frame times.
   */
  #rebuild(): void {
    const [needsFile, needsStock] = [this.#mode !== 'stock', this.#mode !== 'file'];
    if (!needsFile) this.#drop('baked');
    if (!needsStock) this.#drop('stock');
    if (needsFile) this.#baked ??= this.#makeBaked();
    if (needsStock) this.#stock ??= this.#makeStock();
    this.#controls.solids = (this.#baked ?? this.#stock)!.stage.statics;
    const columns = this.#file?.settings.resolution.toLocaleString('en-GB');
    this.#divider.label(
      needsFile ? (this.#file === null ? 'no file yet: no shadows' : `file, ${columns} columns`) : null,
      needsStock ? TECHNIQUE_NAMES[technique.value as Technique] : null,
    );
    filter.disabled = this.#lookUp?.isSoft === true;
    truthButton.disabled = !this.#hasTruth;
    this.#readOuts.restart();
  }

  /** Takes the look-up that softness needs. */
  async #soften(): Promise<void> {
    const isSoft = wantsSoftness();
    const lookUp = await loadLookUp(isSoft);
    // The panel has changed meanwhile: that change loads another look-up.
    if (isSoft !== wantsSoftness()) return;
    if (lookUp === this.#lookUp) {
      this.#baked?.setOptions(this.#settings);
      return;
    }
    this.#lookUp = lookUp;
    this.#drop('baked');
    this.#rebuild();
  }

  /** Shows files that people dropped or picked. If they cannot be drawn, the page keeps the previous ones. */
  async #take({ world, file, fileName }: Read): Promise<void> {
    if (world === undefined && file === undefined) return;
    // The shadows of another world would be wrong.
    const shown = file ?? (world === undefined ? this.#file : null);
    const lookUp = await loadLookUp(wantsSoftness());
    if (this.#isComparing) {
      say('The comparison with rays is not done yet. Bring the files again afterwards.', 'error');
      return;
    }
    const before = { world: this.#world, file: this.#file, fileName: this.#fileName, lookUp: this.#lookUp };
    const show = (what: typeof before): void => {
      [this.#world, this.#file, this.#fileName, this.#lookUp] = [what.world, what.file, what.fileName, what.lookUp];
      this.#drop('both');
      this.#rebuild();
    };
    try {
      show({ world: world ?? before.world, file: shown, fileName: fileName ?? before.fileName, lookUp });
    } catch (error) {
      show(before);
      say(`${fileName ?? before.fileName}: ${error instanceof Error ? error.message : String(error)}`, 'error');
      return;
    }
    if (world !== undefined) {
      disposeWorld(before.world);
      this.#showHome();
      this.#showBus();
    }
    write('wrong', this.#hasTruth ? 'not compared yet' : 'no truth of this scene');
    if (this.#file === null) {
      const stem = this.#world.name.replace(/\.glb$/i, '');
      say(`${this.#world.name} has no shadow file yet. Run: adumbra bake ${this.#world.name}, and drop ${stem}.adumbra here.`);
    } else {
      const still = this.#world.isAnimated ? ' What is animated in it stands still here, and is not in a bake.' : '';
      say(`Shows ${this.#world.name} with ${this.#fileName}.${still}`);
    }
  }

  /** Shows the view that has a truth, and counts the wrong pixels of both kinds of shadows. */
  async #compare(): Promise<void> {
    if (this.#isComparing) return;
    this.#isComparing = true;
    // Settings would change the halves that are compared.
    panel.inert = true;
    say('Comparing with rays…');
    // A half that is not in the picture is made only for the comparison.
    const made: Half[] = [];
    const keep = (half: Half): Half => {
      made.push(half);
      return half;
    };
    try {
      const truth = await loadTruth();
      const sun = this.#file!.grid.sun;
      const length = Math.hypot(...truth.sun);
      if (truth.sun.some((value, i) => Math.abs(value / length - sun[i]!) > 1e-3)) {
        throw new Error(`the truth is of another sun than ${this.#fileName}`);
      }
      this.#showHome();
      this.#controls.look(new Vector3(...truth.eye), new Vector3(...truth.target));
      const [file, stock] = [this.#baked ?? keep(this.#makeBaked()), this.#stock ?? keep(this.#makeStock())];
      const share = async (half: Half): Promise<string> => {
        const { pixels, compared } = await compare(this.#drawing, half, this.#camera, truth);
        return `${((100 * pixels) / compared).toFixed(2)} %`;
      };
      const [ofFile, ofStock] = [await share(file), await share(stock)];
      write('wrong', `${ofFile} | ${ofStock}`);
      say(`Wrong pixels of ${truth.width} × ${truth.height}, where the sun could shine: file ${ofFile}, three ${ofStock}.`);
    } catch (error) {
      say(error instanceof Error ? error.message : String(error), 'error');
    } finally {
      for (const half of made) half.dispose();
      panel.inert = false;
      this.#isComparing = false;
      this.#readOuts.restart();
    }
  }

  #frame(now: number): void {
    // The comparison moves the camera while it waits for the GPU.
    if (this.#isComparing) return;
    const passed = this.#before === undefined ? 0 : (now - this.#before) / 1000;
    this.#before = now;
    if (this.#isDriving) this.#seconds += Math.min(passed, 0.25);
    this.#controls.update(passed);
    for (const passes of Object.values(this.#passes)) passes.reset();
    const { clientWidth: width } = document.documentElement;
    const isDivided = this.#baked !== null && this.#stock !== null;
    const split = isDivided ? Math.round(this.#divider.share * width) : this.#baked === null ? 0 : width;
    for (const [half, from, to] of [[this.#baked, 0, split], [this.#stock, split, width]] as const) {
      if (half === null || to <= from) continue;
      half.update(this.#camera, this.#seconds);
      this.#drawing.draw(half.stage.scene, this.#camera, from, to);
    }
    const { file, stock } = this.#passes;
    this.#readOuts.frame(now, this.#baked && file, this.#stock && stock);
    document.documentElement.dataset['drawn'] = 'true';
  }
}

/** Whether the panel asks for soft shadows. */
function wantsSoftness(): boolean {
  return softness.value !== '';
}

/**
 * Returns a look-up: `undefined` for the filter, which is the default. The soft look-up is loaded when it is
 * needed.
 */
async function loadLookUp(isSoft: boolean): Promise<LookUp | undefined> {
  return isSoft ? (await import('adumbra-three/look-ups')).soft : undefined;
}

/** Sets the panel up as the address says. */
function readAddress(): void {
  const wantedFilter = Number(parameters.get('filter'));
  if ((FILTER_WIDTHS as readonly number[]).includes(wantedFilter)) filter.value = String(wantedFilter);
  const wanted = parameters.get('stock');
  // Four maps of 4096² are too much for a phone.
  technique.value = wanted === 'csm' || wanted === 'default' ? wanted : isPhone ? 'default' : 'csm';
  panel.open = !isPhone;
}

/** Lets people choose another renderer, which reloads the page. */
function offerRenderers(kind: RendererKind): void {
  const select = element('renderer', HTMLSelectElement);
  select.value = kind;
  select.addEventListener('change', () => {
    parameters.set('renderer', select.value);
    location.search = parameters.toString();
  });
}

/** Opens the screen that explains the page. */
function offerAbout(): void {
  const about = element('about', HTMLDialogElement);
  element('about-open', HTMLButtonElement).addEventListener('click', () => about.showModal());
}

async function begin(): Promise<void> {
  readAddress();
  offerAbout();
  const named = parameters.get('renderer');
  const wanted: RendererKind = named === 'webgl' || named === 'webgl2' ? named : 'webgpu';
  const kind = await available(wanted);
  offerRenderers(kind);
  const [drawing, world, file] = await Promise.all([
    open(kind, canvas, pixels() >= 1),
    loadCity(),
    new ShadowFileLoader().loadAsync('city.adumbra'),
  ]);
  element('file-size', HTMLElement).textContent = megabytes(file.byteLength);
  say(kind === wanted ? '' : 'This browser or machine has no WebGPU, so WebGL2 draws.');
  new Page(drawing, world, file);
}

begin().catch((error: unknown) => {
  say(`The page cannot begin: ${error instanceof Error ? error.message : String(error)}`, 'error');
});
