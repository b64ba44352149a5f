// SPDX-License-Identifier: MIT
// The dialog with the cross-section: its strip, the drawing with its scale, and the distance of two points.
import { save } from "../csv.js";
import { element, svg } from "../dom.js";
import { decimals, roundUp } from "../format.js";
import { treeName } from "./data.js";
import { button, choice, numberField } from "./panel.js";
import { distanceOf, profileOf, usualStrip } from "./profile.js";

const cssOf = (linear) => `rgb(${linear.map((value) => Math.round(255 * Math.min(1, value) ** (1 / 2.2))).join(" ")})`;

export class ProfileDialog {
  /** @param {() => {variant: object, passes: (tree: number) => boolean, colorOf: ((tree: number) => string) | null}} shown  what the page shows */
  constructor(data, shown) {
    this.data = data;
    this.shown = shown;
    this.points = [];
    this.measured = element("p", { class: "quiet", role: "status", id: "profile-distance" });
    this.picture = element("div", { class: "profile-picture" });
    this.count = element("p", { class: "quiet", id: "profile-count" });
    this.middle = numberField("profile-middle", "Middle of the strip, coordinate [m]", (middle) => middle !== null && this.change({ middle }));
    this.width = numberField("profile-width", "Width of the strip [m]", (width) => width !== null && this.change({ width }), "0");
    const directions = [{ value: "east", text: "west to east" }, { value: "north", text: "south to north" }];
    this.node = element(
      "dialog",
      { id: "profile", "aria-labelledby": "profile-title" },
      element("h2", { id: "profile-title" }, "Cross-section"),
      element("div", { class: "profile-controls" }, choice("profile-direction", "Direction", [{ label: null, choices: directions }], (direction) => this.turn(direction)), this.middle, this.width),
      this.picture,
      this.count,
      this.measured,
      element("p", { class: "buttons" }, button("profile-save", "Save drawing", () => this.save()), button("profile-close", "Close", () => this.node.close())),
    );
  }

  open() {
    if (!this.strip) this.strip = usualStrip(this.data, "east", this.shown().passes);
    this.draw();
    this.node.showModal();
  }

  turn(direction) {
    this.change(usualStrip(this.data, direction, this.shown().passes));
  }

  change(strip) {
    // A field tells of its value again when it loses the focus; the measured points stay.
    if (Object.entries(strip).every(([name, value]) => this.strip[name] === value)) return;
    this.strip = { ...this.strip, ...strip };
    this.draw();
  }

  draw() {
    const { variant, passes, colorOf } = this.shown();
    this.middle.querySelector("input").value = this.strip.middle;
    this.width.querySelector("input").value = this.strip.width;
    const trees = profileOf(this.data, variant, this.strip, passes);
    this.points = [];
    this.count.textContent = `${trees.length} trees. Height and distance have the same scale.`;
    this.measured.textContent = "Click two points of the drawing to measure their distance.";
    this.picture.replaceChildren(...(trees.length > 0 ? [this.drawing(trees, colorOf)] : []));
  }

  drawing(trees, colorOf) {
    const places = trees.flatMap(({ at, outline }) => outline.map(([x]) => at + x));
    const [left, right] = [Math.min(...places), Math.max(...places)];
    const top = Math.max(...trees.map(({ stem }) => stem.height));
    // For the labels of the scale, in meters of the drawing.
    const margin = Math.max(top, (right - left) / 3) / 10;
    this.frame = { left, right, top, margin };
    const view = [left - 2 * margin, -top - margin, right - left + 3 * margin, top + 3 * margin];
    const drawing = svg("svg", { viewBox: view.join(" "), role: "img", "aria-label": `Cross-section of ${trees.length} trees`, class: "profile-drawing" });
    drawing.append(this.scale(), ...trees.map((tree) => this.tree(tree, colorOf)));
    this.marks = svg("g", { class: "profile-marks" });
    drawing.append(this.marks);
    drawing.addEventListener("click", ({ clientX, clientY }) => this.mark(new DOMPoint(clientX, clientY).matrixTransform(drawing.getScreenCTM().inverse())));
    this.svg = drawing;
    return drawing;
  }

  /** Lines and numbers of heights, and of the coordinate along the strip. */
  scale() {
    const { left, right, top, margin } = this.frame;
    const lines = [];
    const add = (x1, y1, x2, y2) => lines.push(svg("line", { x1, y1, x2, y2, class: "profile-line" }));
    const label = (x, y, text, anchor) => lines.push(svg("text", { x, y, "text-anchor": anchor, "font-size": 0.5 * margin, class: "profile-label" }, text));
    const up = roundUp(top / 8);
    for (let height = 0; height <= top; height += up) {
      add(left - 0.3 * margin, -height, right, -height);
      label(left - 0.4 * margin, -height + 0.2 * margin, `${decimals(height, up < 1 ? 1 : 0)} m`, "end");
    }
    const along = roundUp((right - left) / 12);
    for (let at = Math.ceil(left / along) * along; at <= right; at += along) {
      add(at, 0, at, 0.3 * margin);
      label(at, 0.9 * margin, decimals(at, along < 1 ? 1 : 0), "middle");
    }
    label((left + right) / 2, 1.6 * margin, this.strip.direction === "east" ? "east [m]" : "north [m]", "middle");
    return svg("g", {}, ...lines);
  }

  tree({ tree, at, outline, stem }, colorOf) {
    const preset = this.data.presets[this.data.trees.preset[tree]];
    const fill = colorOf ? colorOf(tree) : cssOf(preset.leaf);
    const crown = outline.map(([x, y]) => `${(at + x).toFixed(3)},${(-y).toFixed(3)}`).join(" ");
    const pole = `${at - stem.radius},0 ${at + stem.radius},0 ${at},${-stem.height}`;
    return svg(
      "g",
      { class: "profile-tree" },
      svg("title", {}, treeName(this.data, tree)),
      svg("polygon", { points: pole, fill: cssOf(preset.bark) }),
      svg("polygon", { points: crown, fill, "fill-opacity": 0.55, stroke: "currentColor", "stroke-width": 0.05 }),
    );
  }

  mark({ x, y }) {
    if (this.points.length === 2) this.points = [];
    this.points.push([x, -y]);
    const dots = this.points.map(([px, py]) => svg("circle", { cx: px, cy: -py, r: 0.15 * this.frame.margin, class: "profile-dot" }));
    const [first, second] = this.points;
    const line = second ? [svg("line", { x1: first[0], y1: -first[1], x2: second[0], y2: -second[1], class: "profile-measure" })] : [];
    this.marks.replaceChildren(...line, ...dots);
    if (!second) return;
    const { horizontal, vertical, straight } = distanceOf(first, second);
    this.measured.textContent = `Distance ${decimals(straight, 2)} m: ${decimals(horizontal, 2)} m horizontally, ${decimals(vertical, 2)} m vertically.`;
  }

  /** The drawing with its colors, as an SVG file. */
  save() {
    if (!this.svg?.isConnected) return;
    const copy = this.svg.cloneNode(true);
    copy.setAttribute("xmlns", copy.namespaceURI);
    copy.prepend(svg("style", {}, ".profile-line{stroke:#999;stroke-width:.05}.profile-measure{stroke:#c00;stroke-width:.1}.profile-dot{fill:#c00}text{font-family:sans-serif}"));
    save("silvafit-cross-section.svg", new Blob([copy.outerHTML], { type: "image/svg+xml" }));
  }
}
