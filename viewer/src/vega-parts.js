// SPDX-License-Identifier: MIT
// Vega-Lite, and the parts of Vega that its charts use; the package `vega` would add maps, word clouds and file formats.
import { transforms } from "vega-dataflow";
import * as encode from "vega-encode";
import { expressionInterpreter } from "vega-interpreter";
import { parse } from "vega-parser";
import * as dataTransforms from "vega-transforms";
import { View } from "vega-view";
import * as viewTransforms from "vega-view-transforms";

Object.assign(transforms, dataTransforms, encode, viewTransforms);

export { compile } from "vega-lite";
export { quantileNormal } from "vega-statistics";

/** A view whose expressions are interpreted, because the page's content security policy forbids code from text. */
export const viewOf = (spec, options) => new View(parse(spec, undefined, { ast: true }), { ...options, expr: expressionInterpreter });
