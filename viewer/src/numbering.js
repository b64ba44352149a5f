// SPDX-License-Identifier: MIT
// Numbers of figures and tables, in the order of the page. Tables in closed parts have their numbers before they are made.

/** Where a number stands in a caption, to be filled. */
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

/** @param {Element} page  whose figures and tables are all there, but for those in closed parts */
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
