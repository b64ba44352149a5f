// SPDX-License-Identifier: MIT
// Builds scene.html, the page of `silvafit view`: one file, nothing to fetch, with the tags that the program fills.
import { fileURLToPath } from "node:url";
import { fillWithExample, singleFile } from "./build/single-file.js";

const here = (name) => fileURLToPath(new URL(name, import.meta.url));

export default {
  root: here("."),
  plugins: [fillWithExample(here("test/scene-example.json")), singleFile("scene.html")],
  build: {
    target: "es2022",
    outDir: "dist-scene",
    rollupOptions: { input: here("scene.html") },
    modulePreload: false,
    assetsInlineLimit: Number.MAX_SAFE_INTEGER,
    cssCodeSplit: false,
    chunkSizeWarningLimit: 2000,
    reportCompressedSize: false,
  },
};
