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

/** A heading with a closed part below it; what it says must be enough without opening it. */
export function disclosure(summary, ...content) {
  return element("details", {}, element("summary", {}, ...[summary].flat()), ...content);
}

/** The mark that a fit cannot be used, or can. Word and sign say it, not color alone. */
export function verdictMark(converged) {
  return converged
    ? element("span", { class: "mark good" }, "\u2713 converged")
    : element("span", { class: "mark bad" }, "\u26a0 not converged");
}
