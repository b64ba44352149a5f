// SPDX-License-Identifier: MIT
// Reproducing the study: command, input, versions.
import { element, section } from "./dom.js";

/** @param {Report} report */
export function repeat({ command, inventory, repeat: { fingerprint, versions } }) {
  const entry = (name, ...value) => [element("dt", {}, name), element("dd", {}, ...value)];
  return section(
    "repeat",
    "Reproducing this study",
    {},
    element("p", {}, "The same file, command and versions give the same bytes, for any number of threads."),
    element("pre", { tabindex: "0", "aria-label": "Command" }, element("code", {}, command)),
    element(
      "dl",
      {},
      ...(fingerprint === ""
        ? entry("Inventory", "a table in memory")
        : entry("Inventory", inventory.file, ", fingerprint ", element("code", {}, fingerprint))),
      ...versions.flatMap(({ name, version }) => entry(name, version)),
      ...entry("Predictions with its models", element("code", {}, "silvafit predict library.json trees.csv")),
    ),
  );
}
