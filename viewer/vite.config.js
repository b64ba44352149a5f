// SPDX-License-Identifier: MIT
// Builds report.html: one file, nothing to fetch, with the tags that the program fills.
import { fileURLToPath } from "node:url";
import { fillWithExample, singleFile } from "./build/single-file.js";

const here = (name) => fileURLToPath(new URL(name, import.meta.url));

export default {
  root: here("."),
  // Vega-Lite takes a few helpers from `vega`, which hands them on from here; all of it would double the page.
  resolve: { alias: [{ find: /^vega$/, replacement: "vega-util" }] },
  plugins: [fillWithExample(here("test/example.json")), singleFile("report.html")],
  build: {
    target: "es2020",
    modulePreload: false,
    assetsInlineLimit: Number.MAX_SAFE_INTEGER,
    cssCodeSplit: false,
    chunkSizeWarningLimit: 2000,
    reportCompressedSize: false,
  },
};
