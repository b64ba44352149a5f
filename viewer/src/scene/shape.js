// SPDX-License-Identifier: MIT
// One model for many trees: a model is converted to normalized coordinates, and each tree applies its own sizes.
//
// In normalized coordinates heights are 0 at the ground, 1 at the crown base, 2 at the widest crown and 3 at the tip, and the distance of a
// crown point from the axis is relative to the crown radius in its azimuth. On the stem, 1 is breast height and 2 the tip; the thickness
// is kept and multiplied by the ratio of the DBHs.
// Every tree therefore has exactly its own height, crown base, widest height, four radii and DBH, and stays within its own crown curve.
import { radiusTowards } from "./crown.js";

export const BREAST_HEIGHT_M = 1.3;

/** Kinds of vertices. A pole is the stem of a stand-in: of radius 1, and as high as the crown base at 1. */
export const KIND = { crown: 0, stem: 1, pole: 2 };

/** Values of a tree in the texture: texels of four floats. */
export const TEXELS = 8;
export const TREES_PER_ROW = 256;
export const TEXEL = { place: 0, heights: 1, radii: 2, color: 3, matrix: 4 };

export function heightToUnit({ h, hcb, hc }, y) {
  if (y <= hcb) return hcb > 0 ? y / hcb : y > 0 ? 1 : y;
  if (y <= hc) return 1 + (y - hcb) / (hc - hcb);
  return 2 + (y - hc) / (h - hc);
}

const stemMetersPerUnit = ({ h }, unit) => (unit < 1 ? BREAST_HEIGHT_M : h - BREAST_HEIGHT_M);

/** Meters per unit of height there. */
function metersPerUnit({ h, hcb, hc }, unit) {
  if (unit <= 1) return Math.max(hcb, 1e-3);
  return Math.max(unit <= 2 ? hc - hcb : h - hc, 1e-3);
}

function stemHeightToUnit({ h }, y) {
  return y <= BREAST_HEIGHT_M ? y / BREAST_HEIGHT_M : 1 + (y - BREAST_HEIGHT_M) / (h - BREAST_HEIGHT_M);
}

const crownOfModel = ({ h, hcb, hc, radii }) => ({ h, hcb, hc, ...radii });

/**
 * Converts a model's vertices to normalized coordinates, in place.
 * @param {Float32Array} positions  x east, y up, z south of the stem's foot [m]
 * @param {Float32Array} normals
 * @param {{h: number, hcb: number, hc: number, radii: object}} model
 * @param {number} kind  of KIND
 */
export function toUnit(positions, normals, model, kind) {
  const crown = crownOfModel(model);
  for (let at = 0; at < positions.length; at += 3) {
    const [x, y, z] = [positions[at], positions[at + 1], positions[at + 2]];
    const sideways = kind === KIND.crown ? radiusTowards(crown, x, z) : 1;
    positions[at] = x / sideways;
    positions[at + 1] = kind === KIND.stem ? stemHeightToUnit(crown, y) : heightToUnit(crown, y);
    positions[at + 2] = z / sideways;
    const upwards = kind === KIND.stem ? stemMetersPerUnit(crown, positions[at + 1]) : metersPerUnit(crown, positions[at + 1]);
    const normal = [normals[at] * sideways, normals[at + 1] * upwards, normals[at + 2] * sideways];
    const length = Math.hypot(...normal) || 1;
    for (let axis = 0; axis < 3; ++axis) normals[at + axis] = normal[axis] / length;
  }
}

/** A rotation by a multiple of 90 degrees for each tree, so that neighbors with one model look different. */
export const turnOf = (tree) => ((tree * 2654435761) >>> 16) & 3;

/** Vertex functions that read the texture of the trees. */
export const READ_TREE = /* glsl */ `
attribute float treeIndex;
uniform highp sampler2D treeData;
varying vec3 vTreeColor;
varying float vTreeShade;
vec4 treeTexel(int which) {
  int tree = int(treeIndex + 0.5);
  return texelFetch(treeData, ivec2(${TEXELS} * (tree % ${TREES_PER_ROW}) + which, tree / ${TREES_PER_ROW}), 0);
}
void readTreeColor() {
  vTreeColor = treeTexel(${TEXEL.color}).rgb;
  vTreeShade = fract(sin(treeIndex * 12.9898) * 43758.5453);
}
`;

/** Vertex functions for trees with sizes in the texture. */
export const SIZED = /* glsl */ `
${READ_TREE}
attribute float treeKind;
const float BREAST = ${BREAST_HEIGHT_M.toFixed(1)};
vec2 treeTurned(vec2 q) {
  float turn = treeTexel(${TEXEL.heights}).w;
  return turn < 0.5 ? q : turn < 1.5 ? vec2(-q.y, q.x) : turn < 2.5 ? -q : vec2(q.y, -q.x);
}
float treeSideways(vec2 q) {
  if (treeKind > 1.5) return treeTexel(${TEXEL.color}).w;
  if (treeKind > 0.5) return treeTexel(${TEXEL.place}).w;
  vec4 radii = treeTexel(${TEXEL.radii});
  float square = dot(q, q);
  float share = square > 0.0 ? q.x * q.x / square : 1.0;
  return mix(q.y >= 0.0 ? radii.z : radii.w, q.x >= 0.0 ? radii.x : radii.y, share);
}
bool treeIsStem() {
  return treeKind > 0.5 && treeKind < 1.5;
}
vec3 treePosition(vec3 unit) {
  vec4 heights = treeTexel(${TEXEL.heights});
  float y = treeIsStem() ? (unit.y < 1.0 ? unit.y * BREAST : mix(BREAST, heights.x, unit.y - 1.0)) : unit.y < 1.0 ? unit.y * heights.y : unit.y < 2.0 ? mix(heights.y, heights.z, unit.y - 1.0) : mix(heights.z, heights.x, unit.y - 2.0);
  vec2 q = treeTurned(unit.xz);
  q *= treeSideways(q);
  return vec3(q.x, y, q.y) + treeTexel(${TEXEL.place}).xyz;
}
vec3 treeNormal(vec3 unit, vec3 normal) {
  vec4 heights = treeTexel(${TEXEL.heights});
  float upwards = treeIsStem() ? (unit.y < 1.0 ? BREAST : heights.x - BREAST) : unit.y < 1.0 ? heights.y : unit.y < 2.0 ? heights.z - heights.y : heights.x - heights.z;
  float sideways = treeSideways(treeTurned(unit.xz));
  vec2 level = treeTurned(normal.xz) / max(sideways, 0.001);
  return normalize(vec3(level.x, normal.y / max(upwards, 0.001), level.y) + vec3(0.0, 1e-9, 0.0));
}
`;

/** Vertex functions for trees without sizes, placed by the matrix in the texture. */
export const PLACED = /* glsl */ `
${READ_TREE}
vec3 treePosition(vec3 own) {
  vec4 at = vec4(own, 1.0);
  return vec3(dot(treeTexel(${TEXEL.matrix}), at), dot(treeTexel(${TEXEL.matrix + 1}), at), dot(treeTexel(${TEXEL.matrix + 2}), at));
}
vec3 treeNormal(vec3 own, vec3 normal) {
  vec3 a = treeTexel(${TEXEL.matrix}).xyz;
  vec3 b = treeTexel(${TEXEL.matrix + 1}).xyz;
  vec3 c = treeTexel(${TEXEL.matrix + 2}).xyz;
  vec3 squares = max(a * a + b * b + c * c, vec3(1e-20));
  vec3 n = normal / squares;
  return normalize(vec3(dot(a, n), dot(b, n), dot(c, n)) + vec3(0.0, 1e-9, 0.0));
}
`;
