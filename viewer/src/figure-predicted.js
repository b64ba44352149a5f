// SPDX-License-Identifier: MIT
// Observed against predicted values for both methods.
import { equalClasses, extent } from "./classes.js";
import { figure, titled } from "./figure.js";
import { classTable } from "./figure-residuals.js";
import { decimals, r2, significant } from "./format.js";
import { lineLayer, pointLayer, points, sides } from "./observations.js";

const accuracyText = (accuracy, unit) => `R² ${r2(accuracy?.r2)}, RMSE ${decimals(accuracy?.rmse, 3)} ${unit}`;

/** @param {Result} result */
export function predictionFigure(result) {
  const { observations, unit } = result;
  const shown = sides(result);
  const domain = extent(observations.observed, ...shown.map(({ fitted }) => fitted));
  const chart = (side) => ({
    label: `Observed against predicted values of ${side.name}; the table behind the chart gives them in classes.`,
    x: { title: `Predicted (${unit})`, domain },
    y: { title: `Observed (${unit})`, domain },
    layers: [
      lineLayer("guide", domain, domain),
      pointLayer(side.kind, points(observations, side.fitted, observations.observed, (index) => `predicted ${significant(side.fitted[index], 4)} ${unit}, observed ${observations.observed[index]} ${unit}`)),
    ],
  });
  return figure({
    title: "Observed against predicted",
    legend: [["guide", "observed = predicted"]],
    charts: shown.map((side) => titled(`${side.name}: ${accuracyText(side.accuracy, unit)}`, chart(side))),
    behind: () => shown.map((side) => classTable(`Observed values in classes of the predictions of ${side.name}`, `Predicted, ${unit}`, `Observed, ${unit}`, equalClasses(side.fitted, observations.observed))),
  });
}
