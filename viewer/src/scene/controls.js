// SPDX-License-Identifier: MIT
// Controls: navigation mode, sizes, plot, detail, marks; and the arrow buttons for walking on touch screens.
import { element, section } from "../dom.js";
import { themeSwitch } from "../theme.js";
import { thinnedVariant, treeCount } from "./data.js";
import { filterControls } from "./filter-controls.js";
import { button, check, choice } from "./panel.js";

const unlabeled = (choices) => [{ label: null, choices }];

/**
 * The section of the controls.
 * @param {number | null} shownPlot  the plot that is shown alone
 * @param {object} page  whose methods they call
 * @returns {{node: Element, modeButtons: Element[], overlapNote: Element, scaleNote: Element, linkNote: Element, filters: Element | null}}  the section, and its parts that change
 */
export function controls(data, shownPlot, page) {
  const modeButtons = [modeButton("orbit", "Orbit", page), modeButton("walk", "Walk", page)];
  const overlapNote = element("p", { class: "quiet", role: "status" });
  const scaleNote = element("p", { class: "quiet" });
  const whole = button("whole", "Whole stand", () => page.frame());
  const save = button("save", "Save picture", () => page.save());
  const profile = data.variants.length > 0 && treeCount(data) > 0 ? [button("show-profile", "Cross-section", () => page.profile.open())] : [];
  const link = button("link", "Link to this view", () => page.link());
  const linkNote = element("p", { class: "quiet", role: "status" });
  const filters = treeCount(data) > 0 ? filterControls(data, (change) => page.setFilter(change)) : null;
  const theme = themeSwitch();
  theme.classList.add("is-for-list");
  const keys = button("show-keys", "Keys and touch", () => page.dialog.showModal());
  const node = section(
    "controls",
    "View",
    {},
    element("p", { class: "buttons", role: "group", "aria-label": "Navigation mode" }, ...modeButtons, whole),
    element("p", { class: "buttons" }, save, link, ...profile, keys),
    choice("picture-size", "Saved picture", unlabeled([2, 3, 4, 1].map((times) => ({ value: String(times), text: times === 1 ? "as large as the view" : `${times} times the view` }))), () => {}),
    linkNote,
    ...sizeChoices(data, page),
    ...plotChoice(data, shownPlot, page),
    ...(filters ? [filters] : []),
    choice("detail", "Detail", unlabeled(["automatic", "low", "high"].map((value) => ({ value, text: value }))), (detail) => page.setDetail(detail)),
    ...(treeCount(data) > 0 ? markChecks(overlapNote, page) : []),
    check("show-figures", "Drawing statistics", false, (isOn) => (page.figures.hidden = !isOn)),
    theme,
    scaleNote,
  );
  return { node, modeButtons, overlapNote, scaleNote, linkNote, filters };
}

function modeButton(mode, label, page) {
  const node = button(mode, label, () => {
    page.setMode(mode);
    // Keys walk immediately.
    if (mode === "walk") page.canvas.focus();
  });
  node.setAttribute("aria-pressed", String(mode === "orbit"));
  return node;
}

function sizeChoices(data, page) {
  if (!data.models || data.variants.length === 0) return [];
  const names = data.variants.map(({ name, title }) => ({ value: name, text: title }));
  const sizes = choice("variant", "Sizes", unlabeled(names), (name) => page.setVariant(0, name));
  if (names.length === 1) return [sizes];
  const beside = choice("beside", "Compare with", unlabeled([{ value: "", text: "nothing" }, ...names]), (name) => page.setVariant(1, name));
  beside.querySelector("select").value = thinnedVariant(data)?.name ?? "";
  return [sizes, beside];
}

function plotChoice(data, shownPlot, page) {
  if (data.plots.length < 2) return [];
  const plots = data.plots.map(({ name }, index) => ({ value: String(index), text: name }));
  const node = choice("plot", "Plot", unlabeled([{ value: "", text: "all" }, ...plots]), (plot) => page.setPlot(plot));
  // Without a 3D view the list of trees needs it, too.
  node.classList.add("is-for-list");
  if (shownPlot === null) return [node];
  node.querySelector("select").value = String(shownPlot);
  return [node, element("p", { class: "quiet" }, "Plots cover each other, probably because each has its own coordinate system: one is shown at a time.")];
}

function markChecks(overlapNote, page) {
  return [
    check("crowns", "Crown curves", false, (isOn) => page.setMarks({ crowns: isOn })),
    check("overlaps", "Overlapping crowns", false, (isOn) => page.setMarks({ overlaps: isOn })),
    overlapNote,
    check("shadows", "Shadows", true, (isOn) => page.view.setShadows(isOn)),
  ];
}

const ARROWS = [["ArrowUp", "↑", "Walk forward"], ["ArrowLeft", "←", "Turn left"], ["ArrowDown", "↓", "Walk back"], ["ArrowRight", "→", "Turn right"]];

/** Arrow buttons that walk while they are held, for screens without a keyboard. */
export function walkingPad(page) {
  const press = (code) => page.moves.press(code);
  const release = (code) => page.moves.release(code);
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
