// SPDX-License-Identifier: MIT
// How to get the same study again: command, input, versions.
import { element } from "./dom.js";

/** @param {import("./types.js").Report} report */
export function repeat({ command, inventory, repeat: { fingerprint, versions } }) {
  const entry = (name, ...value) => [element("dt", {}, name), element("dd", {}, ...value)];
  return element(
    "section",
    { id: "repeat", "aria-labelledby": "repeat-title" },
    element("h2", { id: "repeat-title" }, "To repeat this study"),
    element("p", {}, "The same file, command and versions give the same bytes, whatever the number of threads."),
    element("pre", { tabindex: "0", "aria-label": "Command" }, element("code", {}, command)),
    element(
      "dl",
      {},
      ...(fingerprint === ""
        ? entry("Inventory", "a table in memory")
        : entry("Inventory", inventory.file, ", fingerprint ", element("code", {}, fingerprint))),
      ...versions.flatMap(({ name, version }) => entry(name, version)),
      ...entry("To predict with its models", element("code", {}, "silvafit predict library.json trees.csv")),
    ),
  );
}
