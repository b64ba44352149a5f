// SPDX-License-Identifier: MIT
// Trees of ez-tree as GLB files, with what they measure: node export_ez_tree.mjs FOLDER 'PRESET=HEIGHT' ...
// A tree is scaled to the height [m] given, since ez-tree's lengths have no unit. Writes FOLDER/PRESET.glb and
// FOLDER/measured.json. Its photographs of bark are JPEG, which `silvafit render` does not read: they become PNG, smaller.
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import jpeg from 'jpeg-js';
import { PNG } from 'pngjs';

// ez-tree loads its pictures through the browser, from addresses that hold the whole file; this keeps the address.
class Picture {
  #listeners = [];
  addEventListener(event, listener) {
    if (event === 'load') this.#listeners.push(listener);
  }
  removeEventListener() {}
  set src(address) {
    this.bytes = Buffer.from(address.slice(address.indexOf(',') + 1), 'base64');
    this.type = address.slice('data:'.length, address.indexOf(';'));
    for (const listener of this.#listeners) listener.call(this);
  }
}
globalThis.document ??= { createElementNS: () => new Picture(), createElement: () => new Picture() };
globalThis.self ??= globalThis;

const { Tree, TreePreset } = await import('@dgreenheck/ez-tree');

/** A picture whose side is half as long. */
function halved({ width, height, data }) {
  const half = { width: width / 2, height: height / 2, data: Buffer.alloc(width * height) };
  for (let y = 0; y < half.height; ++y)
    for (let x = 0; x < half.width; ++x)
      for (let k = 0; k < 4; ++k) {
        const at = 4 * (2 * y * width + 2 * x) + k;
        half.data[4 * (y * half.width + x) + k] = (data[at] + data[at + 4] + data[at + 4 * width] + data[at + 4 * width + 4]) / 4;
      }
  return half;
}

/** A picture as PNG without transparency, 256 pixels wide, since `silvafit render` does not average pictures from afar. */
function asPng(picture) {
  if (picture.type === 'image/png') return picture.bytes;
  let pixels = jpeg.decode(picture.bytes);
  while (pixels.width > 256) pixels = halved(pixels);
  const png = new PNG({ width: pixels.width, height: pixels.height });
  pixels.data.copy(png.data);
  return PNG.sync.write(png);
}

function extent(positions, axis) {
  let low = Infinity;
  let high = -Infinity;
  for (let i = axis; i < positions.length; i += 3) {
    low = Math.min(low, positions[i]);
    high = Math.max(high, positions[i]);
  }
  return { low, high };
}

/** Girth of what a level plane cuts of a mesh: the length of all its edges. */
function girth({ attributes, index }, level) {
  const at = (corner) => attributes.position.array.slice(3 * index.array[corner], 3 * index.array[corner] + 3);
  let sum = 0;
  for (let corner = 0; corner < index.count; corner += 3) {
    const corners = [at(corner), at(corner + 1), at(corner + 2)];
    const cuts = [];
    for (let k = 0; k < 3; ++k) {
      const [a, b] = [corners[k], corners[(k + 1) % 3]];
      if (a[1] < level === b[1] < level) continue;
      const t = (level - a[1]) / (b[1] - a[1]);
      cuts.push([a[0] + t * (b[0] - a[0]), a[2] + t * (b[2] - a[2])]);
    }
    if (cuts.length === 2) sum += Math.hypot(cuts[1][0] - cuts[0][0], cuts[1][1] - cuts[0][1]);
  }
  return sum;
}

/** What the finished mesh measures, all lengths in its own unit but for those that end in _m. */
function measured(tree, height) {
  const [branches, leaves] = [tree.branchesMesh.geometry, tree.leavesMesh.geometry];
  const [wood, foliage] = [branches.attributes.position.array, leaves.attributes.position.array];
  const built = Math.max(extent(wood, 1).high, extent(foliage, 1).high);
  const meters = height / built;
  const widths = [0, 2].map((axis) => {
    const [a, b] = [extent(wood, axis), extent(foliage, axis)];
    return Math.max(a.high, b.high) - Math.min(a.low, b.low);
  });
  return {
    asked_trunk: tree.options.branch.length[0], // the only length of the whole tree that it can be asked for
    built,
    meters,
    h_m: height,
    hcb_m: Math.max(0, extent(foliage, 1).low) * meters,
    cw_m: (meters * (widths[0] + widths[1])) / 2,
    dbh_cm: (100 * meters * girth(branches, 1.3 / meters)) / Math.PI,
    triangles: (branches.index.count + leaves.index.count) / 3,
  };
}

/** Collects a GLB file's parts. */
class Glb {
  #bytes = [];
  #size = 0;
  json = {
    asset: { version: '2.0', generator: 'ez-tree 1.1.0' }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [] }], materials: [], textures: [], images: [], samplers: [{}], accessors: [], bufferViews: [],
  };

  view(array) {
    const bytes = Buffer.from(array.buffer, array.byteOffset, array.byteLength);
    this.json.bufferViews.push({ buffer: 0, byteOffset: this.#size, byteLength: bytes.length });
    const padding = Buffer.alloc((4 - (bytes.length % 4)) % 4);
    this.#bytes.push(bytes, padding);
    this.#size += bytes.length + padding.length;
    return this.json.bufferViews.length - 1;
  }

  accessor(array, type, more = {}) {
    const componentType = array instanceof Uint32Array ? 5125 : 5126;
    const count = array.length / { SCALAR: 1, VEC2: 2, VEC3: 3 }[type];
    this.json.accessors.push({ bufferView: this.view(array), componentType, count, type, ...more });
    return this.json.accessors.length - 1;
  }

  part({ geometry, material }, name, meters) {
    const position = geometry.attributes.position.array.map((value) => value * meters);
    const span = [0, 1, 2].map((axis) => extent(position, axis));
    const { repeat } = material.map;
    // The first row of a picture is its top in glTF, and its bottom in three.js.
    const uv = geometry.attributes.uv.array.map((value, i) => (i % 2 ? 1 - value * repeat.y : value * repeat.x));
    this.json.meshes[0].primitives.push({
      attributes: {
        POSITION: this.accessor(position, 'VEC3', { min: span.map((s) => s.low), max: span.map((s) => s.high) }),
        NORMAL: this.accessor(geometry.attributes.normal.array, 'VEC3'),
        TEXCOORD_0: this.accessor(uv, 'VEC2'),
      },
      indices: this.accessor(Uint32Array.from(geometry.index.array), 'SCALAR'),
      material: this.json.materials.length,
    });
    this.json.images.push({ bufferView: this.view(asPng(material.map.image)), mimeType: 'image/png' });
    this.json.textures.push({ source: this.json.images.length - 1, sampler: 0 });
    this.json.materials.push({
      name,
      pbrMetallicRoughness: {
        baseColorFactor: [...material.color.toArray(), 1], metallicFactor: 0,
        baseColorTexture: { index: this.json.textures.length - 1 },
      },
      ...(material.alphaTest > 0 && { alphaMode: 'MASK', alphaCutoff: material.alphaTest, doubleSided: true }),
    });
  }

  file() {
    this.json.buffers = [{ byteLength: this.#size }];
    let text = Buffer.from(JSON.stringify(this.json));
    text = Buffer.concat([text, Buffer.alloc((4 - (text.length % 4)) % 4, ' ')]);
    const head = (size, name) => Buffer.concat([uint32(size), Buffer.from(name)]);
    const body = Buffer.concat([head(text.length, 'JSON'), text, head(this.#size, 'BIN\0'), ...this.#bytes]);
    return Buffer.concat([Buffer.from('glTF'), uint32(2), uint32(12 + body.length), body]);
  }
}

function uint32(value) {
  const bytes = Buffer.alloc(4);
  bytes.writeUInt32LE(value);
  return bytes;
}

const [folder, ...wanted] = process.argv.slice(2);
if (wanted.length === 0) throw new Error("usage: node export_ez_tree.mjs FOLDER 'PRESET=HEIGHT' ...");
const results = {};
for (const text of wanted) {
  const [preset, height] = text.split('=');
  if (!(preset in TreePreset)) throw new Error(`ez-tree has no preset ${preset}: ${Object.keys(TreePreset).join(', ')}`);
  const tree = new Tree();
  tree.loadPreset(preset);
  tree.generate();
  const result = measured(tree, Number(height));
  const glb = new Glb();
  glb.part(tree.branchesMesh, 'bark', result.meters);
  // Leaves are seen from both sides: `silvafit render` lets light through what is, as through our own leaves.
  glb.part(tree.leavesMesh, 'leaves', result.meters);
  const bytes = glb.file();
  writeFileSync(join(folder, `${preset}.glb`), bytes);
  results[preset] = { ...result, bytes: bytes.length };
}
writeFileSync(join(folder, 'measured.json'), JSON.stringify(results, null, 1));
