// Files that people drop on the page or pick.

import { ShadowFileError, ShadowFileLoader } from 'adumbra-three';
import type { BakedShadowFile } from 'adumbra-three';

import { element } from './dom.js';
import { readWorld } from './scene.js';
import type { World } from './scene.js';

/** The files that were read. */
export interface Read {
  readonly world?: World;
  readonly file?: BakedShadowFile;
  readonly fileName?: string;
}

/** Takes files: calls back with the files that were read, or with an error message. */
export function takeFiles(onRead: (read: Read) => void, onError: (message: string) => void): void {
  const take = async (files: readonly File[]): Promise<void> => {
    try {
      onRead(await read(files));
    } catch (error) {
      onError(error instanceof Error ? error.message : String(error));
    }
  };
  const picker = element('files', HTMLInputElement);
  picker.addEventListener('change', () => {
    void take([...(picker.files ?? [])]);
    picker.value = '';
  });
  const { body } = document;
  body.addEventListener('dragover', (event) => {
    event.preventDefault();
    body.classList.add('dropping');
  });
  body.addEventListener('dragleave', (event) => {
    if (event.relatedTarget === null) body.classList.remove('dropping');
  });
  body.addEventListener('drop', (event) => {
    event.preventDefault();
    body.classList.remove('dropping');
    void take([...(event.dataTransfer?.files ?? [])]);
  });
}

/** Reads a GLB, a shadow file, or one of each. */
async function read(files: readonly File[]): Promise<Read> {
  let found: Read = {};
  for (const file of files) {
    const bytes = await file.arrayBuffer();
    if (/\.adumbra$/i.test(file.name)) found = { ...found, file: await readShadows(file.name, bytes), fileName: file.name };
    else if (/\.glb$/i.test(file.name)) found = { ...found, world: await readScene(file.name, bytes) };
    else throw new Error(`${file.name}: this page takes .glb and .adumbra files`);
  }
  return found;
}

async function readShadows(name: string, bytes: ArrayBuffer): Promise<BakedShadowFile> {
  try {
    return await new ShadowFileLoader().parseAsync(bytes);
  } catch (error) {
    if (error instanceof ShadowFileError) throw new Error(`${name}: ${error.kind}: ${error.message}`, { cause: error });
    throw error;
  }
}

async function readScene(name: string, bytes: ArrayBuffer): Promise<World> {
  try {
    return await readWorld(name, bytes);
  } catch (error) {
    throw new Error(`${name} cannot be read: ${error instanceof Error ? error.message : String(error)}`, { cause: error });
  }
}
