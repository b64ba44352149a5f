// SPDX-License-Identifier: MIT
// The charts of one species and response, in the order in which they are read.
import { element } from "./dom.js";
import { classFigure, curveFigure } from "./figure-curves.js";
import { predictionFigure } from "./figure-predicted.js";
import { randomFigure } from "./figure-random.js";
import { boxFigure, quantileFigure, residualFigure } from "./figure-residuals.js";
import { variogramFigure } from "./figure-variogram.js";
import { sides } from "./observations.js";

/** @param {Result} result */
export function figures(result) {
  if (result.observations.observed.length === 0) return [element("p", { class: "note" }, "There are no trees to draw.")];
  const ofFits = sides(result).length === 0 ? [] : [boxFigure, residualFigure, quantileFigure, variogramFigure, predictionFigure];
  const byPeriod = (one) => randomFigure(one, 1);
  return [curveFigure, classFigure, ...ofFits, randomFigure, byPeriod].map((draw) => draw(result)).filter((figure) => figure !== null);
}
