// SPDX-License-Identifier: MIT
// Wide tables: small type, and a line below with the number of columns that are still not visible.
import { element } from "./dom.js";
import { plural } from "./format.js";

const isWide = (frame) => frame.scrollWidth > frame.clientWidth + 1;

/** Columns that end beyond the right edge of the frame, and whether any lies beyond the left one. */
function outOfSight(frame) {
  const { right } = frame.getBoundingClientRect();
  const headings = [...frame.querySelectorAll("thead th")].map((heading) => heading.getBoundingClientRect());
  return { right: headings.filter((box) => box.right > right + 1).length, left: frame.scrollLeft > 1 };
}

function update(frame, hint) {
  const { right, left } = outOfSight(frame);
  hint.hidden = !isWide(frame);
  frame.parentElement.dataset.more = [left ? "left" : "", right > 0 ? "right" : ""].join(" ").trim();
  hint.textContent = right > 0 ? `${plural(right, "more column")} to the right: scroll sideways \u2192` : "\u2190 All columns are to the left: scroll back";
}

/** A table that is wider than its frame is set in small type with narrow columns. */
function fit(frame) {
  frame.classList.remove("compact");
  frame.classList.toggle("compact", isWide(frame));
  update(frame, hints.get(frame));
}

const hints = new WeakMap();
let resized = null;

/** One observer for all tables, created with the first of them. */
function observer() {
  resized ??= new ResizeObserver((entries) => entries.forEach(({ target }) => fit(target)));
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
