// SPDX-License-Identifier: MIT
// Fills the built template as write_report_page of libstudy does, for tests without the program.
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import Ajv2020 from "ajv/dist/2020.js";

const here = (name) => fileURLToPath(new URL(name, import.meta.url));

/** The built page; SILVAFIT_REPORT_TEMPLATE overrides it. */
export const templatePath = process.env.SILVAFIT_REPORT_TEMPLATE ?? here("../dist/report.html");

/** The built 3D page; SILVAFIT_SCENE_TEMPLATE overrides it. */
export const scenePath = process.env.SILVAFIT_SCENE_TEMPLATE ?? here("../dist-scene/scene.html");

export const readJson = (path) => JSON.parse(readFileSync(path, "utf8"));
export const example = () => readJson(here("example.json"));
/** Fourteen trees of examples/fir-mixed and its study: what `silvafit view scene-trees.csv --models 1 --lod 2,3` puts into the page. */
export const sceneExample = () => readJson(here("scene-example.json"));

/** Two libraries of the example's models: in the second, the mixed models are those of the base equations of least squares. */
export function comparison() {
  const { silvafit, repeat, inventory, results } = example();
  const library = (name, models) => ({ name, file: inventory.file, fingerprint: repeat.fingerprint, trees: inventory.trees, models });
  const pairs = results.map(({ species, response, unit, fits, curves }) => ({
    species,
    response,
    role: "nlme",
    unit,
    fits: [fits.nlme, fits.ols],
    differences: [difference(fits.nlme, fits.ols)],
    curves: { held_at: curves.held_at, own_heights: response === "hcb", dbh: curves.dbh, values: [curves.population, curves.ols] },
  }));
  const [first] = results;
  const alone = { ...pairs[0], response: "cw", fits: [null, first.fits.ols], differences: [null], curves: null };
  return {
    schema: "silvafit-comparison/1",
    silvafit,
    title: "Comparison of mixed.json and base.json",
    versions: repeat.versions,
    libraries: [library("mixed.json", 2), library("base.json", 3)],
    pairs: [...pairs, alone],
  };
}

function difference(first, other) {
  const accuracy = (fit) => fit.statistics.conditional ?? fit.statistics.population;
  const change = (name) => other[name] - first[name];
  return {
    log_likelihood: change("log_likelihood"),
    aic: change("aic"),
    bic: change("bic"),
    rmse: accuracy(other).rmse - accuracy(first).rmse,
    r2: accuracy(other).r2 - accuracy(first).r2,
    reason: null,
  };
}

const SCHEMAS = ["../report-data.schema.json", "../comparison-data.schema.json", "../scene-data.schema.json"].map((path) => readJson(here(path)));

/** Where the data break the contract that they name, in words. */
export function schemaErrors(data) {
  const ajv = new Ajv2020({ allErrors: true, allowUnionTypes: true, strictRequired: false, schemas: SCHEMAS });
  const validate = ajv.getSchema(data.schema);
  if (!validate) return [`there is no schema ${data.schema}`];
  return validate(data) ? [] : validate.errors.map(({ instancePath, message }) => `${instancePath} ${message}`);
}

const UNSAFE = /[<>&\u2028\u2029]/g;
const escapeJson = (text) => text.replace(UNSAFE, (sign) => `\\u${sign.charCodeAt(0).toString(16).padStart(4, "0")}`);
const escapeHtml = (text) => text.replace(/[&<>"]/g, (sign) => `&#${sign.charCodeAt(0)};`);

const folders = [];
process.on("exit", () => folders.forEach((folder) => rmSync(folder, { recursive: true, force: true })));

/** Writes a page with the data to a temporary file, which is deleted when the process ends, and returns its path. */
export function writePage(data) {
  const html = readFileSync(data.schema === "silvafit-view/1" ? scenePath : templatePath, "utf8")
    .replace("{{=<% %>=}}", "")
    .replace("<% title %>", () => escapeHtml(data.title))
    .replace("<%& data %>", () => escapeJson(JSON.stringify(data)));
  const folder = mkdtempSync(join(tmpdir(), "silvafit-report-"));
  folders.push(folder);
  const file = join(folder, "report.html");
  writeFileSync(file, html);
  return file;
}
