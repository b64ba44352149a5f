// SPDX-License-Identifier: MIT
// The list of trees: search, sorting, paging.
import { element } from "../dom.js";
import { decimals } from "../format.js";
import { comparison } from "../sort.js";
import { counted, speciesOf, treeCount, treeName } from "./data.js";

const PAGE = 50;

function columnsOf(data) {
  const { trees } = data;
  const sized = (title, values, digits) => ({ title, value: (tree) => values[tree], text: (tree) => (values[tree] === null ? "–" : decimals(values[tree], digits)), isNumber: true });
  const text = (title, value) => ({ title, value, text: value, isNumber: false });
  return [
    text("Plot", (tree) => data.plots[trees.plot[tree]].name),
    text("Tree", (tree) => trees.tree[tree]),
    text("Species", (tree) => speciesOf(data, tree)),
    sized("DBH cm", trees.dbh, 1),
    sized("h m", trees.h, 1),
    sized("hcb m", trees.hcb, 1),
    sized("cw m", trees.cw, 2),
  ];
}

export class TreeList {
  /** @param {(tree: number) => void} choose */
  constructor(data, choose) {
    this.data = data;
    this.choose = choose;
    this.columns = columnsOf(data);
    this.passes = () => true;
    this.sorted = { column: 0, rising: true };
    this.page = 0;
    this.chosen = null;
    this.search = element("input", { type: "search", id: "search", autocomplete: "off" });
    this.search.addEventListener("input", () => this.refresh());
    this.count = element("p", { class: "quiet", role: "status" });
    this.table = element("table");
    this.before = this.button("Previous", -1);
    this.after = this.button("Next", 1);
    this.node = element(
      "section",
      { "aria-labelledby": "list-title" },
      element("h2", { id: "list-title" }, "Trees"),
      element("p", {}, element("label", { for: "search" }, "Search plot, tree, species "), this.search),
      this.count,
      element("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": "List of trees" }, this.table),
      element("p", { class: "buttons" }, this.before, this.after),
    );
    this.refresh();
  }

  button(text, by) {
    const button = element("button", { type: "button" }, text);
    button.addEventListener("click", () => {
      this.page += by;
      this.draw();
      // A disabled button cannot keep the focus.
      if (button.disabled) (button === this.after ? this.before : this.after).focus();
    });
    return button;
  }

  /** Lists the trees that pass the test. */
  show(passes) {
    this.passes = passes;
    this.refresh();
  }

  refresh() {
    const wanted = this.search.value.trim().toLowerCase();
    const { column, rising } = this.sorted;
    const { value, isNumber } = this.columns[column];
    const all = Array.from({ length: treeCount(this.data) }, (_, tree) => tree);
    const order = comparison(all.map(value), !isNumber);
    this.trees = all
      .filter((tree) => this.passes(tree) && (wanted === "" || `${treeName(this.data, tree)} ${speciesOf(this.data, tree)}`.toLowerCase().includes(wanted)))
      .sort((a, b) => order(a, b, rising ? 1 : -1) || a - b);
    this.page = 0;
    this.draw();
  }

  /** Marks a tree and shows its page. */
  mark(tree) {
    this.chosen = tree;
    const place = this.trees.indexOf(tree);
    if (place >= 0) this.page = Math.floor(place / PAGE);
    this.draw();
  }

  /** Redraws the table; a tree's button keeps the focus. */
  draw() {
    const focused = this.table.contains(document.activeElement) ? document.activeElement.dataset.tree : undefined;
    this.lay();
    if (focused !== undefined) this.table.querySelector(`[data-tree="${focused}"]`)?.focus({ preventScroll: true });
  }

  lay() {
    const pages = Math.max(1, Math.ceil(this.trees.length / PAGE));
    this.page = Math.min(pages - 1, Math.max(0, this.page));
    const from = this.page * PAGE;
    const rows = this.trees.slice(from, from + PAGE);
    this.count.textContent = this.trees.length === 0 ? "No tree." : `${from + 1} to ${from + rows.length} of ${counted(this.trees.length, "tree")}`;
    this.before.disabled = this.page === 0;
    this.after.disabled = this.page >= pages - 1;
    this.table.replaceChildren(element("caption", { class: "hidden" }, "Trees; press a tree's number to select it"), this.head(), element("tbody", {}, ...rows.map((tree) => this.row(tree))));
  }

  head() {
    const cells = this.columns.map(({ title, isNumber }, column) => {
      const isOwn = this.sorted.column === column;
      const button = element("button", { type: "button", class: "sort" }, title, isOwn ? (this.sorted.rising ? " ↑" : " ↓") : "");
      button.addEventListener("click", () => {
        this.sorted = { column, rising: isOwn ? !this.sorted.rising : true };
        this.refresh();
        this.table.querySelectorAll("button.sort")[column].focus();
      });
      return element("th", { scope: "col", class: isNumber ? "number" : null, "aria-sort": isOwn ? (this.sorted.rising ? "ascending" : "descending") : null }, button);
    });
    return element("thead", {}, element("tr", {}, ...cells));
  }

  row(tree) {
    const cells = this.columns.map(({ title, text, isNumber }) => {
      if (title !== "Tree") return element("td", { class: isNumber ? "number" : null }, text(tree));
      const button = element("button", { type: "button", class: "link", "data-tree": tree, "aria-label": `Choose ${treeName(this.data, tree)}` }, text(tree));
      button.addEventListener("click", () => this.choose(tree));
      return element("td", {}, button);
    });
    return element("tr", { class: tree === this.chosen ? "is-chosen" : null, "aria-current": tree === this.chosen ? "true" : null }, ...cells);
  }
}
