// SPDX-License-Identifier: MIT
// glTF materials for drawing many trees, each with its own sizes and color from a texture.
import { MeshDepthMaterial, RGBADepthPacking } from "three";
import { PLACED, SIZED } from "./shape.js";

const COLOR_PARS = /* glsl */ `
varying vec3 vTreeColor;
varying float vTreeShade;
uniform float treeTint;
`;

/* Colored trees keep the light and dark of their leaves, and lose their hue. */
const COLOR = /* glsl */ `
{
  float light = dot(diffuseColor.rgb, vec3(0.2126, 0.7152, 0.0722));
  vec3 tinted = vTreeColor * clamp(0.75 + 2.0 * light, 0.75, 1.15);
  diffuseColor.rgb = mix(diffuseColor.rgb * (0.85 + 0.3 * vTreeShade), tinted, treeTint);
}
`;

function bend(shader, uniforms, isPlaced) {
  Object.assign(shader.uniforms, uniforms);
  shader.vertexShader = shader.vertexShader
    .replace("#include <common>", `#include <common>\n${isPlaced ? PLACED : SIZED}`)
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
  const copy = material.clone();
  copy.onBeforeCompile = (shader) => {
    bend(shader, uniforms, isPlaced);
    shader.fragmentShader = shader.fragmentShader
      .replace("#include <common>", `#include <common>\n${COLOR_PARS}`)
      .replace("#include <color_fragment>", `#include <color_fragment>\n${COLOR}`);
  };
  copy.customProgramCacheKey = () => `tree-${isPlaced ? "placed" : "sized"}`;
  return copy;
}

/** The material for shadows of such trees. */
export function treeDepthMaterial(uniforms, isPlaced) {
  const material = new MeshDepthMaterial({ depthPacking: RGBADepthPacking });
  material.onBeforeCompile = (shader) => bend(shader, uniforms, isPlaced);
  material.customProgramCacheKey = () => `tree-depth-${isPlaced ? "placed" : "sized"}`;
  return material;
}

/** Lines in normalized coordinates of trees. */
export function treeLineMaterial(material, uniforms) {
  material.onBeforeCompile = (shader) => bend(shader, uniforms, false);
  material.customProgramCacheKey = () => "tree-line";
  return material;
}
