// SPDX-License-Identifier: MIT
// Models with pictures of leaves, as small as they can be: a stem of four sides and one leaf, in two levels.
import { deflateSync } from "node:zlib";

/** A checksum of PNG (ISO 3309). */
function crc(bytes) {
  let value = ~0;
  for (const byte of bytes) {
    value ^= byte;
    for (let bit = 0; bit < 8; ++bit) value = (value >>> 1) ^ (value & 1 ? 0xedb88320 : 0);
  }
  return ~value >>> 0;
}

function chunk(type, content) {
  const body = Buffer.concat([Buffer.from(type, "latin1"), content]);
  const ends = [Buffer.alloc(4), Buffer.alloc(4)];
  ends[0].writeUInt32BE(content.length);
  ends[1].writeUInt32BE(crc(body));
  return Buffer.concat([ends[0], body, ends[1]]);
}

/** 64 x 64 pixels: the left half green and opaque, the right half black and transparent. */
function leafPicture() {
  const size = 64;
  const rows = Array.from({ length: size }, () => [0, ...Array.from({ length: size }, (_, x) => (x < size / 2 ? [60, 200, 40, 255] : [0, 0, 0, 0])).flat()]);
  const header = Buffer.alloc(13);
  header.writeUInt32BE(size, 0);
  header.writeUInt32BE(size, 4);
  header.set([8, 6, 0, 0, 0], 8);
  return Buffer.concat([Buffer.from([137, 80, 78, 71, 13, 10, 26, 10]), chunk("IHDR", header), chunk("IDAT", deflateSync(Buffer.from(rows.flat()))), chunk("IEND", Buffer.alloc(0))]);
}

class Glb {
  constructor() {
    this.json = { asset: { version: "2.0" }, scene: 0, scenes: [{ nodes: [] }], nodes: [], meshes: [], accessors: [], bufferViews: [], buffers: [] };
    this.bytes = [];
    this.size = 0;
  }

  view(buffer) {
    const padded = Buffer.concat([buffer, Buffer.alloc((4 - (buffer.length % 4)) % 4)]);
    this.bytes.push(padded);
    this.size += padded.length;
    return this.json.bufferViews.push({ buffer: 0, byteOffset: this.size - padded.length, byteLength: buffer.length }) - 1;
  }

  accessor(values, type) {
    const size = { VEC2: 2, VEC3: 3, SCALAR: 1 }[type];
    const isIndex = type === "SCALAR";
    const typed = isIndex ? new Uint16Array(values) : new Float32Array(values);
    const accessor = { bufferView: this.view(Buffer.from(typed.buffer)), componentType: isIndex ? 5123 : 5126, count: values.length / size, type };
    if (type === "VEC3") Object.assign(accessor, { min: [0, 1, 2].map((k) => Math.min(...values.filter((_, i) => i % 3 === k))), max: [0, 1, 2].map((k) => Math.max(...values.filter((_, i) => i % 3 === k))) });
    return this.json.accessors.push(accessor) - 1;
  }

  primitive(part, material, positions, normals, uvs, indices) {
    return {
      attributes: { POSITION: this.accessor(positions, "VEC3"), NORMAL: this.accessor(normals, "VEC3"), TEXCOORD_0: this.accessor(uvs, "VEC2") },
      indices: this.accessor(indices, "SCALAR"),
      material,
      extras: { part },
    };
  }

  add(name, primitives) {
    const mesh = this.json.meshes.push({ name, primitives }) - 1;
    this.json.scenes[0].nodes.push(this.json.nodes.push({ name, mesh }) - 1);
  }

  base64() {
    this.json.buffers = [{ byteLength: this.size }];
    const text = Buffer.from(JSON.stringify(this.json));
    const json = Buffer.concat([text, Buffer.alloc((4 - (text.length % 4)) % 4, 32)]);
    const words = (...values) => Buffer.concat(values.map((value) => (typeof value === "string" ? Buffer.from(value, "latin1") : Buffer.from(new Uint32Array([value]).buffer))));
    return Buffer.concat([words("glTF", 2, 28 + json.length + this.size, json.length, "JSON"), json, words(this.size, "BIN\0"), ...this.bytes]).toString("base64");
  }
}

const UP = [0, 1, 0];

/** The same data with models whose leaves are one picture with a mask, level and as wide as the crown. */
export function texturedModels(data) {
  const glb = new Glb();
  const picture = glb.view(leafPicture());
  Object.assign(glb.json, {
    images: [{ bufferView: picture, mimeType: "image/png" }],
    textures: [{ source: 0 }],
    materials: [
      { name: "bark", pbrMetallicRoughness: { baseColorFactor: [0.2, 0.1, 0.05, 1], metallicFactor: 0 } },
      { name: "leaf", alphaMode: "MASK", alphaCutoff: 0.5, doubleSided: true, pbrMetallicRoughness: { baseColorTexture: { index: 0 }, metallicFactor: 0 } },
    ],
  });
  data.models.shapes.forEach(({ h, hc, radii, dbh }, number) => {
    for (const level of data.models.levels) {
      const r = dbh / 200;
      const stem = [[r, 0, 0], [0, 0, r], [-r, 0, 0], [0, 0, -r], [0, h, 0]];
      const bark = glb.primitive("stem", 0, stem.flat(), stem.flatMap(([x, , z]) => (x || z ? [x / r, 0, z / r] : UP)), stem.flatMap(() => [0, 0]), [0, 4, 1, 1, 4, 2, 2, 4, 3, 3, 4, 0]);
      const leaf = [[-radii.west, hc, -radii.north], [-radii.west, hc, radii.south], [radii.east, hc, radii.south], [radii.east, hc, -radii.north]];
      const leaves = glb.primitive("foliage", 1, leaf.flat(), leaf.flatMap(() => UP), [0, 0, 0, 1, 1, 1, 1, 0], [0, 1, 2, 0, 2, 3]);
      glb.add(`model-${number}-level-${level}`, [bark, leaves]);
    }
  });
  const wide = 200;
  const ground = [[-wide, 0, -wide], [-wide, 0, wide], [wide, 0, wide], [wide, 0, -wide]];
  glb.add("ground", [glb.primitive("ground", 0, ground.flat(), ground.flatMap(() => UP), ground.flatMap(() => [0, 0]), [0, 1, 2, 0, 2, 3])]);
  data.models.glb = glb.base64();
  return data;
}
