// SPDX-License-Identifier: MIT
// A line below wide tables with the number of columns that are not visible.
import { element } from "./dom.js";
import { plural } from "./format.js";

/** Columns that end beyond the right edge of the frame, and whether any lies beyond the left one. */
function outOfSight(frame) {
  const { right } = frame.getBoundingClientRect();
  const headings = [...frame.querySelectorAll("thead th")].map((heading) => heading.getBoundingClientRect());
  return { right: headings.filter((box) => box.right > right + 1).length, left: frame.scrollLeft > 1, isWide: frame.scrollWidth > frame.clientWidth + 1 };
}

function update(frame, hint) {
  const { right, left, isWide } = outOfSight(frame);
  hint.hidden = !isWide;
  frame.parentElement.dataset.more = [left ? "left" : "", right > 0 ? "right" : ""].join(" ").trim();
  hint.textContent = right > 0 ? `${plural(right, "more column")} to the right: scroll sideways \u2192` : "\u2190 All columns are to the left: scroll back";
}

const hints = new WeakMap();
let resized = null;

/** One observer for all tables, created with the first of them. */
function observer() {
  resized ??= new ResizeObserver((entries) => entries.forEach(({ target }) => update(target, hints.get(target))));
  return resized;
}

/** @returns {HTMLElement}  the line below the frame; hidden if the table is narrow */
export function followScroll(frame) {
  const hint = element("p", { class: "small hint", hidden: true, "aria-hidden": "true" });
  hints.set(frame, hint);
  frame.addEventListener("scroll", () => update(frame, hint), { passive: true });
  observer().observe(frame);
  return hint;
}
