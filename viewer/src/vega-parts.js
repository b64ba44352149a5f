// SPDX-License-Identifier: MIT
// Vega-Lite, and the parts of Vega that its charts use; the package `vega` itself would bring maps, word clouds and file formats along.
import { transforms } from "vega-dataflow";
import * as encode from "vega-encode";
import * as dataTransforms from "vega-transforms";
import * as viewTransforms from "vega-view-transforms";

Object.assign(transforms, dataTransforms, encode, viewTransforms);

export { compile } from "vega-lite";
export { parse } from "vega-parser";
export { quantileNormal } from "vega-statistics";
export { View } from "vega-view";
