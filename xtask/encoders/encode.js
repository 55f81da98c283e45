// Compresses a glTF scene as exporters do: node encode.js METHOD SCENE.glb OUT.glb
//
// Three keep every value: draco-lossless (sequential), draco-lossless-edgebreaker, which stores triangles and
// corners in another order, and meshopt (EXT_meshopt_compression alone), which may begin a triangle at
// another corner. The others are the encoders' usual ones: draco (edgebreaker, quantized), draco-speed0,
// meshopt-quantized, gltfpack, gltfpack-cc.

import { NodeIO } from "@gltf-transform/core";
import {
  ALL_EXTENSIONS, EXTMeshoptCompression, KHRDracoMeshCompression, KHRONOS_EXTENSIONS,
} from "@gltf-transform/extensions";
import { meshopt } from "@gltf-transform/functions";
import draco from "draco3dgltf";
import { readFileSync, writeFileSync } from "node:fs";
import { MeshoptEncoder } from "meshoptimizer";
import * as gltfpack from "gltfpack";

const [method, from, to] = process.argv.slice(2);

const bits = (n) => ({ POSITION: n, NORMAL: n, COLOR: n, TEX_COORD: n, GENERIC: n });
const { EDGEBREAKER, SEQUENTIAL } = KHRDracoMeshCompression.EncoderMethod;
const DRACO = {
  draco: { method: EDGEBREAKER },
  "draco-speed0": { method: EDGEBREAKER, encodeSpeed: 0, decodeSpeed: 0 },
  "draco-lossless": { method: SEQUENTIAL, quantizationBits: bits(0) },
  "draco-lossless-edgebreaker": { method: EDGEBREAKER, quantizationBits: bits(0) },
};
const GLTFPACK = { gltfpack: ["-c", "-kn", "-km"], "gltfpack-cc": ["-cc", "-kn", "-km"] };

if (method in GLTFPACK) {
  const files = { read: (path) => readFileSync(path), write: (path, data) => writeFileSync(path, data) };
  const log = await gltfpack.pack(["-i", from, "-o", to, ...GLTFPACK[method]], files);
  if (log) console.error(log);
} else {
  const [encoder, decoder] = await Promise.all([draco.createEncoderModule(), draco.createDecoderModule()]);
  await MeshoptEncoder.ready;
  const io = new NodeIO().registerExtensions([...new Set([...ALL_EXTENSIONS, ...KHRONOS_EXTENSIONS])]).registerDependencies({
    "draco3d.encoder": encoder, "draco3d.decoder": decoder, "meshopt.encoder": MeshoptEncoder,
  });
  const document = await io.read(from);
  if (method in DRACO) {
    // Draco codes triangles with indices.
    for (const primitive of document.getRoot().listMeshes().flatMap((mesh) => mesh.listPrimitives())) {
      if (primitive.getIndices() === null) {
        const count = primitive.getAttribute("POSITION").getCount();
        const indices = document.createAccessor().setType("SCALAR").setBuffer(document.getRoot().listBuffers()[0]);
        primitive.setIndices(indices.setArray(Uint32Array.from({ length: count }, (_, i) => i)));
      }
    }
    document.createExtension(KHRDracoMeshCompression).setRequired(true).setEncoderOptions(DRACO[method]);
  } else if (method === "meshopt") {
    document.createExtension(EXTMeshoptCompression).setRequired(true)
      .setEncoderOptions({ method: EXTMeshoptCompression.EncoderMethod.QUANTIZE });
  } else if (method === "meshopt-quantized") {
    await document.transform(meshopt({ encoder: MeshoptEncoder, level: "medium" }));
  } else {
    throw new Error(`unknown method ${method}`);
  }
  await io.write(to, document);
}
