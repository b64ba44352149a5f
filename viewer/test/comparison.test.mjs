// SPDX-License-Identifier: MIT
// The page that sets model libraries side by side.
import assert from "node:assert/strict";
import { test } from "node:test";
import { paintedPixels } from "./browser.mjs";
import { inBrowser } from "./in-browser.mjs";
import { comparison } from "./template.mjs";

const { skip, withPage } = inBrowser();

/* Tables below <details> are written when these open, an event after the click: so the first row is waited for. */
async function cellsOf(page, section, caption) {
  const rows = page.locator(`${section} table`, { has: page.locator("caption", { hasText: caption }) }).locator("tbody tr");
  await rows.first().waitFor({ state: "attached" });
  return rows.evaluateAll((all) => all.map((row) => [...row.cells].map((cell) => cell.textContent)));
}

test("differences are those of the data, and a model of one library only is said to be", { skip }, () =>
  withPage(comparison(), {}, async (page) => {
    const [{ differences: [difference] }] = comparison().pairs;
    const rows = await cellsOf(page, "#overview", "Differences");
    assert.deepEqual(rows[0].slice(0, 3), ["SM height, NLME", `+${difference.aic.toFixed(2)}`, `+${difference.bic.toFixed(2)}`]);
    assert.equal(rows.at(-1).at(-1), "only in base.json");
    const statistics = await cellsOf(page, "#pair-1", "Accuracy and criteria");
    const [r2] = statistics;
    const { fits } = comparison().pairs[0];
    assert.deepEqual(r2.slice(0, 3), ["R²", fits[0].statistics.conditional.r2.toFixed(4), fits[1].statistics.population.r2.toFixed(4)]);
  }),
);

test("curves are drawn for both, and missing ones are said to be", { skip }, () =>
  withPage(comparison(), {}, async (page) => {
    const painted = await paintedPixels(page);
    assert.equal(painted.length, 2);
    painted.forEach((pixels) => assert.ok(pixels > 2500, `${pixels} painted pixels`));
    assert.match(await page.locator("#pair-3").textContent(), /No curves/);
    await page.locator("#pair-1 details > summary").click();
    const [row] = await cellsOf(page, "#pair-1", "Curves of height");
    const { dbh, values: [first, second] } = comparison().pairs[0].curves;
    assert.deepEqual(row.slice(0, 3), [dbh[0].toFixed(1), first[0].toFixed(2), second[0].toFixed(2)]);
  }),
);

test("nested effects name both groupings, and what has no unit has no comma", { skip }, () => {
  const data = comparison();
  const [pair] = data.pairs;
  Object.assign(pair, { species: "", role: "", unit: "" });
  const [term] = pair.fits[0].random;
  pair.fits[0].random = [{ ...term, group: "stand", effects: ["a", "b"] }, { ...term, group: "plot", effects: ["a"] }];
  return withPage(data, {}, async (page) => {
    const codes = await page.locator("#pair-1 dl.formulas code").allTextContents();
    assert.deepEqual(codes.filter((code) => code.startsWith("random")), ["random: a + b | stand", "random: a | plot within stand"]);
    const names = (await cellsOf(page, "#pair-1", "Accuracy and criteria")).map(([name]) => name);
    assert.deepEqual(names.slice(0, 4), ["R²", "Mean error", "RMSE", "MAE"]);
    assert.equal(await page.locator("#pair-1-title").textContent(), "Height");
  });
});

test("criteria that cannot be compared are missing, with the reason", { skip }, () => {
  const data = comparison();
  Object.assign(data.pairs[0].differences[0], { aic: null, bic: null, log_likelihood: null, reason: "fitted to different files" });
  return withPage(data, {}, async (page) => {
    assert.match(await page.locator("#pair-1").textContent(), /cannot be compared: fitted to different files/);
    assert.equal((await cellsOf(page, "#overview", "Differences"))[0][1], "\u2013");
  });
});

test("names of libraries and species never become markup, and nothing scrolls sideways at 400 %", { skip }, () => {
  const data = comparison();
  const name = '<img src=x onerror=alert(1)>"\'.json';
  data.libraries[0].name = name;
  data.title = name;
  data.pairs[0].species = "<script>alert(1)</script>";
  return withPage(data, { viewport: { width: 320, height: 640 } }, async (page) => {
    assert.equal(await page.locator("img").count(), 0);
    assert.equal(await page.locator("h1").textContent(), name);
    await paintedPixels(page);
    assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 320);
  });
});
