// SPDX-License-Identifier: MIT
// The ground with plot boundaries, a scale bar that lies on it, and an arrow to the north.
import { BufferGeometry, CanvasTexture, Float32BufferAttribute, Group, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, MeshStandardMaterial, PlaneGeometry, Raycaster, SRGBColorSpace, Sprite, SpriteMaterial, Vector3 } from "three";
import { roundUp } from "./colors.js";
import { outlinedPlots } from "./data.js";

const DOWN = new Vector3(0, -1, 0);
const SKY_M = 10_000;
const LIFT_M = 0.05;

/** Length of the scale bar: about a fifth of the stand, a round number of meters. */
export const barLength = (extent) => Math.max(1, roundUp(extent / 8));

function textureOf(canvas) {
  const texture = new CanvasTexture(canvas);
  texture.colorSpace = SRGBColorSpace;
  return texture;
}

function label(text, color, height) {
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
  const sprite = new Sprite(new SpriteMaterial({ map: textureOf(canvas), depthTest: false, toneMapped: false }));
  sprite.scale.set((height * canvas.width) / canvas.height, height, 1);
  return sprite;
}

/** What one stands on in a scene as it is: its ground, or else the height of its lowest point. */
export function floorOf(scene, box) {
  const surface = scene?.getObjectByName("ground") ?? null;
  const raycaster = new Raycaster();
  return {
    heightAt(x, z) {
      raycaster.set(new Vector3(x, SKY_M, z), DOWN);
      const hit = surface && raycaster.intersectObject(surface, true)[0];
      return hit ? hit.point.y : box.isEmpty() ? 0 : box.min.y;
    },
  };
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
    /** Number of the plot that is shown alone, or null for all. */
    this.shownPlot = null;
    this.raycaster = new Raycaster();
    this.material = new MeshStandardMaterial({ roughness: 1, metalness: 0 });
    this.surface = surface ?? this.plane();
    this.surface.traverse((object) => {
      if (!object.isMesh) return;
      object.material = this.material;
      object.receiveShadow = true;
    });
    this.group.add(this.surface);
    this.surface.updateMatrixWorld(true);
    this.marks = new Group();
    this.group.add(this.marks);
  }

  plane() {
    const size = this.box.getSize(new Vector3());
    const center = this.box.getCenter(new Vector3());
    const mesh = new Mesh(new PlaneGeometry(size.x + 8, size.z + 8).rotateX(-Math.PI / 2));
    mesh.position.set(center.x, this.box.min.y - LIFT_M, center.z);
    return mesh;
  }

  /** Height of the ground, or that of the lowest tree beside it. */
  heightAt(x, z) {
    this.raycaster.set(new Vector3(x, SKY_M, z), DOWN);
    return this.raycaster.intersectObject(this.surface, true)[0]?.point.y ?? this.box.min.y;
  }

  /** Draws marks and colors anew. @param {{ground: string, mark: string}} colors */
  paint(colors) {
    this.material.color.set(colors.ground);
    this.marks.traverse((object) => object.geometry?.dispose());
    this.marks.clear();
    this.addOutlines(colors.mark);
    this.addBar(colors.mark);
    this.addNorth(colors.mark);
  }

  addOutlines(color) {
    const points = [];
    this.outlined = outlinedPlots(this.data, this.shownPlot);
    for (const { outline } of this.outlined) {
      outline.forEach((corner, index) => points.push(...this.alongGround(corner, outline[(index + 1) % outline.length])));
    }
    if (points.length === 0) return;
    const geometry = new BufferGeometry().setAttribute("position", new Float32BufferAttribute(points.flat(), 3));
    this.marks.add(new LineSegments(geometry, new LineBasicMaterial({ color, toneMapped: false })));
  }

  /** Pieces of a line of 2 m at most that follow the ground. */
  alongGround([x1, y1], [x2, y2]) {
    const { x: east, y: north } = this.data.origin;
    const pieces = Math.max(1, Math.ceil(Math.hypot(x2 - x1, y2 - y1) / 2));
    const at = (piece) => {
      const share = piece / pieces;
      const x = x1 + share * (x2 - x1) - east;
      const z = north - (y1 + share * (y2 - y1));
      return [x, this.heightAt(x, z) + 3 * LIFT_M, z];
    };
    return Array.from({ length: pieces }, (_, piece) => [at(piece), at(piece + 1)]).flat();
  }

  /** Five pieces, every other one filled, south of the stand. */
  addBar(color) {
    const { min, max } = this.box;
    const length = barLength(Math.max(max.x - min.x, max.z - min.z));
    this.length = length;
    this.south = max.z + 1 + 0.06 * Math.max(max.x - min.x, max.z - min.z);
    const z = this.south;
    const y = this.heightAt(min.x, max.z) + 2 * LIFT_M;
    const width = Math.max(0.3, length / 25);
    for (let piece = 0; piece < 5; ++piece) {
      const mesh = new Mesh(new PlaneGeometry(length / 5, width).rotateX(-Math.PI / 2), new MeshBasicMaterial({ color, transparent: true, opacity: piece % 2 === 0 ? 0.95 : 0.25, toneMapped: false }));
      mesh.position.set(min.x + (piece + 0.5) * (length / 5), y, z);
      this.marks.add(mesh);
    }
    const text = label(`${length} m`, color, Math.max(0.8, length / 8));
    text.position.set(min.x + length / 2, y, z + Math.max(0.8, length / 7));
    this.marks.add(text);
  }

  /** What the bar, the arrow and their names take up. */
  markCorners() {
    const { min, max } = this.box;
    const y = this.heightAt(min.x, max.z);
    const south = this.south + 0.35 * this.length + 0.4;
    return [min.x, min.x + 1.6 * this.length].map((x) => new Vector3(x, y, south));
  }

  addNorth(color) {
    const { min, max } = this.box;
    const size = this.length / 4;
    const at = new Vector3(min.x + 1.4 * this.length, this.heightAt(min.x, max.z) + 2 * LIFT_M, this.south);
    const geometry = new BufferGeometry().setAttribute("position", new Float32BufferAttribute([-size / 4, 0, size / 2, size / 4, 0, size / 2, 0, 0, -size / 2], 3));
    const arrow = new Mesh(geometry, new MeshBasicMaterial({ color, transparent: true, opacity: 0.95, toneMapped: false }));
    arrow.position.copy(at);
    this.marks.add(arrow);
    const text = label("N", color, Math.max(0.8, this.length / 8));
    text.position.set(at.x, at.y, at.z + Math.max(0.8, this.length / 5));
    this.marks.add(text);
  }
}
