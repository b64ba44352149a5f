// SPDX-License-Identifier: MIT
// Reads the data in the page and builds the report of a study, or a comparison of libraries. Report, Result and PlotMap, Comparison and ComparedModels are
// objects of report-data.schema.json and comparison-data.schema.json.
import "./base.css";
import "./style.css";
import { drawChartsWhenSeen } from "./chart-view.js";
import { comparisonPage } from "./comparison.js";
import { convergence } from "./convergence.js";
import { element } from "./dom.js";
import { district, noteList } from "./district.js";
import { heading, summary, verdict, whatWasDone } from "./head.js";
import { mapSection } from "./map.js";
import { navigation, resultId } from "./navigation.js";
import { numberCaptions } from "./numbering.js";
import { repeat } from "./repeat.js";
import { resultSection } from "./result.js";
import { modelTables, studyTables } from "./study-tables.js";
import { startTheme } from "./theme.js";

const readData = () => JSON.parse(document.getElementById("report-data").textContent);

/** @param {Report} report */
function reportPage(report) {
  const results = report.results.map((result, index) => resultSection(result, resultId(index)));
  const models = report.results.length > 0 || !report.stand ? [verdict(report), summary(report), modelTables(report), convergence(report)] : [];
  const tables = models.length > 0 ? [studyTables(report)] : [];
  return [heading(report), district(report), ...models, whatWasDone(report), mapSection(report.map), ...results, ...tables, noteList(report), repeat(report)].filter((part) => part !== null);
}

const PAGES = {
  "silvafit-report/1": reportPage,
  "silvafit-comparison/1": comparisonPage,
};

function show(data) {
  const parts = PAGES[data.schema](data);
  document.getElementById("page").replaceWith(
    element("a", { class: "skip", href: "#main" }, "Skip to the report"),
    navigation(parts, data.results),
    element("main", { id: "main", tabindex: "-1" }, ...parts, element("footer", {}, element("p", {}, `silvafit ${data.silvafit}`))),
  );
}

startTheme();
show(readData());
numberCaptions(document.getElementById("main"));
drawChartsWhenSeen(document.querySelectorAll(".chart"));
