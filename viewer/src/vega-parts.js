// SPDX-License-Identifier: MIT
// The parts of Vega that the charts use; the package `vega` itself would bring maps, word clouds and file formats along.
import { transforms } from "vega-dataflow";
import * as encode from "vega-encode";
import * as dataTransforms from "vega-transforms";
import * as viewTransforms from "vega-view-transforms";

Object.assign(transforms, dataTransforms, encode, viewTransforms);

export { parse } from "vega-parser";
export { View } from "vega-view";
