// SPDX-License-Identifier: MIT
// The tooltip: a text beside the pointer about a mark.
import { element } from "./dom.js";

const DISTANCE = 14;
let box = null;

function node() {
  box ??= document.body.appendChild(element("div", { class: "tip", "aria-hidden": "true", hidden: true }));
  return box;
}

/** Shows a text beside a position in the window, on the side with enough space. */
export function showTip(text, { clientX, clientY }) {
  const tip = node();
  tip.textContent = text;
  tip.hidden = false;
  const { width, height } = tip.getBoundingClientRect();
  const besides = clientX + DISTANCE + width > innerWidth ? clientX - DISTANCE - width : clientX + DISTANCE;
  const below = clientY + DISTANCE + height > innerHeight ? clientY - DISTANCE - height : clientY + DISTANCE;
  tip.style.left = `${Math.max(0, besides)}px`;
  tip.style.top = `${Math.max(0, below)}px`;
}

export function hideTip() {
  if (box !== null) box.hidden = true;
}
