// SPDX-License-Identifier: MIT
// Functions that create elements. Texts become text nodes, so that data are never read as markup.

/**
 * @param {string} tag
 * @param {Record<string, string | number | boolean | null | undefined>} attributes  null, undefined and false are omitted
 * @param {...(Node | string | null | undefined)} children  null and undefined are omitted
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

/** A section with a heading that names it. */
export const section = (id, title, attributes, ...children) =>
  element("section", { id, ...attributes, "aria-labelledby": `${id}-title` }, element("h2", { id: `${id}-title` }, title), ...children);

/** The same for elements of drawings. */
export function svg(tag, attributes = {}, ...children) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, String(value));
  node.append(...children);
  return node;
}

/** Closed parts that are not created yet, and the functions that create them. */
const unmade = new WeakMap();

function make(details) {
  const content = unmade.get(details);
  if (!content) return;
  unmade.delete(details);
  details.append(...content());
  details.dispatchEvent(new Event("made", { bubbles: true }));
}

/**
 * A heading with a closed part below it; the heading must be understandable without opening it.
 * @param {string | (Node | string)[]} summary
 * @param {() => Node[]} content  created when it is opened, because a report has some hundred of these
 * @param {number | null} tables  how many numbered tables it has
 */
export function disclosure(summary, content, tables = null) {
  const details = element("details", { "data-tables": tables }, element("summary", {}, ...[summary].flat()));
  unmade.set(details, content);
  details.addEventListener("toggle", () => make(details));
  return details;
}

/** The mark for a sound, doubtful or unusable fit: a word and a sign, in addition to the color. */
export function verdictMark(converged, sound = converged) {
  if (!converged) return element("span", { class: "mark bad" }, "\u26a0 not converged");
  return sound ? element("span", { class: "mark good" }, "\u2713 converged") : element("span", { class: "mark bad" }, "\u26a0 doubtful");
}
