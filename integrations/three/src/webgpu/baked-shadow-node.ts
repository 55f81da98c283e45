// The shadow of a light from its files, as a node of WebGPURenderer.

import { FrontSide, REVISION } from 'three';
import type { Object3D, Scene } from 'three';
import * as TSL from 'three/tsl';
import * as WEBGPU from 'three/webgpu';
import type { Node, NodeBuilder, NodeFrame, ShadowBaseNode } from 'three/webgpu';

import { bakedLight } from '../light/baked-light.js';
import type { BakedLight } from '../light/baked-light.js';
import type { SunLike } from '../light/direction.js';
import { forEachMaterial } from '../light/materials.js';
import type { BakedShadow, BakedShadowOptions, FileChoice, ShadowOptions, ShadowStatus } from '../light/options.js';
import { takePart } from '../light/scene.js';
import type { Part } from '../light/scene.js';
import type { AnyRenderer } from '../light/streamed.js';
import { checkThree } from '../light/three.js';
import { wrap } from '../light/wrap.js';
import type { Wrapped } from '../light/wrap.js';
import { OLDEST, nodeHooks } from './hooks.js';
import { visibilityNode } from './look-up-node.js';

/**
 * The casters besides the files: `'shadow'` for the light's own shadow map, a shadow node such as
 * `CSMShadowNode`, or nothing.
 */
export type Movers = 'shadow' | ShadowBaseNode;

/** Options of a {@link BakedShadowNode}. */
export interface BakedShadowNodeOptions extends BakedShadowOptions {
  /**
   * The casters besides the files. Without this option the light draws no shadow map. `'shadow'` is for a
   * `DirectionalLight`; a `SunLight` takes `sunShadow(light)`, from three's addons.
   */
  movers?: Movers;
}

/** A builder with the members that its types leave out. */
type ShaderBuilder = NodeBuilder & {
  addSequentialNode(node: Node): void;
  isFlatShading(): boolean;
  readonly context: { readonly shadowPositionWorld?: Node<'vec3'> };
  readonly material: {
    readonly receivedShadowPositionNode?: Node<'vec3'> | null;
    readonly receivedShadowNode?: ((node: Node) => Node) | null;
  };
};

/** The node of each light, which the light need not have been given yet. */
const nodes = new WeakMap<SunLike, BakedShadowNode>();

/** The class that three's shadow nodes have in common. Where it is missing, no node can be made, but the import goes on. */
const Base = (WEBGPU.ShadowBaseNode ?? Object) as typeof ShadowBaseNode;

/**
 * The shadow of a light from its files: `light.shadow.shadowNode = new BakedShadowNode(light, { file })`. The
 * light must cast (`light.castShadow`), and the renderer's shadow maps must be enabled. A node of this kind
 * that the light had before is disposed.
 */
export class BakedShadowNode extends Base implements BakedShadow {
  readonly #sun: SunLike;
  readonly #baked: BakedLight;
  /** Whether three is about to rebuild the light's shadow, which disposes the present one. */
  #isRenewing = false;
  #isDisposed = false;
  #movers: Node | null;
  readonly #part: Part;
  /** How many `dispose` events of the light are being dispatched, one within the other. */
  #endings = 0;
  readonly #events: Wrapped<SunLike['dispatchEvent']>;
  /** The scene that is drawn, and the function that leaves it. */
  #scene: Scene | null = null;
  #leave: (() => void) | null = null;

  /**
   * Creates a node. Cost: one copy of the files' words.
   *
   * @throws MissingHookError if this version of three lacks what is needed.
   * @throws ShadowFileError of the kind `TooLarge`, if a file does not fit the GPU.
   * @throws RangeError if an option is out of its range.
   */
  constructor(light: SunLike, options: BakedShadowNodeOptions) {
    super(light);
    checkThree(OLDEST, { ...nodeHooks(), 'LightShadow.intensity': !light.shadow || 'intensity' in light.shadow });
    const { movers } = options;
    if (movers === 'shadow' && 'isSunLight' in light) {
      throw new RangeError(
        "movers: 'shadow' is for a DirectionalLight; pass sunShadow(light), from 'three/addons/lights/SunShadowNode.js'",
      );
    }
    this.#sun = light;
    this.#baked = bakedLight(light, options);
    this.#movers = movers === 'shadow' ? TSL.shadow(light) : (movers ?? null);
    this.#part = { ...this.#baked, update: (renderer) => this.#update(renderer) };
    // Drop the previous shadow, and rebuild materials.
    const before = light.shadow.shadowNode as unknown;
    const earlier = nodes.get(light);
    if (earlier) {
      // Keep the movers if both nodes share them.
      if (earlier.#movers === this.#movers) earlier.#movers = null;
      earlier.dispose();
    } else if (before === undefined || before !== movers) forgetShadow(light);
    nodes.set(light, this);
    this.#events = wrap(light, 'dispatchEvent', (theirs) => (event) => {
      const isEnd = Number(event.type === 'dispose');
      this.#endings += isEnd;
      try {
        theirs.call(light, event);
      } finally {
        this.#endings -= isEnd;
      }
    });
    // Update only after the earlier node has restored the light.
    this.#baked.update();
  }

  /** Whether the light shines, and from the sun of a file. Otherwise shadows are those of `movers`, if there are any. */
  get isActive(): boolean {
    return this.#baked.status().filesInUse > 0;
  }

  /** The state of the light and its files. */
  get status(): ShadowStatus {
    return this.#baked.status();
  }

  /**
   * Changes options; options that are left out stay. Nothing is recompiled.
   *
   * @throws RangeError if an option is out of its range. Nothing is changed then.
   */
  setOptions(options: ShadowOptions): void {
    this.#baked.setOptions(options);
  }

  /**
   * Replaces the files, for example as tiles come and go. Cost: one copy of the files' words, and their
   * upload; if they are larger than all before, three rebuilds its materials. The previous files need not be
   * kept.
   *
   * @throws ShadowFileError of the kind `TooLarge`, if a file does not fit the GPU. Nothing is changed then.
   * @throws RangeError if they are too many, or need another look-up, as a sun path does. Nothing is changed then.
   */
  setFiles(file: FileChoice): void {
    const { words } = this.#baked.textures();
    this.#baked.setFiles(file);
    if (this.#baked.textures().words === words) return;
    // Three binds the textures of an unchanged object only once.
    this.#isRenewing = true;
    forgetShadow(this.#sun);
    this.#isRenewing = false;
  }

  /** For three: builds the shadow's node. */
  override build(builder: NodeBuilder, output: string | null = null): Node | string | null {
    // Before the nodes of `movers`, so that a shadow map is drawn with the casters of the same frame.
    (builder as ShaderBuilder).addSequentialNode(this);
    return super.build(builder, output);
  }

  /** For three: the shadow's node in a material. */
  override setup(builder: NodeBuilder): Node {
    const { context, material } = builder as ShaderBuilder;
    // A flat normal already faces the camera.
    const isFront = material.side === FrontSide || (builder as ShaderBuilder).isFlatShading();
    const normal = TSL.normalWorldGeometry;
    const baked = visibilityNode(builder, this.#baked, {
      pWorld: material.receivedShadowPositionNode ?? context.shadowPositionWorld ?? TSL.positionWorld,
      normal: isFront ? normal : normal.mul(TSL.faceDirection),
      pixel: TSL.screenCoordinate,
    });
    const intensity = TSL.reference('intensity', 'float', this.#sun.shadow).setGroup(TSL.renderGroup) as Node<'float'>;
    const lit = TSL.mix(1, baked, intensity);
    const shadowed = (material.receivedShadowNode?.(lit) ?? lit) as Node<'float'>;
    // Three's shadow nodes have already done the same with the shadows of movers.
    return this.#movers === null ? shadowed : shadowed.min(this.#movers as Node<'float'>);
  }

  /** For three: joins the drawing of the scene. From then on, its work is done around each drawing. */
  override updateBefore({ renderer, scene }: NodeFrame): undefined {
    if (this.#isDisposed) return;
    this.#baked.setIdle(false);
    this.#update(renderer);
    if (scene === this.#scene || scene === null) return;
    this.#leave?.();
    this.#scene = scene;
    this.#leave = takePart(scene, this.#part);
    this.#baked.warnOfMovers(scene);
  }

  #update(renderer: AnyRenderer | null): void {
    this.#baked.update(renderer);
    if (this.#scene !== null) this.#baked.warnOfMoved(this.#scene);
    // Three binds the textures of an unchanged object only once, so it would miss the change of a texture.
    const { words, headers } = this.#baked.textures();
    renderer?.initTexture?.(words);
    renderer?.initTexture?.(headers);
  }

  /** Frees GPU resources, restores the light as the app set it last, and leaves it. */
  override dispose(): void {
    if (this.#isRenewing) return;
    // Three drops the shadow of a light that does not cast while it builds a material. The light may cast
    // again.
    if (TSL.getCurrentStack() !== null) {
      this.#baked.setIdle(true);
      return;
    }
    // Three drops the shadow of a light that is disposed, and must not do so again from within that.
    const isEnding = this.#endings > 0;
    this.#isDisposed = true;
    this.#leave?.();
    if (!this.#baked.dispose()) return;
    this.#events.remove();
    if (nodes.get(this.#sun) === this) nodes.delete(this.#sun);
    if (this.#sun.shadow.shadowNode === this) delete this.#sun.shadow.shadowNode;
    // Before 0.187 three throws here once its renderer is disposed.
    this.#movers?.dispose();
    super.dispose();
    if (!isEnding) forgetShadow(this.#sun);
  }
}

/** Makes three's node of a light drop its shadow and rebuild materials. */
function forgetShadow(light: SunLike): void {
  light.dispatchEvent({ type: 'dispose' });
  // From 0.187 on, three does the following itself.
  if (parseInt(REVISION, 10) >= 187) return;
  let root: Object3D = light;
  while (root.parent !== null) root = root.parent;
  forEachMaterial(root, (material) => material.dispose());
}
