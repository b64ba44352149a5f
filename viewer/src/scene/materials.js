// SPDX-License-Identifier: MIT
// glTF materials for drawing many trees, each with its own sizes and color from a texture.
import { MeshDepthMaterial, RGBADepthPacking, ShaderChunk } from "three";
import { PLACED, SIZED } from "./shape.js";

/* Cards are often seen from the side. */
const ANISOTROPY = 8;

export const COLOR_PARS = /* glsl */ `
varying vec3 vTreeColor;
varying float vTreeShade;
uniform float treeTint;
`;

/* Colored trees keep the light and dark of their leaves, and lose their hue. */
export const COLOR = /* glsl */ `
{
  float light = dot(diffuseColor.rgb, vec3(0.2126, 0.7152, 0.0722));
  vec3 tinted = vTreeColor * clamp(0.3 + 6.0 * light, 0.3, 1.3);
  diffuseColor.rgb = mix(diffuseColor.rgb * (0.85 + 0.3 * vTreeShade), tinted, treeTint);
}
`;

/*
 * Mipmaps average the opacity: with one threshold for all, far shoots would lose either their leaves or their gaps. From the first level on
 * each texel of a level is therefore drawn with the probability of its opacity, always the same texels.
 */
export const COVERAGE = /* glsl */ `
#if defined( USE_MAP ) && defined( USE_ALPHATEST )
{
  vec2 texel = vMapUv * vec2(textureSize(map, 0));
  vec2 dx = dFdx(texel);
  vec2 dy = dFdy(texel);
  float first = dot(dx, dx);
  float second = dot(dy, dy);
  // Of the narrow side of a pixel, as far as the filter is anisotropic.
  float level = max(0.0, 0.5 * log2(max(min(first, second), max(first, second) / ${ANISOTROPY * ANISOTROPY}.0)));
  vec2 cell = floor(texel / exp2(floor(level)));
  float chance = fract(sin(dot(cell, vec2(12.9898, 78.233))) * 43758.5453);
  float threshold = mix(alphaTest, clamp(chance, 0.05, 0.95), clamp(level, 0.0, 1.0));
  diffuseColor.a = diffuseColor.a < threshold ? 0.0 : 1.0;
}
#endif
#include <alphatest_fragment>
`;

/* Cards of shoots have normals of the crown, for both of their sides. */
export const BOTH_SIDES = ShaderChunk.normal_fragment_begin.replace("gl_FrontFacing ? 1.0 : - 1.0", "1.0");

/** Whether a material shows pictures of shoots. */
export const isCutOut = (material) => Boolean(material.map) && material.alphaTest > 0;

const sharpen = (material) => {
  if (isCutOut(material)) material.map.anisotropy = ANISOTROPY;
};

/** Functions that place the vertices of trees without sizes, or with them. */
export const placingOf = (isPlaced) => (isPlaced ? PLACED : SIZED);

/** Lets a shader place the vertices of trees by functions such as SIZED. */
export function placeTrees(shader, uniforms, functions) {
  Object.assign(shader.uniforms, uniforms);
  shader.vertexShader = shader.vertexShader
    .replace("#include <common>", `#include <common>\n${functions}`)
    .replace("#include <beginnormal_vertex>", `vec3 objectNormal = treeNormal(position, normal);\n#ifdef USE_TANGENT\nvec3 objectTangent = vec3(tangent.xyz);\n#endif`)
    .replace("#include <begin_vertex>", "vec3 transformed = treePosition(position);\nreadTreeColor();");
}

/**
 * A copy of a material for trees of one side of the view.
 * @param {import("three").Material} material
 * @param {{treeData: {value: object}, treeTint: {value: number}}} uniforms  shared with the side
 * @param {boolean} isPlaced  by matrices instead of sizes
 */
export function treeMaterial(material, uniforms, isPlaced) {
  sharpen(material);
  const copy = material.clone();
  copy.onBeforeCompile = (shader) => {
    placeTrees(shader, uniforms, placingOf(isPlaced));
    shader.fragmentShader = shader.fragmentShader
      .replace("#include <common>", `#include <common>\n${COLOR_PARS}`)
      .replace("#include <color_fragment>", `#include <color_fragment>\n${COLOR}`)
      .replace("#include <alphatest_fragment>", COVERAGE);
    if (isCutOut(material)) shader.fragmentShader = shader.fragmentShader.replace("#include <normal_fragment_begin>", BOTH_SIDES);
  };
  copy.customProgramCacheKey = () => `tree-${isPlaced ? "placed" : "sized"}${isCutOut(material) ? "-cut-out" : ""}`;
  return copy;
}

/** Lights pictures of shoots in a scene that is shown unchanged from both sides, too. */
export function lightBothSides(material) {
  if (!isCutOut(material)) return;
  sharpen(material);
  material.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader.replace("#include <alphatest_fragment>", COVERAGE).replace("#include <normal_fragment_begin>", BOTH_SIDES);
  };
  material.customProgramCacheKey = () => "both-sides";
}

/** The material for shadows of such trees, with the shape of the leaves on pictures. */
export function treeDepthMaterial(uniforms, isPlaced, shown) {
  const material = new MeshDepthMaterial({ depthPacking: RGBADepthPacking });
  if (isCutOut(shown)) Object.assign(material, { map: shown.map, alphaTest: shown.alphaTest });
  material.onBeforeCompile = (shader) => placeTrees(shader, uniforms, placingOf(isPlaced));
  material.customProgramCacheKey = () => `tree-depth-${isPlaced ? "placed" : "sized"}`;
  return material;
}

/** Lines in normalized coordinates of trees. */
export function treeLineMaterial(material, uniforms) {
  material.onBeforeCompile = (shader) => placeTrees(shader, uniforms, SIZED);
  material.customProgramCacheKey = () => "tree-line";
  return material;
}
