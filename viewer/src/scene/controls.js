// SPDX-License-Identifier: MIT
// Controls: navigation mode, sizes, plot, detail, marks; and the arrow buttons for walking on touch screens.
import { element, section } from "../dom.js";
import { themeSwitch } from "../theme.js";
import { treeCount } from "./data.js";
import { filterControls } from "./filter-controls.js";
import { button, check, choice } from "./panel.js";

const unlabeled = (choices) => [{ label: null, choices }];

/**
 * The section of the controls.
 * @param {{
 *   setMode: (mode: string) => void, frame: () => void, save: () => void, link: () => void, showKeys: () => void, showProfile: () => void, setFilter: (change: object) => void,
 *   setVariant: (side: number, name: string) => void, setPlot: (plot: string) => void, setDetail: (detail: string) => void,
 *   setMarks: (change: object) => void, setShadows: (isOn: boolean) => void, setFigures: (isOn: boolean) => void,
 * }} act  what they do
 * @param {number | null} shownPlot  the plot that is shown alone
 * @returns {{node: Element, modeButtons: Element[], overlapNote: Element, scaleNote: Element, linkNote: Element, filters: Element | null}}  the section, and its parts that change
 */
export function controls(data, shownPlot, act) {
  const modeButtons = [modeButton("orbit", "Orbit", act), modeButton("walk", "Walk", act)];
  const overlapNote = element("p", { class: "quiet", role: "status" });
  const scaleNote = element("p", { class: "quiet" });
  const whole = button("whole", "Whole stand", act.frame);
  const save = button("save", "Save picture", act.save);
  const profile = data.variants.length > 0 && treeCount(data) > 0 ? [button("show-profile", "Cross-section", act.showProfile)] : [];
  const link = button("link", "Link to this view", act.link);
  const linkNote = element("p", { class: "quiet", role: "status" });
  const filters = treeCount(data) > 0 ? filterControls(data, act.setFilter) : null;
  const theme = themeSwitch();
  theme.classList.add("is-for-list");
  const keys = button("show-keys", "Keys and touch", act.showKeys);
  const node = section(
    "controls",
    "View",
    {},
    element("p", { class: "buttons", role: "group", "aria-label": "Navigation mode" }, ...modeButtons, whole),
    element("p", { class: "buttons" }, save, link, ...profile, keys),
    choice("picture-size", "Saved picture", unlabeled([2, 3, 4, 1].map((times) => ({ value: String(times), text: times === 1 ? "as large as the view" : `${times} times the view` }))), () => {}),
    linkNote,
    ...sizeChoices(data, act),
    ...plotChoice(data, shownPlot, act),
    ...(filters ? [filters] : []),
    choice("detail", "Detail", unlabeled(["automatic", "low", "high"].map((value) => ({ value, text: value }))), act.setDetail),
    ...(treeCount(data) > 0 ? markChecks(overlapNote, act) : []),
    check("show-figures", "Drawing statistics", false, act.setFigures),
    theme,
    scaleNote,
  );
  return { node, modeButtons, overlapNote, scaleNote, linkNote, filters };
}

function modeButton(mode, label, act) {
  const node = button(mode, label, () => act.setMode(mode));
  node.setAttribute("aria-pressed", String(mode === "orbit"));
  return node;
}

function sizeChoices(data, act) {
  if (!data.models || data.variants.length === 0) return [];
  const names = data.variants.map(({ name, title }) => ({ value: name, text: title }));
  const sizes = choice("variant", "Sizes", unlabeled(names), (name) => act.setVariant(0, name));
  if (names.length === 1) return [sizes];
  return [sizes, choice("beside", "Compare with", unlabeled([{ value: "", text: "nothing" }, ...names]), (name) => act.setVariant(1, name))];
}

function plotChoice(data, shownPlot, act) {
  if (data.plots.length < 2) return [];
  const plots = data.plots.map(({ name }, index) => ({ value: String(index), text: name }));
  const node = choice("plot", "Plot", unlabeled([{ value: "", text: "all" }, ...plots]), act.setPlot);
  // Without a 3D view the list of trees needs it, too.
  node.classList.add("is-for-list");
  if (shownPlot === null) return [node];
  node.querySelector("select").value = String(shownPlot);
  return [node, element("p", { class: "quiet" }, "Plots cover each other, probably because each has its own coordinate system: one is shown at a time.")];
}

function markChecks(overlapNote, act) {
  return [
    check("crowns", "Crown curves", false, (isOn) => act.setMarks({ crowns: isOn })),
    check("overlaps", "Overlapping crowns", false, (isOn) => act.setMarks({ overlaps: isOn })),
    overlapNote,
    check("shadows", "Shadows", true, act.setShadows),
  ];
}

const ARROWS = [["ArrowUp", "↑", "Walk forward"], ["ArrowLeft", "←", "Turn left"], ["ArrowDown", "↓", "Walk back"], ["ArrowRight", "→", "Turn right"]];

/**
 * Arrow buttons that walk while they are held, for screens without a keyboard.
 * @param {{press: (code: string) => void, release: (code: string) => void}} keys  what pressed arrow keys do
 */
export function walkingPad({ press, release }) {
  const pad = element("div", { class: "pad", role: "group", "aria-label": "Walk", hidden: true });
  for (const [code, sign, label] of ARROWS) {
    const node = element("button", { type: "button", "aria-label": label }, sign);
    node.addEventListener("pointerdown", () => press(code));
    for (const end of ["pointerup", "pointerleave", "pointercancel"]) node.addEventListener(end, () => release(code));
    // Keyboards and screen readers press without a pointer.
    node.addEventListener("click", (event) => {
      if (event.detail !== 0) return;
      press(code);
      release(code);
    });
    pad.append(node);
  }
  return pad;
}
