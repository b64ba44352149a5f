// SPDX-License-Identifier: MIT
// The ground with plot boundaries, a scale bar on it, and a north arrow.
import { BufferGeometry, CanvasTexture, Float32BufferAttribute, Group, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, MeshStandardMaterial, Plane, PlaneGeometry, RepeatWrapping, SRGBColorSpace, Sprite, SpriteMaterial, Vector3 } from "three";
import { roundUp } from "../format.js";
import { outlinedPlots } from "./data.js";
import { Heights } from "./heights.js";

const LIFT_M = 0.05;
/** Ground that is shown around a single plot. */
const AROUND_M = 4;
/** Boundaries follow the ground in pieces of this length. */
const PIECE_M = 2;

/** Length of the scale bar: about a fifth of the stand, rounded. */
export const barLength = (extent) => Math.max(1, roundUp(extent / 8));

function textureOf(canvas) {
  const texture = new CanvasTexture(canvas);
  texture.colorSpace = SRGBColorSpace;
  return texture;
}

const signMaterial = () => new SpriteMaterial({ depthTest: false, toneMapped: false });
const flatMaterial = (opacity) => new MeshBasicMaterial({ transparent: true, opacity, toneMapped: false });

/** Draws a text onto a sign of this height in meters. */
function write(sign, text, color, height) {
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("2d");
  const font = "600 48px system-ui, 'DejaVu Sans', sans-serif";
  context.font = font;
  canvas.width = Math.ceil(context.measureText(text).width) + 16;
  canvas.height = 64;
  context.font = font;
  context.fillStyle = color;
  context.textBaseline = "middle";
  context.fillText(text, 8, 34);
  sign.material.map?.dispose();
  sign.material.map = textureOf(canvas);
  sign.scale.set((height * canvas.width) / canvas.height, height, 1);
}

const GRAIN_PIXELS = 256;
/** Side of the repeated picture of the ground [m]. */
const GRAIN_M = 6;

/** Light and dark patches of two sizes for the ground that one walks on; the same in every page. */
function grainTexture() {
  const canvas = Object.assign(document.createElement("canvas"), { width: GRAIN_PIXELS, height: GRAIN_PIXELS });
  const context = canvas.getContext("2d");
  context.fillStyle = "#d8d8d8";
  context.fillRect(0, 0, GRAIN_PIXELS, GRAIN_PIXELS);
  let seed = 1;
  const random = () => (seed = (seed * 16807) % 2147483647) / 2147483647;
  for (let patch = 0; patch < 2600; ++patch) {
    const size = patch < 200 ? 8 + 20 * random() : 1 + 3 * random();
    const light = random() < 0.5 ? 255 : 90;
    context.fillStyle = `rgba(${light}, ${light}, ${light}, ${patch < 200 ? 0.08 : 0.25})`;
    const [x, y] = [GRAIN_PIXELS * random(), GRAIN_PIXELS * random()];
    // Patches at an edge continue at the opposite one.
    for (const dx of [-GRAIN_PIXELS, 0, GRAIN_PIXELS]) {
      for (const dy of [-GRAIN_PIXELS, 0, GRAIN_PIXELS]) {
        context.beginPath();
        context.ellipse(x + dx, y + dy, size, 0.6 * size, 3 * random(), 0, 2 * Math.PI);
        context.fill();
      }
    }
  }
  const texture = textureOf(canvas);
  texture.wrapS = texture.wrapT = RepeatWrapping;
  texture.anisotropy = 4;
  return texture;
}

/** Texture coordinates from above. */
function layGrain({ attributes }, matrix) {
  const point = new Vector3();
  const uvs = new Float32Array(2 * attributes.position.count);
  for (let index = 0; index < attributes.position.count; ++index) {
    point.fromBufferAttribute(attributes.position, index).applyMatrix4(matrix);
    uvs.set([point.x / GRAIN_M, point.z / GRAIN_M], 2 * index);
  }
  return new Float32BufferAttribute(uvs, 2);
}

/** Triangle that points to the north, of length 1. */
const arrowGeometry = () => new BufferGeometry().setAttribute("position", new Float32BufferAttribute([-0.25, 0, 0.5, 0.25, 0, 0.5, 0, 0, -0.5], 3));

/** Ground of a scene for walking: its node `ground`, or else the height of its lowest point. */
export function floorOf(scene, box) {
  const surface = scene?.getObjectByName("ground");
  const heights = surface ? new Heights(surface) : null;
  return { heightAt: (x, z) => heights?.at(x, z) ?? (box.isEmpty() ? 0 : box.min.y) };
}

export class Ground {
  /**
   * @param {import("three").Mesh | null} surface  from the page's models
   * @param {object} data
   * @param {import("three").Box3} box             of the trees
   */
  constructor(surface, data, box) {
    this.group = new Group();
    this.data = data;
    this.box = box;
    this.material = new MeshStandardMaterial({ roughness: 1, metalness: 0 });
    this.surface = surface ?? this.plane();
    this.surface.traverse((object) => {
      if (!object.isMesh) return;
      object.material = this.material;
      object.receiveShadow = true;
    });
    this.group.add(this.surface);
    this.heights = new Heights(this.surface);
    this.outlines = this.outlinesOf(data.plots);
    this.outlinePlot(null);
    this.group.add(this.outlines);
    this.makeMarks();
  }

  plane() {
    const size = this.box.getSize(new Vector3());
    const center = this.box.getCenter(new Vector3());
    const mesh = new Mesh(new PlaneGeometry(size.x + 8, size.z + 8).rotateX(-Math.PI / 2));
    mesh.position.set(center.x, this.box.min.y - LIFT_M, center.z);
    return mesh;
  }

  /** Height of the ground, or of the lowest tree outside it. */
  heightAt(x, z) {
    return this.heights.at(x, z) ?? this.box.min.y;
  }

  /** Shows the grain of the ground, which is made when it is first shown. */
  setGrain(isShown) {
    if (isShown && !this.grain) {
      this.grain = grainTexture();
      this.surface.updateMatrixWorld(true);
      this.surface.traverse((object) => {
        if (object.isMesh) object.geometry.setAttribute("uv", layGrain(object.geometry, object.matrixWorld));
      });
    }
    const map = isShown ? this.grain : null;
    if (this.material.map === map) return;
    this.material.map = map;
    this.material.needsUpdate = true;
  }

  /** Colors, and the scale bar and the arrow for the current extent. @param {{ground: string, mark: string}} colors */
  paint(colors) {
    this.material.color.set(colors.ground);
    this.outlines.material.color.set(colors.mark);
    for (const material of this.flatMaterials) material.color.set(colors.mark);
    this.layBar(colors.mark);
    this.layNorth(colors.mark);
  }

  /** Boundaries of all plots, one after the other: that of plot i begins at vertex `outlineStarts[i]`. */
  outlinesOf(plots) {
    const vertices = [];
    this.outlineStarts = [0];
    for (const { outline } of plots) {
      outline.forEach((corner, index) => this.alongGround(corner, outline[(index + 1) % outline.length], vertices));
      this.outlineStarts.push(vertices.length / 3);
    }
    const geometry = new BufferGeometry().setAttribute("position", new Float32BufferAttribute(vertices, 3));
    return new LineSegments(geometry, new LineBasicMaterial({ toneMapped: false }));
  }

  /** Shows the boundary of one plot, or of all, and the ground around it. @param {number | null} plot */
  outlinePlot(plot) {
    const { min, max } = this.box;
    const near = [[1, 0, -min.x], [-1, 0, max.x], [0, 1, -min.z], [0, -1, max.z]].map(([x, z, away]) => new Plane(new Vector3(x, 0, z), away + AROUND_M));
    this.material.clippingPlanes = plot === null ? null : near;
    this.outlined = outlinedPlots(this.data, plot);
    const starts = this.outlineStarts;
    const [first, last] = plot === null ? [0, starts.at(-1)] : [starts[plot], starts[plot + 1]];
    this.outlines.geometry.setDrawRange(first, last - first);
  }

  /** Adds both ends of each piece of a line that follows the ground. */
  alongGround([x1, y1], [x2, y2], vertices) {
    const { x: east, y: north } = this.data.origin;
    const pieces = Math.max(1, Math.ceil(Math.hypot(x2 - x1, y2 - y1) / PIECE_M));
    for (let piece = 0; piece <= pieces; ++piece) {
      const share = piece / pieces;
      const x = x1 + share * (x2 - x1) - east;
      const z = north - (y1 + share * (y2 - y1));
      const y = this.heightAt(x, z) + 3 * LIFT_M;
      vertices.push(x, y, z);
      // The next piece starts where the previous one ends.
      if (piece > 0 && piece < pieces) vertices.push(x, y, z);
    }
  }

  /** The bar of five pieces, alternately filled, the arrow, and their labels. They are moved, never recreated: new materials must be compiled. */
  makeMarks() {
    this.flatMaterials = [flatMaterial(0.95), flatMaterial(0.25)];
    const plate = new PlaneGeometry(1, 1).rotateX(-Math.PI / 2);
    this.bar = Array.from({ length: 5 }, (_, piece) => new Mesh(plate, this.flatMaterials[piece % 2]));
    this.arrow = new Mesh(arrowGeometry(), this.flatMaterials[0]);
    this.barSign = new Sprite(signMaterial());
    this.northSign = new Sprite(signMaterial());
    this.group.add(...this.bar, this.arrow, this.barSign, this.northSign);
  }

  /** South of the current extent. */
  layBar(color) {
    const { min, max } = this.box;
    const length = barLength(Math.max(max.x - min.x, max.z - min.z));
    this.length = length;
    this.south = max.z + 1 + 0.06 * Math.max(max.x - min.x, max.z - min.z);
    const y = this.heightAt(min.x, max.z) + 2 * LIFT_M;
    this.bar.forEach((mesh, piece) => {
      mesh.scale.set(length / 5, 1, Math.max(0.3, length / 25));
      mesh.position.set(min.x + (piece + 0.5) * (length / 5), y, this.south);
    });
    write(this.barSign, `${length} m`, color, Math.max(0.8, length / 8));
    this.barSign.position.set(min.x + length / 2, y, this.south + Math.max(0.8, length / 7));
  }

  /** The extent of the bar, the arrow and their labels. */
  markCorners() {
    const { min, max } = this.box;
    const y = this.heightAt(min.x, max.z);
    const south = this.south + 0.35 * this.length + 0.4;
    return [min.x, min.x + 1.6 * this.length].map((x) => new Vector3(x, y, south));
  }

  layNorth(color) {
    const { min, max } = this.box;
    const size = this.length / 4;
    this.arrow.scale.set(size, 1, size);
    this.arrow.position.set(min.x + 1.4 * this.length, this.heightAt(min.x, max.z) + 2 * LIFT_M, this.south);
    write(this.northSign, "N", color, Math.max(0.8, this.length / 8));
    this.northSign.position.copy(this.arrow.position);
    this.northSign.position.z += Math.max(0.8, this.length / 5);
  }
}
