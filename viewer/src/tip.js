// SPDX-License-Identifier: MIT
// The text beside the pointer that tells what a mark is.
import { element } from "./dom.js";

const DISTANCE = 14;
let box = null;

function node() {
  box ??= document.body.appendChild(element("div", { class: "tip", "aria-hidden": "true", hidden: true }));
  return box;
}

/** Shows a text beside a place of the window, on the side that has room. */
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
