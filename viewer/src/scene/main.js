// SPDX-License-Identifier: MIT
// The page of `silvafit view`.
import { Color } from "three";
import { save } from "../csv.js";
import { element, section } from "../dom.js";
import { onThemeChange, startTheme } from "../theme.js";
import { colorings } from "./colors.js";
import { controls, walkingPad } from "./controls.js";
import { counted, plotsCoincide, readData, thinnedVariant, treeCount } from "./data.js";
import { cardText, details } from "./details.js";
import { ALL, isNarrow, passesOf, residualsOf } from "./filters.js";
import { showFilter } from "./filter-controls.js";
import { floorOf, Ground } from "./ground.js";
import { listenToClicks, listenToKeys } from "./keyboard.js";
import { legend } from "./legend.js";
import { fragmentOf, stateOf } from "./link.js";
import { Marks } from "./marks.js";
import { Moves } from "./moves.js";
import { button, choice, keysDialog } from "./panel.js";
import { pick } from "./pick.js";
import { Player } from "./player.js";
import { ProfileDialog } from "./profile-dialog.js";
import { savedPicture } from "./saved-picture.js";
import "../base.css";
import "./scene.css";
import { loadStand } from "./sides.js";
import { timeControls } from "./time-controls.js";
import { TreeList } from "./tree-list.js";
import { View } from "./view.js";

const cssColor = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const isCalm = () => matchMedia("(prefers-reduced-motion: reduce)").matches;
const linear = (hex) => new Color(hex).toArray();

class Page {
  constructor(data) {
    this.data = data;
    this.chosen = null;
    this.coloring = null;
    this.linked = stateOf(location.hash);
    const isKnown = (value, count) => value !== null && Number.isInteger(value) && value >= 0 && value < count;
    const { filter } = this.linked;
    const known = { plot: data.plots.length, species: data.species.length, layer: data.layers.length, residual: residualsOf(data).length };
    const kept = Object.entries(filter).map(([name, value]) => [name, name in known && !isKnown(value, known[name]) ? null : value]);
    this.filtered = { ...ALL, ...Object.fromEntries(kept) };
    if (this.filtered.plot === null && plotsCoincide(data)) this.filtered.plot = 0;
  }

  /** The plot that is shown alone, or null. */
  get shownPlot() {
    return this.filtered.plot;
  }

  async start() {
    this.lay();
    if (!hasWebGl()) {
      this.sayTrouble("This browser has no WebGL 2, so the 3D view is not available. The list of trees works without it.");
      return;
    }
    this.view = new View(this.canvas);
    this.marks = new Marks(this.data, this.view, cssColor);
    this.loaded = await loadStand(this.data);
    this.addPlayer();
    this.variants = [this.data.variants[0], thinnedVariant(this.data)];
    if (this.loaded.rest) this.view.scene.add(this.loaded.rest);
    this.setSides();
    this.view.setShadows(true);
    if (treeCount(this.data) > 0) {
      this.ground = new Ground(this.loaded.ground, this.data, this.extent());
      this.ground.outlinePlot(this.shownPlot);
      this.view.scene.add(this.ground.group);
    }
    const floor = this.ground ?? floorOf(this.loaded.rest, this.extent());
    this.moves = new Moves(this.view, (x, z) => floor.heightAt(x, z), isCalm());
    this.dress();
    onThemeChange(() => this.dress());
    this.frame();
    this.restore();
    this.listen();
    this.view.onDrawn((stats) => this.tell(stats));
    this.view.draw();
  }

  /** Scenes that change over time have a slider. */
  addPlayer() {
    const { animations, rest } = this.loaded;
    if (!animations?.length) return;
    const times = timeControls(new Player(rest, animations), () => this.view.shadowsChanged());
    this.panelPart.querySelector("#controls").before(times);
  }

  /** Without a 3D view the list of trees still works. */
  sayTrouble(text) {
    this.main.classList.add("has-no-picture");
    this.picture.append(element("p", { class: "trouble", role: "alert" }, text));
    if (this.detailsPart.isConnected) this.detailsPart.replaceChildren(...details(this.data, this.chosen));
  }

  /** The title of the view: the trees, or else the scene. */
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
      "aria-label": count > 0 ? `3D view of ${counted(count, "tree")}` : "3D view",
      "aria-describedby": "canvas-hint",
    });
    this.sideNames = [0, 1].map(() => element("div", { class: "overlay side-name", hidden: true }));
    this.divider = element("div", { class: "divider", hidden: true });
    this.figures = element("div", { class: "overlay figures", id: "figures", hidden: true });
    // If the panel is hidden, the card shows the selected tree.
    this.card = element("div", { class: "overlay card", hidden: true });
    this.pad = walkingPad(this);
    const hide = button("hide-panel", "Hide controls", () => this.togglePanel(hide));
    this.hideButton = hide;
    hide.classList.add("hide-panel");
    hide.setAttribute("aria-expanded", "true");
    hide.setAttribute("aria-controls", "panel");
    this.picture = element(
      "section",
      { class: "picture", "aria-label": "Picture" },
      this.canvas,
      element("p", { class: "hidden", id: "canvas-hint" }, "Press the question mark for a list of keys. The list of trees next to the view has the data of all trees as text."),
      this.divider,
      ...this.sideNames,
      this.figures,
      this.card,
      this.pad,
      hide,
    );
    this.main = element("main", {}, this.picture, this.panel());
    this.dialog = keysDialog();
    this.profile = new ProfileDialog(this.data, () => this.shown());
    document.getElementById("page").replaceChildren(this.main, this.dialog, this.profile.node);
  }

  panel() {
    const { data } = this;
    const count = treeCount(data);
    this.legendPart = element("div", { "aria-live": "polite" });
    this.detailsPart = element("div", { "aria-live": "polite", id: "details" });
    this.detailsSection = element("section", { "aria-labelledby": "details-title" }, element("h2", { id: "details-title" }, "Selected tree"), this.detailsPart);
    this.list = count > 0 ? new TreeList(data, (tree) => this.choose(tree, true)) : null;
    this.list?.show(this.passes());
    const sentences = data.notes.map((note) => element("p", { class: "quiet" }, note));
    const notes = sentences.length > 1 ? [element("details", {}, element("summary", {}, `${sentences.length} notes on these trees`), ...sentences)] : sentences;
    this.aboutPart = element("p", { class: "quiet", id: "about" }, this.about());
    const about = count > 0 ? [this.aboutPart] : [];
    const trees =
      count > 0
        ? [
            section("colors", "Colors", {}, this.colorChoice(), this.legendPart),
            this.detailsSection,
            this.list.node,
          ]
        : [];
    this.panelPart = element("div", { class: "panel", id: "panel" }, element("h1", {}, data.title), ...about, ...notes, this.controls(), ...trees);
    return this.panelPart;
  }

  /** The number of shown trees. */
  about() {
    const { data, shownPlot } = this;
    const all = treeCount(data);
    if (shownPlot === null && !isNarrow(this.filtered)) return `${counted(all, "tree")}, ${counted(data.plots.length, "plot")}, ${data.species.length} species`;
    const passes = this.passes();
    const shown = Array.from({ length: all }, (_, tree) => tree).filter(passes);
    const species = new Set(shown.map((tree) => data.trees.species[tree])).size;
    const where = shownPlot === null ? "Shown" : `Plot ${data.plots[shownPlot].name}`;
    return `${where}: ${shown.length} of ${counted(all, "tree")}, ${species} species`;
  }

  controls() {
    const { node, filters, ...parts } = controls(this.data, this.shownPlot, this);
    Object.assign(this, parts);
    if (filters) showFilter(filters, this.filtered);
    return node;
  }

  setDetail(detail) {
    this.view.detail = detail;
    this.view.invalidate();
  }

  colorChoice() {
    this.groups = colorings(this.data);
    const node = choice("color", "Color by", this.groups, (value) => this.setColoring(value));
    this.colorSelect = node.querySelector("select");
    return node;
  }

  togglePanel(node) {
    const isWide = this.main.classList.toggle("is-wide");
    node.textContent = isWide ? "Show controls" : "Hide controls";
    node.setAttribute("aria-expanded", String(!isWide));
    this.view.resize();
  }

  // ---- Shown data -----------------------------------------------------------------------------

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
      // The button is in the upper right corner.
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

  /** The sizes of the first side, the trees that are shown, and their colors. */
  shown() {
    const variant = this.variants[0];
    const { coloring } = this;
    return { variant, passes: this.passes(), colorOf: coloring && ((tree) => coloring.of(tree, variant)) };
  }

  passes() {
    return passesOf(this.data, this.filtered);
  }

  filter() {
    for (const { stand } of this.view.sides) stand.show(this.passes());
    this.view.shadowsChanged();
  }

  setPlot(plot) {
    this.setFilter({ plot: plot === "" ? null : Number(plot) });
    if (this.view) this.showPlot();
  }

  /** @param {Partial<import("./filters.js").Filter>} change */
  setFilter(change) {
    Object.assign(this.filtered, change);
    if (this.view) this.filter();
    this.list.show(this.passes());
    this.aboutPart.textContent = this.about();
    if (this.chosen !== null && !this.passes()(this.chosen)) this.choose(null);
    if (this.view) this.setColoring(this.colorSelect.value);
  }

  /** The view of the link with which the page was opened. */
  restore() {
    const { camera, target, isWalking, color } = this.linked;
    if (color !== null && treeCount(this.data) > 0) {
      this.colorSelect.value = color;
      // A link of another page may name a coloring that this one lacks.
      if (this.colorSelect.selectedIndex < 0) this.colorSelect.selectedIndex = 0;
      this.setColoring(this.colorSelect.value);
    }
    if (!camera || !target) return;
    if (isWalking) this.setMode("walk");
    this.moves.lookFrom(camera, target);
  }

  /** Puts the state into the address, and the address on the clipboard where the browser allows it. */
  async link() {
    const { camera } = this.view;
    const color = this.colorSelect?.value ?? "";
    const target = this.moves.target().toArray();
    location.hash = fragmentOf({ camera: camera.position.toArray(), target, isWalking: this.moves.mode === "walk", color, filter: this.filtered });
    await navigator.clipboard?.writeText(location.href).catch(() => {});
    this.linkNote.textContent = "The address of this page now shows this view.";
  }

  /** The view of the current plot. */
  showPlot() {
    this.setColoring(this.colorSelect.value);
    if (this.ground) this.ground.box = this.extent();
    this.ground?.outlinePlot(this.shownPlot);
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
    const sentences = this.marks.draw(this.chosen, () => this.moves.orbit.target);
    this.overlapNote.replaceChildren(...sentences.map((text) => element("span", { class: "line" }, text)));
  }

  // ---- Actions --------------------------------------------------------------------------------

  /** Moves the camera so that everything is visible. */
  frame() {
    this.setMode("orbit");
    this.moves.frame(this.extent(), this.ground?.markCorners() ?? []);
  }

  setMode(mode) {
    this.moves.setMode(mode);
    this.view.setWalking(mode === "walk");
    this.ground?.setGrain(mode === "walk");
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

  /** Only the panel is scrolled to the selected tree. */
  showDetails() {
    const below = this.detailsSection.getBoundingClientRect().top - this.panelPart.getBoundingClientRect().top;
    this.panelPart.scrollTop += below - this.panelPart.clientTop;
  }

  async save() {
    const shown = {
      names: this.variants.map((variant) => variant?.title ?? ""),
      coloring: this.coloring,
      colors: { paper: cssColor("--paper"), text: cssColor("--text"), mark: cssColor("--mark") },
    };
    const blob = await savedPicture(this.view, shown, Number(this.main.querySelector("#picture-size").value));
    save("silvafit-view.png", blob);
  }

  /** Colors of the theme. */
  dress() {
    this.view.setBackground(cssColor("--sky"));
    this.ground?.paint({ ground: cssColor("--ground"), mark: cssColor("--mark") });
    if (this.ground) this.scaleNote.textContent = `The scale bar on the ground is ${this.ground.length} m long; the arrow beside it points north.`;
    this.drawMarks();
    this.view.invalidate();
  }

  tell({ calls, triangles, milliseconds, trees }) {
    if (this.figures.hidden) return;
    this.figures.textContent = `${counted(trees, "tree")} in view, ${calls} draw calls, ${triangles.toLocaleString("en")} triangles, ${milliseconds.toFixed(1)} ms`;
  }

  /** Browsers may withdraw the graphics context, and may restore it. */
  watchContext() {
    const lost = element("p", { class: "trouble", role: "alert" }, "The browser has withdrawn the graphics context of this page. It may restore it in a moment; if not, reload the page. The list of trees still works.");
    this.canvas.addEventListener("webglcontextlost", () => this.picture.append(lost));
    this.canvas.addEventListener("webglcontextrestored", () => {
      lost.remove();
      this.view.restore();
    });
  }

  listen() {
    this.watchContext();
    new ResizeObserver(() => {
      this.view.resize();
      this.layNames();
    }).observe(this.picture);
    listenToClicks(this.canvas, (clientX, clientY) => this.pickAt(clientX, clientY));
    listenToKeys(this.canvas, this);
  }

  pickAt(clientX, clientY) {
    if (treeCount(this.data) === 0) return;
    const { left, top } = this.canvas.getBoundingClientRect();
    const { side, origin, direction } = this.view.rayAt(clientX - left, clientY - top);
    this.choose(pick(side, this.data.trees.dbh, origin, direction));
  }
}

const hasWebGl = () => document.createElement("canvas").getContext("webgl2") !== null;

startTheme();
const page = new Page(readData());
/** For other scripts and tests: the page, and a function that draws immediately and returns what was drawn. */
window.silvafitView = {
  page,
  ready: page.start().catch((error) => {
    page.sayTrouble(`The 3D view cannot be drawn: ${error.message}`);
    page.view = null;
  }),
  draw() {
    page.view.draw();
    return page.view.stats;
  },
};
