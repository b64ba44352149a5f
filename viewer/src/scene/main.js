// SPDX-License-Identifier: MIT
// The page of `silvafit view`.
import { Color } from "three";
import { element } from "../dom.js";
import { onThemeChange, startTheme } from "../theme.js";
import { colorings } from "./colors.js";
import { overlappingPairs } from "./crown.js";
import { crownLines, footRing, overlapMesh } from "./crown-lines.js";
import { counted, plotsCoincide, readData, treeCount, treeName } from "./data.js";
import { cardText, details } from "./details.js";
import { floorOf, Ground } from "./ground.js";
import { legend } from "./legend.js";
import { Moves } from "./moves.js";
import { button, check, choice, keysDialog, themeSwitch } from "./panel.js";
import { pick } from "./pick.js";
import "./scene.css";
import { loadStand } from "./sides.js";
import { TreeList } from "./tree-list.js";
import { View } from "./view.js";

/** Of stands with more overlapping pairs, those nearest to the middle of the picture are shown. */
const MOST_OVERLAPS = 1500;
const CLICK_PX = 6;

const cssColor = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const isCalm = () => matchMedia("(prefers-reduced-motion: reduce)").matches;
const linear = (hex) => new Color(hex).toArray();

class Page {
  constructor(data) {
    this.data = data;
    this.chosen = null;
    this.coloring = null;
    this.shownPlot = plotsCoincide(data) ? 0 : null;
    this.marks = { crowns: false, overlaps: false };
  }

  async start() {
    this.lay();
    if (!hasWebGl()) {
      this.sayTrouble("This browser has no WebGL 2, so there is no picture. The list of trees works without it.");
      return;
    }
    this.view = new View(this.canvas);
    this.loaded = await loadStand(this.data);
    this.variants = [this.data.variants[0], null];
    if (this.loaded.rest) this.view.scene.add(this.loaded.rest);
    this.setSides();
    this.view.setShadows(true);
    if (treeCount(this.data) > 0) {
      this.ground = new Ground(this.loaded.ground, this.data, this.extent());
      this.view.scene.add(this.ground.group);
    }
    const floor = this.ground ?? floorOf(this.loaded.rest, this.extent());
    this.moves = new Moves(this.view, (x, z) => floor.heightAt(x, z), isCalm());
    this.dress();
    onThemeChange(() => this.dress());
    this.frame();
    this.listen();
    this.view.onDrawn((stats) => this.tell(stats));
    this.view.draw();
  }

  /** Without a picture the trees can still be looked up. */
  sayTrouble(text) {
    this.main.classList.add("has-no-picture");
    this.picture.append(element("p", { class: "trouble", role: "alert" }, text));
    if (this.detailsPart.isConnected) this.detailsPart.replaceChildren(...details(this.data, this.chosen));
  }

  /** What there is to see: the trees, or else the scene. */
  extent() {
    const { box } = this.view;
    return box.isEmpty() ? box.setFromObject(this.view.scene) : box;
  }

  // ---- Layout -------------------------------------------------------------------------------

  lay() {
    const count = treeCount(this.data);
    this.canvas = element("canvas", {
      id: "canvas",
      tabindex: "0",
      role: "application",
      "aria-label": count > 0 ? `3D picture of ${counted(count, "tree")}` : "3D picture",
      "aria-describedby": "canvas-hint",
    });
    this.sideNames = [0, 1].map(() => element("div", { class: "overlay side-name", hidden: true }));
    this.divider = element("div", { class: "divider", hidden: true });
    this.figures = element("div", { class: "overlay figures", id: "figures", hidden: true });
    // Where the panel is hidden, it cannot say what is chosen.
    this.card = element("div", { class: "overlay card", hidden: true });
    this.pad = this.walkingPad();
    const hide = button("hide-panel", "Hide controls", () => this.togglePanel(hide));
    this.hideButton = hide;
    hide.classList.add("hide-panel");
    hide.setAttribute("aria-expanded", "true");
    hide.setAttribute("aria-controls", "panel");
    this.picture = element(
      "section",
      { class: "picture", "aria-label": "Picture" },
      this.canvas,
      element("p", { class: "hidden", id: "canvas-hint" }, "Press the question mark for keys. The list of trees beside the picture says in words what the picture shows."),
      this.divider,
      ...this.sideNames,
      this.figures,
      this.card,
      this.pad,
      hide,
    );
    this.main = element("main", {}, this.picture, this.panel());
    this.dialog = keysDialog();
    document.getElementById("page").replaceChildren(this.main, this.dialog);
  }

  panel() {
    const { data } = this;
    const count = treeCount(data);
    this.legendPart = element("div", { "aria-live": "polite" });
    this.detailsPart = element("div", { "aria-live": "polite", id: "details" });
    this.detailsSection = element("section", { "aria-labelledby": "details-title" }, element("h2", { id: "details-title" }, "Chosen tree"), this.detailsPart);
    this.list = count > 0 ? new TreeList(data, (tree) => this.choose(tree, true)) : null;
    this.list?.show(this.passes());
    const sentences = data.notes.map((note) => element("p", { class: "quiet" }, note));
    const notes = sentences.length > 1 ? [element("details", {}, element("summary", {}, `${sentences.length} notes on these trees`), ...sentences)] : sentences;
    this.aboutPart = element("p", { class: "quiet", id: "about" }, this.about());
    const about = count > 0 ? [this.aboutPart] : [];
    const trees =
      count > 0
        ? [
            element("section", { id: "colors", "aria-labelledby": "colors-title" }, element("h2", { id: "colors-title" }, "Colors"), this.colorChoice(), this.legendPart),
            this.detailsSection,
            this.list.node,
          ]
        : [];
    this.panelPart = element("div", { class: "panel", id: "panel" }, element("h1", {}, data.title), ...about, ...notes, this.controls(), ...trees);
    return this.panelPart;
  }

  /** How much is shown. */
  about() {
    const { data, shownPlot } = this;
    const all = treeCount(data);
    if (shownPlot === null) return `${counted(all, "tree")}, ${counted(data.plots.length, "plot")}, ${data.species.length} species`;
    const passes = this.passes();
    const shown = Array.from({ length: all }, (_, tree) => tree).filter(passes);
    const species = new Set(shown.map((tree) => data.trees.species[tree])).size;
    return `Plot ${data.plots[shownPlot].name}: ${shown.length} of ${counted(all, "tree")}, ${species} species`;
  }

  controls() {
    const { data } = this;
    const count = treeCount(data);
    this.modeButtons = ["orbit", "walk"].map((mode) => {
      const node = button(mode, mode === "orbit" ? "Orbit" : "Walk", () => {
        this.setMode(mode);
        // Keys walk at once.
        if (mode === "walk") this.canvas.focus();
      });
      node.setAttribute("aria-pressed", String(mode === "orbit"));
      return node;
    });
    const whole = button("whole", "Whole stand", () => this.frame());
    const save = button("save", "Save picture", () => this.save());
    const keys = button("show-keys", "Keys and touch", () => this.dialog.showModal());
    const parts = [element("p", { class: "buttons", role: "group", "aria-label": "Way of moving" }, ...this.modeButtons, whole), element("p", { class: "buttons" }, save, keys)];
    if (data.models && data.variants.length > 0) {
      const names = data.variants.map(({ name, title }) => ({ value: name, text: title }));
      parts.push(choice("variant", "Sizes", [{ label: null, choices: names }], (name) => this.setVariant(0, name)));
      if (names.length > 1) {
        parts.push(choice("beside", "Beside them", [{ label: null, choices: [{ value: "", text: "nothing" }, ...names] }], (name) => this.setVariant(1, name)));
      }
    }
    if (data.plots.length > 1) {
      const plots = data.plots.map(({ name }, index) => ({ value: String(index), text: name }));
      const plotChoice = choice("plot", "Plot", [{ label: null, choices: [{ value: "", text: "all" }, ...plots] }], (plot) => this.setPlot(plot));
      parts.push(plotChoice);
      if (this.shownPlot !== null) {
        plotChoice.querySelector("select").value = String(this.shownPlot);
        parts.push(element("p", { class: "quiet" }, "Plots lie on each other, as if each had coordinates of its own: one is shown at a time."));
      }
    }
    parts.push(
      choice("detail", "Detail", [{ label: null, choices: ["automatic", "low", "high"].map((value) => ({ value, text: value })) }], (detail) => {
        this.view.detail = detail;
        this.view.invalidate();
      }),
    );
    if (count > 0) {
      this.crownCheck = check("crowns", "Crown curves", false, (isOn) => this.setMarks({ crowns: isOn }));
      this.overlapCheck = check("overlaps", "Overlapping crowns", false, (isOn) => this.setMarks({ overlaps: isOn }));
      this.overlapNote = element("p", { class: "quiet", role: "status" });
      parts.push(this.crownCheck, this.overlapCheck, this.overlapNote);
      parts.push(check("shadows", "Shadows", true, (isOn) => this.view.setShadows(isOn)));
    }
    parts.push(check("show-figures", "Drawing figures", false, (isOn) => (this.figures.hidden = !isOn)), themeSwitch());
    this.scaleNote = element("p", { class: "quiet" });
    return element("section", { id: "controls", "aria-labelledby": "view-title" }, element("h2", { id: "view-title" }, "View"), ...parts, this.scaleNote);
  }

  colorChoice() {
    this.groups = colorings(this.data);
    const node = choice("color", "Color by", this.groups, (value) => this.setColoring(value));
    this.colorSelect = node.querySelector("select");
    return node;
  }

  /** Arrows that walk while they are held, for screens without keys. */
  walkingPad() {
    const pad = element("div", { class: "pad", role: "group", "aria-label": "Walk", hidden: true });
    for (const [code, sign, label] of [["ArrowUp", "↑", "Walk forward"], ["ArrowLeft", "←", "Turn left"], ["ArrowDown", "↓", "Walk back"], ["ArrowRight", "→", "Turn right"]]) {
      const node = element("button", { type: "button", "aria-label": label }, sign);
      node.addEventListener("pointerdown", () => this.moves.press(code));
      for (const end of ["pointerup", "pointerleave", "pointercancel"]) node.addEventListener(end, () => this.moves.release(code));
      // Keys and screen readers press without a pointer.
      node.addEventListener("click", (event) => {
        if (event.detail !== 0) return;
        this.moves.press(code);
        this.moves.release(code);
      });
      pad.append(node);
    }
    return pad;
  }

  togglePanel(node) {
    const isWide = this.main.classList.toggle("is-wide");
    node.textContent = isWide ? "Show controls" : "Hide controls";
    node.setAttribute("aria-expanded", String(!isWide));
    this.view.resize();
  }

  // ---- What is shown --------------------------------------------------------------------------

  setSides() {
    const variants = this.variants.filter((variant, index) => index === 0 || variant);
    this.view.setSides(variants.map((variant, side) => this.loaded.side(variant, side)));
    this.filter();
    this.paint();
    this.sideNames.forEach((node, index) => {
      node.hidden = variants.length < 2;
      node.textContent = variants[index]?.title ?? "";
    });
    this.layNames();
    this.drawMarks();
  }

  layNames() {
    const rectangles = this.view.rectangles();
    const { width, height } = this.view.size;
    rectangles.forEach((one, index) => {
      // The button lies in the upper right corner.
      const isUpperRight = one.y === 0 && one.x + one.width >= width - 1;
      const { style } = this.sideNames[index];
      style.left = `${one.x + 10}px`;
      style.top = `${one.y + 10}px`;
      style.maxWidth = `${one.width - 20 - (isUpperRight ? this.hideButton.offsetWidth + 10 : 0)}px`;
    });
    const second = rectangles[1];
    this.divider.hidden = !second;
    if (!second) return;
    const isBeside = second.x > 0;
    Object.assign(this.divider.style, isBeside ? { left: `${second.x - 1}px`, top: 0, width: "2px", height: `${height}px` } : { left: 0, top: `${second.y - 1}px`, width: `${width}px`, height: "2px" });
  }

  setVariant(side, name) {
    this.variants[side] = this.data.variants.find((variant) => variant.name === name) ?? null;
    this.setSides();
    this.view.invalidate();
  }

  passes() {
    const { shownPlot, data } = this;
    return shownPlot === null ? () => true : (tree) => data.trees.plot[tree] === shownPlot;
  }

  filter() {
    for (const { stand } of this.view.sides) stand.show(this.passes());
    this.view.shadowsChanged();
  }

  setPlot(plot) {
    this.shownPlot = plot === "" ? null : Number(plot);
    this.filter();
    this.list.show(this.passes());
    this.aboutPart.textContent = this.about();
    this.setColoring(this.colorSelect.value);
    if (this.chosen !== null && !this.passes()(this.chosen)) this.choose(null);
    if (this.ground) this.ground.box = this.extent();
    this.dress();
    this.frame();
  }

  setColoring(value) {
    const made = this.groups.flatMap(({ choices }) => choices).find((one) => one.value === value);
    this.coloring = made.make(this.passes());
    this.paint();
    this.view.invalidate();
  }

  paint() {
    const { coloring } = this;
    const known = new Map();
    const colorOf = (tree, variant) => {
      const hex = coloring.of(tree, variant);
      if (!known.has(hex)) known.set(hex, linear(hex));
      return known.get(hex);
    };
    for (const { stand, variant } of this.view.sides) stand.paint(coloring && ((tree) => colorOf(tree, variant)));
    this.legendPart.replaceChildren(...legend(coloring));
    if (this.chosen === null) this.detailsPart.replaceChildren(...details(this.data, null));
  }

  setMarks(change) {
    Object.assign(this.marks, change);
    this.drawMarks();
    this.view.invalidate();
  }

  drawMarks() {
    for (const mark of this.view.marks) {
      this.view.scene.remove(mark);
      mark.geometry.dispose();
      mark.material.dispose();
    }
    this.overlapTexts = [];
    this.view.marks = this.view.sides.flatMap((side) => this.marksOf(side));
    this.overlapNote?.replaceChildren(...this.overlapTexts.map((text) => element("span", { class: "line" }, text)));
    for (const mark of this.view.marks) this.view.scene.add(mark);
  }

  marksOf(side) {
    const shown = side.bodies.flatMap((body, tree) => (body && side.stand.shown[tree] ? [tree] : []));
    const marks = [];
    if (this.marks.crowns) marks.push(...crownLines(this.data, side, shown, cssColor("--line")));
    if (this.marks.overlaps) marks.push(overlapMesh(side, this.overlapsOf(side), cssColor("--overlap")));
    if (this.chosen !== null && side.bodies[this.chosen] && side.stand.shown[this.chosen]) {
      marks.push(...crownLines(this.data, side, [this.chosen], cssColor("--pick"), true), footRing(side, this.chosen, cssColor("--pick")));
    }
    return marks;
  }

  overlapsOf(side) {
    const pairs = overlappingPairs(side.bodies.map((body, tree) => (body && side.stand.shown[tree] ? body : null)));
    const { x, z } = this.moves.orbit.target;
    const distance = ({ first }) => Math.hypot(side.bodies[first].place.x - x, side.bodies[first].place.z - z);
    const near = pairs.length > MOST_OVERLAPS ? pairs.sort((a, b) => distance(a) - distance(b)).slice(0, MOST_OVERLAPS) : pairs;
    const whose = this.view.sides.length > 1 ? `${side.variant.title}: ` : "";
    const count = pairs.length === 1 ? "1 pair of crowns overlaps" : `${pairs.length} pairs of crowns overlap`;
    this.overlapTexts.push(`${whose}${count}; ${near.length < pairs.length ? `shown are the ${near.length} nearest to the middle of the picture.` : "the space that they share is shown."}`);
    return near;
  }

  // ---- What is done ---------------------------------------------------------------------------

  /** All that is shown, which is seen from afar. */
  frame() {
    this.setMode("orbit");
    this.moves.frame(this.extent(), this.ground?.markCorners() ?? []);
  }

  setMode(mode) {
    this.moves.setMode(mode);
    this.modeButtons.forEach((node) => node.setAttribute("aria-pressed", String(node.id === mode)));
    this.pad.hidden = mode !== "walk";
  }

  choose(tree, doesLook = false) {
    this.chosen = tree;
    this.detailsPart.replaceChildren(...details(this.data, tree));
    this.list.mark(tree);
    this.card.hidden = tree === null;
    this.card.textContent = tree === null ? "" : cardText(this.data, tree);
    if (tree !== null) this.showDetails();
    if (!this.view) return;
    this.drawMarks();
    const body = tree === null ? null : this.view.sides[0].bodies[tree];
    if (doesLook && body) this.moves.lookAt(body, (from, ahead) => pick(this.view.sides[0], this.data.trees.dbh, from, ahead) === tree);
    this.view.invalidate();
  }

  /** The panel alone is scrolled to what is told of the chosen tree. */
  showDetails() {
    const below = this.detailsSection.getBoundingClientRect().top - this.panelPart.getBoundingClientRect().top;
    this.panelPart.scrollTop += below - this.panelPart.clientTop;
  }

  async save() {
    const blob = await this.view.picture();
    const link = element("a", { href: URL.createObjectURL(blob), download: "silvafit-view.png" });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  }

  /** Colors that go with the theme. */
  dress() {
    this.view.setBackground(cssColor("--sky"));
    this.ground?.paint({ ground: cssColor("--ground"), mark: cssColor("--mark") });
    if (this.ground) this.scaleNote.textContent = `The scale bar on the ground is ${this.ground.length} m long; the arrow beside it points north.`;
    this.drawMarks();
    this.view.invalidate();
  }

  tell({ calls, triangles, milliseconds, trees }) {
    if (this.figures.hidden) return;
    this.figures.textContent = `${counted(trees, "tree")} in view, ${calls} drawing calls, ${triangles.toLocaleString("en")} triangles, ${milliseconds.toFixed(1)} ms`;
  }

  listen() {
    new ResizeObserver(() => {
      this.view.resize();
      this.layNames();
    }).observe(this.picture);
    let down = null;
    this.canvas.addEventListener("pointerdown", ({ clientX, clientY }) => (down = [clientX, clientY]));
    this.canvas.addEventListener("pointerup", ({ clientX, clientY }) => {
      if (down && Math.hypot(clientX - down[0], clientY - down[1]) < CLICK_PX) this.pickAt(clientX, clientY);
      down = null;
    });
    this.canvas.addEventListener("keydown", (event) => this.shortcut(event));
  }

  pickAt(clientX, clientY) {
    if (treeCount(this.data) === 0) return;
    const { left, top } = this.canvas.getBoundingClientRect();
    const { side, origin, direction } = this.view.rayAt(clientX - left, clientY - top);
    this.choose(pick(side, this.data.trees.dbh, origin, direction));
  }

  shortcut(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const click = (id) => document.getElementById(id)?.click();
    const actions = {
      1: () => this.setMode("orbit"),
      2: () => this.setMode("walk"),
      f: () => click("whole"),
      c: () => click("crowns"),
      o: () => click("overlaps"),
      p: () => click("save"),
      "?": () => this.dialog.showModal(),
      Escape: () => treeCount(this.data) > 0 && this.choose(null),
    };
    actions[event.key]?.();
  }
}

const hasWebGl = () => document.createElement("canvas").getContext("webgl2") !== null;

startTheme();
const data = readData();
const page = new Page(data);
/** For other scripts and tests: draws at once, says what was drawn and where trees are on the canvas. */
window.silvafitView = {
  ready: page.start().catch((error) => {
    page.sayTrouble(`The picture cannot be drawn: ${error.message}`);
    page.view = null;
  }),
  draw() {
    page.view.draw();
    return page.view.stats;
  },
  /** The middle of a tree's crown on the canvas [CSS pixels]. */
  whereIs(tree, side = 0) {
    const { crown, place } = page.view.sides[side].bodies[tree];
    return page.view.onCanvas({ ...place, y: place.y + (crown.hcb + crown.h) / 2 }, side);
  },
  camera: () => page.view.camera.position.toArray(),
  chosen: () => page.chosen,
  groundAt: (x, z) => page.moves.groundAt(x, z),
  hasObject: (name) => page.view.scene.getObjectByName(name) !== undefined,
  /** Corners of the scale bar, the arrow and their names on the canvas [CSS pixels]. */
  whereIsScale: () => page.ground.markCorners().map((corner) => page.view.onCanvas(corner)),
  names: () => Array.from({ length: treeCount(data) }, (_, tree) => treeName(data, tree)),
};
