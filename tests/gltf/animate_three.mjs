// SPDX-License-Identifier: MIT
// Plays an animated scene with three.js and compares what is seen at each year with the inventory:
// node animate_three.mjs INVENTORY.csv SCENE.glb
import { readFileSync } from 'node:fs';

// What browsers have and Node has not.
globalThis.self = globalThis;
globalThis.ProgressEvent ??= class extends Event {};
const { AnimationMixer, Box3 } = await import('three');
const { GLTFLoader } = await import('three/examples/jsm/loaders/GLTFLoader.js');

const [inventoryFile, sceneFile] = process.argv.slice(2);
const [head, ...lines] = readFileSync(inventoryFile, 'utf8').trim().split('\n');
const names = head.split(',');
const rows = lines.map((line) => Object.fromEntries(line.split(',').map((v, i) => [names[i], v])));
const years = [...new Set(rows.map((row) => Number(row.year)))].sort((a, b) => a - b);

const bytes = readFileSync(sceneFile);
const exact = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length);
const { scene, animations } = await new GLTFLoader().parseAsync(exact, '');
if (animations.length !== 1) throw new Error(`${animations.length} animations`);
const mixer = new AnimationMixer(scene);
mixer.clipAction(animations[0]).play();

/** Heights of the trees that have a size now, by name. */
function heights(time) {
  mixer.setTime(time);
  scene.updateMatrixWorld(true);
  const found = new Map();
  scene.traverse((object) => {
    if (!object.isMesh) return;
    if (object.matrixWorld.determinant() === 0) return;
    let root = object;
    while (root.parent !== scene) root = root.parent;
    if (root.name === 'ground') return;
    object.geometry.computeBoundingBox();
    const box = new Box3().copy(object.geometry.boundingBox).applyMatrix4(object.matrixWorld);
    found.set(root.name, Math.max(found.get(root.name) ?? 0, box.max.y));
  });
  return found;
}

let failed = false;
function compare(what, time, wanted) {
  const found = heights(time);
  let worst = 0;
  for (const [tree, h] of wanted) worst = Math.max(worst, Math.abs((found.get(tree) ?? 0) - h));
  // Heights in the file are right to a centimeter, keyframes to a float.
  const same = found.size === wanted.size && worst < 0.011;
  console.log(`${same ? 'ok  ' : 'FAIL'} ${what}: ${found.size} of ${wanted.size} trees, ` +
              `heights at most ${worst.toFixed(4)} m off`);
  failed ||= !same;
}

const of = (year) => new Map(rows.filter((row) => Number(row.year) === year)
                                 .map((row) => [`${row.plot}-${row.tree}`, Number(row.h)]));
for (const year of years) {
  // One second a year; a hair later, as a stage begins at its very time.
  compare(`year ${year}`, year - years[0] + 1e-4, of(year));
}
// Halfway through the 38 days in which they shoot, new culms are half as high; the old ones stand.
const half = new Map(of(years[0]));
for (const [tree, h] of of(years[1])) if (!half.has(tree)) half.set(tree, 0.5 * h);
compare('new culms halfway up', 1 - 0.5 * 38 / 365, half);
process.exit(failed ? 1 : 0);
