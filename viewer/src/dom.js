// SPDX-License-Identifier: MIT
// Building elements. Texts become text nodes, so nothing in the data can become markup.

/**
 * @param {string} tag
 * @param {Record<string, string | number | boolean | null | undefined>} attributes  null, undefined and false are left out
 * @param {...(Node | string | null | undefined)} children  null and undefined are left out
 * @returns {HTMLElement}
 */
export function element(tag, attributes = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    node.setAttribute(name, value === true ? "" : String(value));
  }
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

/** Closed parts that are not made yet, and what makes them. */
const unmade = new WeakMap();

function make(details) {
  const content = unmade.get(details);
  if (!content) return;
  unmade.delete(details);
  details.append(...content());
  details.dispatchEvent(new Event("made", { bubbles: true }));
}

/**
 * A heading with a closed part below it; what it says must be enough without opening it.
 * @param {string | (Node | string)[]} summary
 * @param {() => Node[]} content  made when it is opened, since a report has some hundred of these
 * @param {number | null} tables  how many numbered tables it has
 */
export function disclosure(summary, content, tables = null) {
  const details = element("details", { "data-tables": tables }, element("summary", {}, ...[summary].flat()));
  unmade.set(details, content);
  details.addEventListener("toggle", () => make(details));
  return details;
}

/** The mark that a fit cannot be used, can, or can with doubts. Word and sign say it, not color alone. */
export function verdictMark(converged, sound = converged) {
  if (!converged) return element("span", { class: "mark bad" }, "\u26a0 not converged");
  return sound ? element("span", { class: "mark good" }, "\u2713 converged") : element("span", { class: "mark bad" }, "\u26a0 doubtful");
}
