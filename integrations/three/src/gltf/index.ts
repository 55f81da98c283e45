// adumbra-three/gltf: lights of glTF files that name their shadow file.
//
// A directional light of KHR_lights_punctual may have `extras: {"adumbra": {"shadow": "city.adumbra",
// "filter": 5}}`. The path is relative to the glTF file. `adumbra bake --link-in city.glb` writes it.

import { LoaderUtils, PropertyBinding } from 'three';
import type { DirectionalLight, Object3D } from 'three';
import type { GLTF, GLTFLoaderPlugin, GLTFParser } from 'three/addons/loaders/GLTFLoader.js';

import type { BakedShadowFile } from '../file/shadow-file.js';
import type { SunLike } from '../light/direction.js';
import { ShadowFileLoader } from '../loader.js';
import { FILTER_WIDTHS } from '../settings.js';
import type { FilterWidth } from '../settings.js';

/** The shadow that a light of a glTF file names. */
export interface NamedShadow {
  /** The light. */
  readonly light: SunLike;
  /** Its file. */
  readonly file: BakedShadowFile;
  /** The filter that the light asks for, if it asks for one. */
  readonly filter?: FilterWidth;
  /** The whole result of the load. */
  readonly gltf: GLTF;
}

/**
 * A plugin of `GLTFLoader`: `loader.register((parser) => new GLTFBakedShadow(parser, attach))`. `attach` is
 * called for each light that names a file, before the loader's promise resolves. With WebGPURenderer it is
 * `({ light, ...options }) => { light.shadow.shadowNode = new BakedShadowNode(light, options);
 * light.castShadow = true; }`.
 *
 * If its shadow file cannot be loaded, a light is as the glTF file has it, and `onError` gets the reason.
 * Objects that the glTF file's animations move get `userData.adumbra.cast`, because they are in no bake.
 */
export class GLTFBakedShadow implements GLTFLoaderPlugin {
  /** For three: the name of the plugin. */
  readonly name = 'ADUMBRA_extras';
  readonly #parser: GLTFParser;
  readonly #attach: (shadow: NamedShadow) => void;
  readonly #onError: (error: unknown, light: SunLike) => void;

  /**
   * Creates the plugin of one load. `onError` is called with the `ShadowFileError` of a file that cannot be
   * loaded, and prints it by default; if it throws, the load of the glTF file is rejected with that error.
   */
  constructor(parser: GLTFParser, attach: (shadow: NamedShadow) => void, onError: (error: unknown, light: SunLike) => void = console.error) {
    this.#parser = parser;
    this.#attach = attach;
    this.#onError = onError;
  }

  /** For three: loads the files that lights name. */
  async afterRoot(gltf: GLTF): Promise<void> {
    const { manager, path, requestHeader, crossOrigin, withCredentials } = this.#parser.options as Options;
    const loader = new ShadowFileLoader(manager);
    loader.setRequestHeader(requestHeader);
    // Do the same as the glTF loader does for its own files.
    loader.setWithCredentials(withCredentials === true || crossOrigin === 'use-credentials');
    markMovers(gltf);
    const lights: [SunLike, Extras][] = [];
    for (const scene of gltf.scenes) {
      scene.traverse((object) => {
        const { adumbra } = object.userData as { adumbra?: Extras };
        if ('isDirectionalLight' in object && typeof adumbra?.shadow === 'string') {
          lights.push([object as DirectionalLight, adumbra]);
        }
      });
    }
    await Promise.all(
      lights.map(async ([light, { shadow, filter }]) => {
        let file: BakedShadowFile;
        try {
          file = await loader.loadAsync(LoaderUtils.resolveURL(shadow as string, path));
        } catch (error) {
          this.#onError(error, light);
          return;
        }
        const isWidth = (FILTER_WIDTHS as readonly unknown[]).includes(filter);
        this.#attach({ light, file, gltf, ...(isWidth ? { filter: filter as FilterWidth } : {}) });
      }),
    );
  }
}

/** Marks the objects that the animations of a glTF file move. They are in no bake, and cast in real time. */
function markMovers({ animations, scenes }: GLTF): void {
  for (const { name } of animations.flatMap(({ tracks }) => tracks)) {
    const { nodeName } = PropertyBinding.parseTrackName(name) as { nodeName?: string };
    for (const scene of nodeName ? scenes : []) {
      const node = PropertyBinding.findNode(scene, nodeName!) as Object3D | null;
      if (node) node.userData['adumbra'] = { ...(node.userData['adumbra'] as object | undefined), cast: true };
    }
  }
}

/** The parser's options, with one that three has from 0.187 on. */
type Options = GLTFParser['options'] & { readonly withCredentials?: boolean };

/** The extras of a light. */
interface Extras {
  readonly shadow?: unknown;
  readonly filter?: unknown;
}
