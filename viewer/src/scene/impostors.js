// SPDX-License-Identifier: MIT
// Impostors: trees that are far away are drawn as one quad each, with pictures of a tree of their preset from the directions of the upper
// half of an octahedron. The page draws the pictures itself when it first needs them.
import { Color, DoubleSide, LinearFilter, LinearMipmapLinearFilter, Mesh, MeshBasicMaterial, MeshStandardMaterial, OrthographicCamera, Scene, ShaderChunk, Vector3, Vector4, WebGLRenderTarget } from "three";
import { listed } from "./models.js";
import { BOTH_SIDES, COLOR, COLOR_PARS, COVERAGE, isCutOut, placeTrees } from "./materials.js";
import { READ_TREE, TEXEL } from "./shape.js";

/** Pictures along a side of the atlas, and pixels along a side of a picture. */
const VIEWS = 6;
const PIXELS = 128;
/** Space around the tree in its picture, so that smaller copies of the atlas do not mix neighbors. */
const MARGIN = 1.08;
/** The tree in the pictures has the finest level of detail with at most so many triangles. */
const MOST_TRIANGLES = 6000;

/**
 * The direction of a point of the square from -1 to 1: the upper half of an octahedron, rotated by 45 degrees.
 * Source: Cigolle et al. 2014, A survey of efficient representations for independent unit vectors, JCGT 3(2).
 */
export function directionOf(u, v) {
  const [x, z] = [(u + v) / 2, (u - v) / 2];
  return new Vector3(x, Math.max(0, 1 - Math.abs(x) - Math.abs(z)), z).normalize();
}

/** Half the width and half the height of a tree's picture from a direction [m]. */
export function extentFrom({ y }, height, radius) {
  return { wide: MARGIN * radius, high: MARGIN * ((height / 2) * Math.sqrt(1 - y * y) + radius * y) };
}

/* The quad stands at the middle of the tree and faces the camera. The functions correspond to those above. */
const FACING = /* glsl */ `
${READ_TREE}
varying vec2 vCorner;
varying vec4 vViews;
vec3 treeRight;
vec3 treeUp;
vec3 treeToEye;
vec3 treePosition(vec3 corner) {
  vec4 heights = treeTexel(${TEXEL.heights});
  vec4 radii = treeTexel(${TEXEL.radii});
  float radius = max(max(radii.x, radii.y), max(radii.z, radii.w));
  vec3 middle = treeTexel(${TEXEL.place}).xyz + vec3(0.0, 0.5 * heights.x, 0.0);
  treeToEye = cameraPosition - middle;
  treeToEye = normalize(vec3(treeToEye.x + 1e-4, max(treeToEye.y, 0.0), treeToEye.z));
  treeRight = normalize(cross(vec3(0.0, 1.0, 0.0), treeToEye));
  treeUp = cross(treeToEye, treeRight);
  float level = sqrt(max(0.0, 1.0 - treeToEye.y * treeToEye.y));
  float high = 0.5 * heights.x * level + radius * treeToEye.y;
  float turn = heights.w;
  vec2 q = treeToEye.xz;
  q = turn < 0.5 ? q : turn < 1.5 ? vec2(-q.y, q.x) : turn < 2.5 ? -q : vec2(q.y, -q.x);
  vec2 place = vec2(q.x + q.y, q.x - q.y) / (abs(q.x) + abs(q.y) + treeToEye.y);
  vec2 cell = (0.5 * place + 0.5) * ${(VIEWS - 1).toFixed(1)};
  vec2 first = min(floor(cell), vec2(${(VIEWS - 2).toFixed(1)}));
  vViews = vec4(first, cell - first);
  vCorner = corner.xy;
  return middle + ${MARGIN} * (radius * corner.x * treeRight + high * corner.y * treeUp);
}
vec3 treeNormal(vec3 corner, vec3 normal) {
  treePosition(corner);
  return normalize(0.9 * corner.x * treeRight + 0.9 * corner.y * treeUp + 0.6 * treeToEye);
}
`;

const PICTURE_PARS = /* glsl */ `
uniform sampler2D impostorViews;
varying vec2 vCorner;
varying vec4 vViews;
vec4 pictureOf(vec2 view) {
  vec2 inside = clamp(0.5 + 0.5 * vCorner, ${(0.5 / PIXELS).toFixed(5)}, ${(1 - 0.5 / PIXELS).toFixed(5)});
  return texture2D(impostorViews, (view + inside) / ${VIEWS.toFixed(1)});
}
`;

/* The four nearest pictures, mixed by their distance in direction. Colors are stored as square roots, times the opacity. */
const PICTURE = /* glsl */ `
{
  vec2 share = vViews.zw;
  vec4 lower = mix(pictureOf(vViews.xy), pictureOf(vViews.xy + vec2(1.0, 0.0)), share.x);
  vec4 upper = mix(pictureOf(vViews.xy + vec2(0.0, 1.0)), pictureOf(vViews.xy + vec2(1.0)), share.x);
  vec4 seen = mix(lower, upper, share.y);
  vec2 texel = vCorner * ${(PIXELS / 2).toFixed(1)};
  vec2 dx = dFdx(texel);
  vec2 dy = dFdy(texel);
  float level = max(0.0, 0.5 * log2(max(dot(dx, dx), dot(dy, dy))));
  vec3 root = seen.rgb / max(seen.a, 0.001);
  // Each texel of a copy is drawn with the probability of its opacity, as those of shoots are: one threshold would close or remove crowns.
  vec2 cell = floor(texel / exp2(floor(level)));
  float chance = fract(sin(dot(cell, vec2(12.9898, 78.233))) * 43758.5453);
  diffuseColor = vec4(root * root, seen.a < mix(0.15, 0.75, chance) ? 0.0 : 1.0);
}
`;

/* Shadows fall on the side of the crown that is seen, not on its middle, which the tree itself shades. */
const ON_CROWN = ShaderChunk.worldpos_vertex.replace("vec4 worldPosition = vec4( transformed, 1.0 );", "vec4 worldPosition = vec4(transformed + 0.8 * length(treeTexel(${TEXEL.radii}).xz) * treeToEye, 1.0);".replace("${TEXEL.radii}", TEXEL.radii));

/** The material of the quads of one preset on one side of the view. */
export function impostorMaterial(views, uniforms) {
  const material = new MeshStandardMaterial({ roughness: 0.95, metalness: 0, alphaTest: 0.35, side: DoubleSide });
  material.onBeforeCompile = (shader) => {
    placeTrees(shader, { ...uniforms, impostorViews: views }, FACING);
    shader.vertexShader = shader.vertexShader.replace("#include <worldpos_vertex>", ON_CROWN);
    shader.fragmentShader = shader.fragmentShader
      .replace("#include <common>", `#include <common>\n${COLOR_PARS}\n${PICTURE_PARS}`)
      .replace("#include <map_fragment>", PICTURE)
      .replace("#include <color_fragment>", COLOR)
      .replace("#include <normal_fragment_begin>", BOTH_SIDES);
  };
  material.customProgramCacheKey = () => "tree-impostor";
  return material;
}

/** A material without light, for the pictures. */
function pictured(material, uniforms, functions) {
  const { color, map, alphaTest, vertexColors } = material;
  const plain = new MeshBasicMaterial({ color, map, alphaTest, vertexColors, side: DoubleSide, toneMapped: false });
  plain.onBeforeCompile = (shader) => {
    placeTrees(shader, uniforms, functions);
    shader.fragmentShader = shader.fragmentShader.replace("#include <alphatest_fragment>", COVERAGE).replace("#include <opaque_fragment>", "gl_FragColor = vec4(sqrt(outgoingLight), 1.0);");
  };
  plain.customProgramCacheKey = () => `tree-picture-${isCutOut(material)}-${functions.length}`;
  return plain;
}

/** The finest level that is small enough, or the coarsest. */
const levelOf = ({ levels, triangles }) => levels[Math.max(0, triangles.findIndex((count, level) => count <= MOST_TRIANGLES || level === levels.length - 1))];

/**
 * Draws pictures of a tree into an atlas.
 * @param {import("three").WebGLRenderer} renderer
 * @param {import("./models.js").Model} model
 * @param {{index: number, place: object, height: number, radius: number}} tree
 * @param {object} uniforms    of the tree's sizes
 * @param {string} functions   for the shader, that place the tree
 * @returns {WebGLRenderTarget}
 */
export function drawViews(renderer, model, tree, uniforms, functions) {
  const size = VIEWS * PIXELS;
  const target = new WebGLRenderTarget(size, size, { generateMipmaps: true, minFilter: LinearMipmapLinearFilter, magFilter: LinearFilter });
  target.scissorTest = true;
  const scene = new Scene();
  for (const { geometry, material } of levelOf(model)) {
    const mesh = new Mesh(listed(geometry, [tree.index]), pictured(material, uniforms, functions));
    mesh.frustumCulled = false;
    scene.add(mesh);
  }
  const before = { color: renderer.getClearColor(new Color()), alpha: renderer.getClearAlpha(), target: renderer.getRenderTarget() };
  renderer.setClearColor(0x000000, 0);
  const middle = new Vector3(tree.place.x, tree.place.y + tree.height / 2, tree.place.z);
  for (let view = 0; view < VIEWS * VIEWS; ++view) {
    const [column, row] = [view % VIEWS, Math.floor(view / VIEWS)];
    const direction = directionOf((2 * column) / (VIEWS - 1) - 1, (2 * row) / (VIEWS - 1) - 1);
    const { wide, high } = extentFrom(direction, tree.height, tree.radius);
    const distance = tree.height + 2 * tree.radius;
    const camera = new OrthographicCamera(-wide, wide, high, -high, 0, 2 * distance);
    camera.position.copy(middle).addScaledVector(direction, distance);
    camera.lookAt(middle);
    const frame = new Vector4(column * PIXELS, row * PIXELS, PIXELS, PIXELS);
    target.viewport.copy(frame);
    target.scissor.copy(frame);
    renderer.setRenderTarget(target);
    renderer.render(scene, camera);
  }
  renderer.setRenderTarget(before.target);
  renderer.setClearColor(before.color, before.alpha);
  for (const { geometry, material } of scene.children) {
    geometry.dispose();
    material.dispose();
  }
  return target;
}
