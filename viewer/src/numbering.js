// SPDX-License-Identifier: MIT
// Numbers of figures and tables, in the order of the page. Tables in closed parts are numbered before they are created.

/** Placeholder of the number in a caption. */
const LABEL = ".label";

function label(node, text) {
  const place = node.querySelector(LABEL);
  if (place) place.textContent = `${text}. `;
  const frame = node.querySelector(".scroll");
  if (frame) frame.setAttribute("aria-label", `${text}. ${frame.getAttribute("aria-label")}`);
}

/** Tables behind a chart are named after it. */
function labelBehindChart(details, figure) {
  details.querySelectorAll(".table").forEach((table) => label(table, `Data of Figure ${figure.dataset.number}`));
}

function labelReserved(details) {
  details.querySelectorAll(".table").forEach((table, index) => label(table, `Table ${Number(details.dataset.firstTable) + index}`));
}

function labelMade({ target }) {
  const figure = target.closest("figure");
  if (figure) labelBehindChart(target, figure);
  else if (target.dataset.firstTable) labelReserved(target);
}

/** @param {Element} page  with all its figures and tables, except those in closed parts */
export function numberCaptions(page) {
  let figures = 0;
  let tables = 0;
  for (const node of page.querySelectorAll("figure, .table, details[data-tables]")) {
    if (node.matches("figure")) {
      node.dataset.number = String(++figures);
      label(node, `Figure ${figures}`);
    } else if (node.matches("details")) {
      node.dataset.firstTable = String(tables + 1);
      tables += Number(node.dataset.tables);
    } else {
      label(node, `Table ${++tables}`);
    }
  }
  page.addEventListener("made", labelMade);
}
