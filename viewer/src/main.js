// SPDX-License-Identifier: MIT
// Reads the data in the page and builds the report from them.
import "./style.css";
import { drawChartsWhenSeen } from "./chart-view.js";
import { element } from "./dom.js";
import { head } from "./head.js";
import { mapSection } from "./map.js";
import { navigation, resultId } from "./navigation.js";
import { resultSection } from "./result.js";

/** @returns {import("./types.js").Report} */
function readData() {
  return JSON.parse(document.getElementById("report-data").textContent);
}

function openDetailsForPrint() {
  let closed = [];
  addEventListener("beforeprint", () => {
    closed = [...document.querySelectorAll("details:not([open])")];
    closed.forEach((details) => (details.open = true));
  });
  addEventListener("afterprint", () => closed.forEach((details) => (details.open = false)));
}

function show(report) {
  const map = mapSection(report.map);
  const results = report.results.map((result, index) => resultSection(result, resultId(index)));
  document.getElementById("page").replaceWith(
    element("a", { class: "skip", href: "#main" }, "Skip to the report"),
    navigation(report),
    element("main", { id: "main", tabindex: "-1" }, head(report), ...(map ? [map] : []), ...results, foot(report)),
  );
}

const foot = (report) =>
  element("footer", {}, element("p", {}, `silvafit ${report.silvafit}. Made by: `, element("code", {}, report.command)));

show(readData());
openDetailsForPrint();
drawChartsWhenSeen(document.querySelectorAll(".chart"));
