// SPDX-License-Identifier: MIT
// Times other generators of trees on Node: node peers.mjs OUT.json [SECONDS]. Each grows trees with seeds of their own
// for the given time after a warm-up; times are CPU times of the process.
import { writeFileSync } from 'node:fs';

// ez-tree loads its pictures of bark and leaves through the browser; geometry needs none of them.
const element = { addEventListener() {}, removeEventListener() {}, set src(_) {}, style: {} };
globalThis.document ??= { createElementNS: () => ({ ...element }), createElement: () => ({ ...element }) };
globalThis.self ??= globalThis;

const { MeshBasicMaterial } = await import('three');
const { Tree, TreePreset } = await import('@dgreenheck/ez-tree');
const { TreeGenerator } = await import('three/addons/generators/TreeGenerator.js');

const [out, seconds = '1.5'] = process.argv.slice(2);
if (!out) throw new Error('usage: node peers.mjs OUT.json [SECONDS]');

function sizeOf(geometries) {
  let triangles = 0;
  let bytes = 0;
  for (const geometry of geometries) {
    triangles += geometry.index.count / 3;
    bytes += geometry.index.array.byteLength;
    for (const attribute of Object.values(geometry.attributes)) bytes += attribute.array.byteLength;
  }
  return { triangles, bytes };
}

function cpuSeconds() {
  const { user, system } = process.cpuUsage();
  return (user + system) / 1e6;
}

/** Grows trees until the time is spent. `grow(seed)` gives a tree's geometries. */
function time(name, grow) {
  for (let seed = 1; seed <= 20; ++seed) grow(seed);
  const start = cpuSeconds();
  let trees = 0;
  let triangles = 0;
  let bytes = 0;
  while (cpuSeconds() - start < Number(seconds)) {
    const size = sizeOf(grow(1000 + trees));
    triangles += size.triangles;
    bytes += size.bytes;
    ++trees;
  }
  return { name, seconds: cpuSeconds() - start, trees, triangles, bytes };
}

function ezTree(preset) {
  const tree = new Tree();
  tree.loadPreset(preset);
  return (seed) => {
    tree.options.seed = seed;
    tree.generate();
    return [tree.branchesMesh.geometry, tree.leavesMesh.geometry];
  };
}

function threeTree(parameters) {
  const material = new MeshBasicMaterial();
  return (seed) => {
    const generator = new TreeGenerator(material);
    Object.assign(generator.parameters, parameters, { seed });
    return [generator.build().geometry];
  };
}

const results = [];
for (const preset of Object.keys(TreePreset)) results.push(time(`ez-tree ${preset}`, ezTree(preset)));
results.push(time('three TreeGenerator', threeTree({})));
// One stem with as many first-order branches as a Chinese fir of ours, and twigs.
results.push(
  time('three TreeGenerator, conifer-like', threeTree({ levels: 3, children: [61, 8], branchAngle: [75, 55], trunkLength: 14 })),
);
writeFileSync(out, JSON.stringify({ results }, null, 1));
