// SPDX-License-Identifier: MIT
// The 3D page in a browser: opened, looked at, compared.
import { launchWithWebGl, WEBGL_TIMEOUT } from "./browser.mjs";
import { inBrowser } from "./in-browser.mjs";

/** What tests ask of a page; runs in the page. */
function addProbes() {
  const { page } = window.silvafitView;
  Object.assign(window.silvafitView, {
    /** The middle of a tree's crown on the canvas [CSS pixels]. */
    whereIs(tree, side = 0) {
      const { crown, place } = page.view.sides[side].bodies[tree];
      return page.view.onCanvas({ ...place, y: place.y + (crown.hcb + crown.h) / 2 }, side);
    },
    camera: () => page.view.camera.position.toArray(),
    chosen: () => page.chosen,
    groundAt: (x, z) => page.moves.groundAt(x, z),
    hasObject: (name) => page.view.scene.getObjectByName(name) !== undefined,
    /** Corners of the scale bar, the arrow and their labels on the canvas [CSS pixels]. */
    whereIsScale: () => page.ground.markCorners().map((corner) => page.view.onCanvas(corner)),
    /** Names of the plots whose boundaries are drawn. */
    outlined: () => page.ground.outlined.map(({ name }) => name),
  });
}

/** Waits until an opened page has drawn. */
export async function ready(page) {
  await page.evaluate(() => window.silvafitView.ready);
  await page.evaluate(addProbes);
}

/** As inBrowser, with WebGL, and waiting until the page has drawn. */
export function inWebGl() {
  const { skip, withPage } = inBrowser(launchWithWebGl);
  return {
    skip,
    withScene: (data, options, use) =>
      withPage(data, { viewport: { width: 900, height: 480 }, timeout: WEBGL_TIMEOUT, ...options }, async (page, problems) => {
        await ready(page);
        await use(page, problems);
      }),
  };
}

/** Pixels of the canvas, RGBA rows from the top, drawn just now. @returns {Promise<{width: number, height: number, data: Uint8Array}>} */
export async function pixels(page) {
  const { width, height, base64 } = await page.evaluate(() => {
    window.silvafitView.draw();
    const canvas = document.getElementById("canvas");
    const copy = Object.assign(document.createElement("canvas"), { width: canvas.width, height: canvas.height });
    const context = copy.getContext("2d");
    context.drawImage(canvas, 0, 0);
    const { data } = context.getImageData(0, 0, copy.width, copy.height);
    let text = "";
    for (let at = 0; at < data.length; at += 8192) text += String.fromCharCode(...data.subarray(at, at + 8192));
    return { width: copy.width, height: copy.height, base64: btoa(text) };
  });
  return { width, height, data: new Uint8Array(Buffer.from(base64, "base64")) };
}

/** A PNG file, decoded by the browser. */
export async function decoded(page, png) {
  const { width, height, base64 } = await page.evaluate(async (source) => {
    const image = new Image();
    image.src = `data:image/png;base64,${source}`;
    await image.decode();
    const copy = Object.assign(document.createElement("canvas"), { width: image.width, height: image.height });
    const context = copy.getContext("2d");
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, copy.width, copy.height);
    let text = "";
    for (let at = 0; at < data.length; at += 8192) text += String.fromCharCode(...data.subarray(at, at + 8192));
    return { width: copy.width, height: copy.height, base64: btoa(text) };
  }, png.toString("base64"));
  return { width, height, data: new Uint8Array(Buffer.from(base64, "base64")) };
}

/** Share of pixels whose red, green or blue differ by more than a step, and the mean difference of all values. */
export function difference(first, second, step = 24) {
  let changed = 0;
  let sum = 0;
  const count = first.data.length / 4;
  for (let at = 0; at < first.data.length; at += 4) {
    let most = 0;
    for (let k = 0; k < 3; ++k) {
      const own = Math.abs(first.data[at + k] - second.data[at + k]);
      most = Math.max(most, own);
      sum += own;
    }
    changed += most > step ? 1 : 0;
  }
  return { changed: changed / count, mean: sum / (3 * count) };
}

/** Share of pixels that differ from the upper left one, the sky. */
export function drawnShare({ data }) {
  let drawn = 0;
  for (let at = 0; at < data.length; at += 4) drawn += [0, 1, 2].some((k) => Math.abs(data[at + k] - data[k]) > 12) ? 1 : 0;
  return drawn / (data.length / 4);
}

/** The part of a picture between two columns. */
export function columns({ width, height, data }, from, to) {
  const part = new Uint8Array(4 * (to - from) * height);
  for (let row = 0; row < height; ++row) part.set(data.subarray(4 * (row * width + from), 4 * (row * width + to)), 4 * row * (to - from));
  return { width: to - from, height, data: part };
}
