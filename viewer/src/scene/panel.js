// SPDX-License-Identifier: MIT
// The panel of controls: labeled, in order of use.
import { element } from "../dom.js";

/**
 * A labeled select element.
 * @param {{label: string | null, choices: {value: string, text: string}[]}[]} groups
 */
export function choice(id, label, groups, change) {
  const optionsOf = ({ choices }) => choices.map(({ value, text }) => element("option", { value }, text));
  const select = element("select", { id }, ...groups.flatMap((group) => (group.label === null ? optionsOf(group) : [element("optgroup", { label: group.label }, ...optionsOf(group))])));
  select.addEventListener("change", () => change(select.value));
  return element("p", { class: "control" }, element("label", { for: id }, label), select);
}

/** A labeled field; `change` gets null if it is empty. */
export function numberField(id, label, change, min = null) {
  const input = element("input", { type: "number", id, min, step: "any", inputmode: "decimal" });
  input.addEventListener("change", () => change(Number.isFinite(input.valueAsNumber) ? input.valueAsNumber : null));
  return element("p", { class: "control" }, element("label", { for: id }, label), input);
}

export function check(id, label, isOn, change) {
  const input = element("input", { type: "checkbox", id, checked: isOn });
  input.addEventListener("change", () => change(input.checked));
  return element("p", { class: "check" }, input, element("label", { for: id }, label));
}

export function button(id, label, press) {
  const node = element("button", { type: "button", id }, label);
  node.addEventListener("click", press);
  return node;
}

const KEYS = [
  ["Orbit", "Drag to turn, use the wheel or pinch to zoom, drag with the right button or two fingers to move the center. Arrows turn, + and − zoom, W A S D move the center."],
  ["Walk", "W and S or arrows up and down walk, A and D step aside, arrows left and right turn, Page Up and Page Down look up and down, Shift walks faster. Drag looks around; the arrow buttons on the view walk by touch."],
  ["Trees", "Click or tap a tree, or press its number in the list."],
  ["1, 2", "Orbit, walk (while the view has the focus)"],
  ["F", "The whole stand"],
  ["C, O", "Crown curves, overlapping crowns"],
  ["P", "Save the picture"],
  ["?", "This list"],
  ["Escape", "Deselect the tree"],
];

/** The list of keys and gestures. */
export function keysDialog() {
  return element(
    "dialog",
    { id: "keys", "aria-labelledby": "keys-title" },
    element("h2", { id: "keys-title" }, "Mouse, keys and touch"),
    element("dl", {}, ...KEYS.flatMap(([key, text]) => [element("dt", {}, key), element("dd", {}, text)])),
    element("form", { method: "dialog" }, element("button", { type: "submit" }, "Close")),
  );
}
