// SPDX-License-Identifier: MIT
// Loads scenes with three.js and compares what it would draw with what was written:
// node load_three.mjs EXPECTED.json FILE ...
import { readFileSync } from 'node:fs';
import { dirname, join } from 'node:path';

// What browsers have and Node has not.
globalThis.self = globalThis;
globalThis.ProgressEvent ??= class extends Event {};
const { Box3, Matrix4 } = await import('three');
const { GLTFLoader } = await import('three/examples/jsm/loaders/GLTFLoader.js');
const { MeshoptDecoder } = await import('three/examples/jsm/libs/meshopt_decoder.module.js');

const [expectedFile, ...files] = process.argv.slice(2);
const expected = JSON.parse(readFileSync(expectedFile, 'utf8'));

/** A glTF file with its buffer inside, since there is no server here to ask for it. */
function bytesOf(file) {
  const bytes = readFileSync(file);
  if (file.endsWith('.glb')) return bytes;
  const gltf = JSON.parse(bytes.toString('utf8'));
  for (const buffer of gltf.buffers) {
    if (!buffer.uri) continue;
    const inside = readFileSync(join(dirname(file), decodeURIComponent(buffer.uri)));
    buffer.uri = 'data:application/octet-stream;base64,' + inside.toString('base64');
  }
  return Buffer.from(JSON.stringify(gltf));
}

function load(file) {
  const bytes = bytesOf(file);
  const loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder);
  const exact = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length);
  return loader.parseAsync(exact, '');
}

function drawn(scene) {
  const box = new Box3();
  let triangles = 0;
  scene.updateMatrixWorld(true);
  scene.traverse((object) => {
    if (!object.isMesh) return;
    object.geometry.computeBoundingBox();
    const places = object.isInstancedMesh ? object.count : 1;
    triangles += places * object.geometry.index.count / 3;
    for (let i = 0; i < places; ++i) {
      const matrix = object.matrixWorld.clone();
      if (object.isInstancedMesh) {
        const place = new Matrix4();
        object.getMatrixAt(i, place);
        matrix.multiply(place);
      }
      box.union(object.geometry.boundingBox.clone().applyMatrix4(matrix));
    }
  });
  return { triangles, top: box.max.y, east: box.max.x, west: box.min.x };
}

let failed = false;
for (const file of files) {
  const found = drawn((await load(file)).scene);
  // Radii are right to 1 cm; 16 bits of 20 m are 0.3 mm, stretched by half again.
  const same = found.triangles === expected.triangles && Math.abs(found.top - expected.top) < 0.002 &&
               Math.abs(found.east - expected.east) < 0.011 && Math.abs(found.west - expected.west) < 0.011;
  console.log(`${same ? 'ok  ' : 'FAIL'} ${file}: ${JSON.stringify(found)}`);
  failed ||= !same;
}
if (failed) console.log(`expected ${JSON.stringify(expected)}`);
process.exit(failed || files.length === 0 ? 1 : 0);
