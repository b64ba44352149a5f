// SPDX-License-Identifier: MIT
// Builds report.html, and with `--mode scene` scene.html, the page of `silvafit view`: one file each, nothing to fetch, with the tags that the program fills.
import { fileURLToPath } from "node:url";
import { fillWithExample, singleFile } from "./build/single-file.js";

const here = (name) => fileURLToPath(new URL(name, import.meta.url));

const REPORT = { page: "index.html", example: "test/example.json", file: "report.html", target: "es2020", outDir: "dist" };
const SCENE = { page: "scene.html", example: "test/scene-example.json", file: "scene.html", target: "es2022", outDir: "dist-scene" };

export default ({ mode }) => {
  const { page, example, file, target, outDir } = mode === "scene" ? SCENE : REPORT;
  return {
    root: here("."),
    // Vega-Lite takes a few helpers from `vega`, which hands them on from here; all of it would double the page.
    resolve: { alias: [{ find: /^vega$/, replacement: "vega-util" }] },
    plugins: [fillWithExample(here(example)), singleFile(file)],
    build: {
      target,
      outDir,
      rollupOptions: { input: here(page) },
      modulePreload: false,
      assetsInlineLimit: Number.MAX_SAFE_INTEGER,
      cssCodeSplit: false,
      chunkSizeWarningLimit: 2000,
      reportCompressedSize: false,
    },
  };
};
