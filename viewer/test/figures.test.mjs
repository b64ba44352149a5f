// SPDX-License-Identifier: MIT
// What the figures show, in the browser: classes of covariates, box plots, quantiles, random effects, themes, paper.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { paintedPixels, savedText } from "./browser.mjs";
import { inBrowser } from "./in-browser.mjs";
import { example } from "./template.mjs";

const { skip, withPage } = inBrowser();

const figureOf = (page, result, title) => page.locator(`${result} figure`, { has: page.locator("h3", { hasText: title }) });
const open = (figure) => figure.locator("details:not([open]) > summary").click();
const tableRows = async (figure, caption) => {
  const rows = figure.locator("table", { has: figure.page().locator("caption", { hasText: caption }) }).locator("tbody tr");
  // A table is filled when its part opens; reading all rows does not wait for that.
  await rows.first().waitFor();
  return rows.evaluateAll((all) => all.map((row) => [...row.cells].map((cell) => cell.textContent)));
};

test("each covariate of the chosen model has a panel with a curve for each class, in the data's numbers", { skip }, () =>
  withPage(example(), {}, async (page) => {
    const figure = figureOf(page, "#result-2", "Curves by classes of crowding and dominance");
    assert.deepEqual(await figure.locator("h4").allTextContents(), ["Crowding C", "Dominance U"]);
    await open(figure);
    const rows = await tableRows(figure, "classes of crowding");
    const { dbh, by_class: [crowding] } = example().results[1].curves;
    assert.equal(rows.at(-1)[0], dbh.at(-1).toFixed(1));
    assert.deepEqual(rows[0].slice(1, 6), crowding.population.map((values) => values[0].toFixed(2)));
    assert.deepEqual(rows[0].slice(6, 11), crowding.covariates.map((values) => values[0].toFixed(2)));
  }),
);

test("a class with few trees is said to be an extrapolation", { skip }, () => {
  const data = example();
  data.results[0].curves.by_class[0].trees = [0, 3, 60, 80, 90];
  data.results[1].curves.by_class.forEach((one) => (one.trees = [9, 9, 9, 9, 9]));
  return withPage(data, {}, async (page) => {
    assert.match(await figureOf(page, "#result-1", "Curves by classes").textContent(), /fewer than 5 trees/);
    assert.doesNotMatch(await figureOf(page, "#result-2", "Curves by classes").textContent(), /fewer than 5 trees/);
  });
});

test("the variogram of residuals has a row for each class, and is left out without positions", { skip }, () => {
  const data = example();
  data.results[0].variogram = [
    { distance: 2.5, semivariance: 0.6, pairs: 40 },
    { distance: 7.25, semivariance: 1.1, pairs: 1200 },
  ];
  return withPage(data, {}, async (page) => {
    const figure = figureOf(page, "#result-1", "Variogram");
    await open(figure);
    assert.deepEqual(await tableRows(figure, "Variogram"), [
      ["2.50", "0.600", "40"],
      ["7.25", "1.100", "1\u202f200"],
    ]);
    assert.equal(await figureOf(page, "#result-2", "Variogram").count(), 0);
  });
});

test("box plots count every tree once in each panel, and their quartiles and means are those of the residuals", { skip }, () => {
  const data = example();
  const { observations } = data.results[0];
  // Twenty trees that OLS predicts in one class of 2 m, with standardized residuals 1 to 19 and 40: quartiles 5.75, 10.5 and 15.25 (R's type 7), mean 11.5.
  const rows = Array.from({ length: 20 }, (_, index) => (index < 19 ? index + 1 : 40));
  Object.keys(observations).filter((name) => Array.isArray(observations[name])).forEach((name) => (observations[name] = observations[name].slice(0, 20)));
  observations.covariates.C.length = 20;
  observations.ols = rows.map(() => 10.5);
  observations.residual_ols = rows;
  return withPage(data, {}, async (page) => {
    const figure = figureOf(page, "#result-1", "Standardized residuals by class of height");
    await open(figure);
    const [row] = await tableRows(figure, "Standardized residuals of OLS by predicted");
    assert.deepEqual(row, ["10 to 12", "20", "1.000", "5.750", "10.500", "11.500", "15.250", "19.000", "1"]);
    const observed = await tableRows(figure, "Standardized residuals of OLS by observed");
    assert.equal(observed.reduce((sum, cells) => sum + Number(cells[1]), 0), 20);
  });
});

test("figures are saved as SVG and PNG with their legend, light in every theme", { skip }, () =>
  withPage(example(), { colorScheme: "dark" }, async (page) => {
    const figure = figureOf(page, "#result-1", "Height against DBH");
    const svg = await savedText(page, figure.getByRole("button", { name: "Save as SVG" }));
    assert.match(svg, /^<svg xmlns="http:\/\/www.w3.org\/2000\/svg"/);
    for (const part of ["NLME, population", "95 % confidence band, OLS", "DBH (cm)", "Height (m)", "#ffffff", "#b8480c"]) assert.ok(svg.includes(part), part);
    const problem = await page.evaluate((text) => new DOMParser().parseFromString(text, "image/svg+xml").querySelector("parsererror")?.textContent ?? null, svg);
    assert.equal(problem, null);
    const [download] = await Promise.all([page.waitForEvent("download"), figure.getByRole("button", { name: "Save as PNG" }).click()]);
    assert.match(download.suggestedFilename(), /^figure-\d+-height-against-dbh\.png$/);
    const png = readFileSync(await download.path());
    assert.deepEqual([...png.subarray(1, 4)], [..."PNG"].map((sign) => sign.charCodeAt(0)));
    assert.ok(png.readUInt32BE(16) > 1000, "wide enough for print");
  }),
);

test("marks of charts tell what they are", { skip }, () =>
  withPage(example(), { viewport: { width: 1000, height: 800 } }, async (page) => {
    const chart = page.locator("#result-1 .chart").first();
    await chart.scrollIntoViewIfNeeded();
    await chart.locator("canvas").waitFor();
    const box = await chart.boundingBox();
    const tip = page.locator(".tip");
    for (let share = 0.2; share < 0.9 && !(await tip.isVisible().catch(() => false)); share += 0.01) {
      await page.mouse.move(box.x + box.width * share, box.y + box.height * 0.4);
    }
    assert.match(await tip.textContent(), /plot \d+, tree \d+|Plot \d+: .* m at DBH|population: .* m at DBH|OLS: .* m at DBH/);
  }),
);

test("random effects are sorted, and have intervals only where standard errors are known", { skip }, async () => {
  const data = example();
  await withPage(data, {}, async (page) => {
    assert.match(await figureOf(page, "#result-1", "Random effects by plot").textContent(), /Intervals need/);
  });
  const [random] = data.results[0].fits.nlme.random;
  random.eblup_se = Object.fromEntries(Object.entries(random.eblup).map(([plot, values]) => [plot, Object.fromEntries(Object.keys(values).map((effect) => [effect, 0.5]))]));
  await withPage(data, {}, async (page) => {
    const figure = figureOf(page, "#result-1", "Random effects by plot");
    assert.match(await figure.locator(".legend").textContent(), /95 % interval/);
    await open(figure);
    const titles = await figure.locator("thead th").allTextContents();
    assert.deepEqual(titles, ["plot", "a", "Standard error, a", "b", "Standard error, b", "b:C", "Standard error, b:C"]);
  });
});

test("periods within plots have a figure and a table of their own", { skip }, async () => {
  const data = example();
  const terms = data.results[0].fits.nlme.random;
  const periods = Object.keys(terms[0].eblup).flatMap((plot) => [[`${plot}/2010`, { a: 0.25 }], [`${plot}/2020`, { a: -0.5 }]]);
  terms.push({ group: "year", effects: ["a"], form: "general", covariance: [[0.49]], sd: [0.7], correlation: [[1]], eblup: Object.fromEntries(periods) });
  await withPage(data, {}, async (page) => {
    const figure = figureOf(page, "#result-1", "Random effects by year within plot");
    await open(figure);
    const rows = await tableRows(figure, "Random effects of each year");
    assert.equal(rows.length, periods.length);
    assert.equal(await figureOf(page, "#result-1", "Random effects by plot").count(), 1);
    await page.locator("#result-1 details:not([open]) > summary").evaluateAll((all) => all.forEach((summary) => summary.click()));
    const captions = await page.locator("#result-1 caption").allTextContents();
    for (const group of ["plot", "year within plot"]) assert.ok(captions.some((text) => text.includes(`Variance components, ${group}`)), group);
    assert.match(await page.locator("#summary").textContent(), /a, b, b:C \| plot; a \| year/);
  });
});

test("the theme can be chosen against the system, is kept, and paper stays light", { skip }, () =>
  withPage(example(), { colorScheme: "light" }, async (page) => {
    const paper = () => page.evaluate(() => getComputedStyle(document.documentElement).getPropertyValue("--paper"));
    await paintedPixels(page);
    const pixels = () => page.locator(".chart canvas").first().evaluate((canvas) => canvas.toDataURL());
    const light = await pixels();
    await page.getByLabel("Theme").selectOption("dark");
    assert.equal(await paper(), "#151a18");
    assert.notEqual(await pixels(), light);
    await page.reload();
    assert.equal(await paper(), "#151a18");
    assert.equal(await page.getByLabel("Theme").inputValue(), "dark");
    await page.evaluate(() => dispatchEvent(new Event("beforeprint")));
    assert.equal(await paper(), "#fdfdfb");
  }),
);

test("on paper no chart is wider than the page or cut by its end", { skip }, () =>
  withPage(example(), { viewport: { width: 1280, height: 900 } }, async (page) => {
    await page.evaluate(() => dispatchEvent(new Event("beforeprint")));
    await page.emulateMedia({ media: "print" });
    // A4 less margins of 1.5 cm, in CSS pixels.
    await page.setViewportSize({ width: 680, height: 1000 });
    const boxes = await page.locator(".chart svg, .chart canvas").evaluateAll((all) => all.map((one) => one.getBoundingClientRect()).map(({ right, height }) => ({ right, height })));
    boxes.forEach(({ right, height }) => assert.ok(right <= 680 && height > 100 && height < 1000, `${right}, ${height}`));
    assert.equal(await page.locator(".chart").evaluateAll((all) => all.filter((one) => getComputedStyle(one).breakInside !== "avoid").length), 0);
    assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= 680);
  }),
);

test("tables are saved with all digits, and names with commas and quotes stay whole", { skip }, () => {
  const data = example();
  data.results[0].species = 'S"M, <script>';
  return withPage(data, {}, async (page) => {
    const saved = async (button) => (await savedText(page, button)).split("\n");
    const lines = await saved(page.locator("#tables [data-file='estimates.csv']"));
    assert.equal(lines[0], "species,response,level,coefficient,estimate,se,df,t,p");
    const { estimate } = data.results[0].fits.ols.fixed.a;
    assert.ok(lines[1].startsWith(`"S""M, <script>",h,ols,a,${estimate},`), lines[1]);
    const summary = await saved(page.locator("#summary button", { hasText: "Save as CSV" }).last());
    assert.ok(summary[1].includes(String(data.results[0].fits.ols.statistics.population.r2)), summary[1]);
  });
});

test("the command, the fingerprint and the versions are there to repeat the study", { skip }, () =>
  withPage(example(), {}, async (page) => {
    const text = await page.locator("#repeat").textContent();
    const { command, repeat } = example();
    [command, repeat.fingerprint, ...repeat.versions.map(({ version }) => version)].forEach((part) => assert.ok(text.includes(part), part));
  }),
);

test("thirty results of ten thousand trees open without drawing what nobody sees", { skip }, () => {
  const data = example();
  const [model] = data.results;
  const repeat = (values, number) => Array.from({ length: number }, (_, index) => values[index % values.length]);
  const grown = (columns) => Object.fromEntries(Object.entries(columns).map(([name, values]) => [name, Array.isArray(values) ? repeat(values, 1000) : grown(values)]));
  data.results = Array.from({ length: 30 }, (_, index) => ({ ...model, species: `S${index + 1}`, n: 2500, observations: grown(model.observations) }));
  return withPage(data, {}, async (page) => {
    const charts = await page.locator(".chart").count();
    const drawn = await page.locator(".chart[data-drawn]").count();
    assert.ok(charts > 300 && drawn < 5, `${drawn} of ${charts} charts are drawn at once`);
    assert.match(await page.locator("#result-30 figure").first().textContent(), /A sample of 1.000 of 2.500 trees is shown/);
    await page.locator("nav a[href='#result-30']").click();
    await page.locator("#result-30 .chart canvas").first().waitFor();
  });
});
