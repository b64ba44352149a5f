// SPDX-License-Identifier: MIT
// The models of a page in Node, which lacks what browsers have.
import { KIND } from "../src/scene/shape.js";

/** @returns {Promise<(model: number, level: number) => {kind: number, positions: Float32Array, normals: Float32Array, index: number[]}[]>} */
export async function modelMeshes(data) {
  globalThis.self ??= globalThis;
  globalThis.ProgressEvent ??= class extends Event {};
  const { parseGlb, partNameOf } = await import("../src/scene/models.js");
  const { scene } = await parseGlb(data.models.glb);
  scene.updateMatrixWorld(true);
  return (model, level) => {
    const meshes = [];
    scene.getObjectByName(`model-${model}-level-${level}`).traverse((object) => object.isMesh && meshes.push(object));
    return meshes.map((mesh) => {
      const { position, normal } = mesh.geometry.attributes;
      const read = (attribute) => Float32Array.from({ length: 3 * attribute.count }, (_, i) => attribute.getComponent(Math.floor(i / 3), i % 3));
      const scale = mesh.matrixWorld.elements[0];
      return { kind: partNameOf(mesh) === "stem" ? KIND.stem : KIND.crown, positions: read(position).map((value) => value * scale), normals: read(normal), index: [...mesh.geometry.index.array] };
    });
  };
}
