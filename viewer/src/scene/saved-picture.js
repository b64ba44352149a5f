// SPDX-License-Identifier: MIT
// The view as a picture file, with what the page writes over it: names of the sides, the line between them, and the legend.

const MARGIN = 10;
const LINE = 20;
const SWATCH = 13;
const WIDEST_RAMP = 420;

/** A text in lines that are not wider than a limit. */
function linesOf(pen, text, widest) {
  const lines = [];
  for (const word of text.split(" ")) {
    const longer = lines.length > 0 ? `${lines.at(-1)} ${word}` : word;
    if (lines.length > 0 && pen.measureText(longer).width <= widest) lines[lines.length - 1] = longer;
    else lines.push(word);
  }
  return lines;
}

/** In a box of the page's paper. */
function sideName(pen, text, { x, y }, colors) {
  pen.font = `600 ${pen.font}`;
  pen.fillStyle = colors.paper;
  pen.fillRect(x + MARGIN, y + MARGIN, pen.measureText(text).width + 2 * MARGIN, LINE + 6);
  pen.fillStyle = colors.text;
  pen.fillText(text, x + 2 * MARGIN, y + MARGIN + 3 + LINE / 2);
}

function ramp(pen, { colors, labels }, x, y, width) {
  const gradient = pen.createLinearGradient(x, 0, x + width, 0);
  colors.forEach((color, index) => gradient.addColorStop(index / (colors.length - 1), color));
  const text = pen.fillStyle;
  pen.fillStyle = gradient;
  pen.fillRect(x, y, width, SWATCH);
  pen.fillStyle = text;
  labels.forEach((label, index) => {
    const share = index / (labels.length - 1);
    pen.fillText(label, x + share * (width - pen.measureText(label).width), y + SWATCH + LINE / 2 + 2);
  });
}

/** Below the view, so that it hides nothing: what its lines need, and a function that draws them from a height on. */
function legend(pen, { title, told, keys = [], scale }, width, colors) {
  const inside = width - 2 * MARGIN;
  const { font } = pen;
  const lines = linesOf(pen, told, inside);
  const rows = [[]];
  for (const key of keys) {
    const own = SWATCH + 7 + pen.measureText(key.text).width + 2 * MARGIN;
    if (rows.at(-1).reduce((sum, one) => sum + one.own, own) > inside && rows.at(-1).length > 0) rows.push([]);
    rows.at(-1).push({ ...key, own });
  }
  const height = (1 + lines.length + (keys.length > 0 ? rows.length : 0)) * LINE + (scale ? LINE + SWATCH + 4 : 0) + MARGIN;
  const draw = (top) => {
    let y = top + MARGIN / 2 + LINE / 2;
    pen.fillStyle = colors.text;
    pen.font = `600 ${font}`;
    pen.fillText(title, MARGIN, y);
    pen.font = font;
    y += LINE;
    if (scale) {
      ramp(pen, scale, MARGIN, y - SWATCH / 2, Math.min(inside, WIDEST_RAMP));
      y += LINE + SWATCH + 4;
    }
    for (const row of keys.length > 0 ? rows : []) {
      let x = MARGIN;
      for (const { color, text, own } of row) {
        pen.fillStyle = color;
        pen.fillRect(x, y - SWATCH / 2, SWATCH, SWATCH);
        pen.fillStyle = colors.text;
        pen.fillText(text, x + SWATCH + 7, y);
        x += own;
      }
      y += LINE;
    }
    for (const text of lines) {
      pen.fillText(text, MARGIN, y);
      y += LINE;
    }
  };
  return { height, draw };
}

/**
 * @param {import("./view.js").View} view
 * @param {{names: string[], coloring: object | null, colors: {paper: string, text: string, mark: string}}} shown
 * @param {number} times  pixels of the picture per pixel of the screen
 * @returns {Promise<Blob>}  a PNG file
 */
export function savedPicture(view, { names, coloring, colors }, times) {
  const { width, height } = view.size;
  const canvas = document.createElement("canvas");
  const pen = canvas.getContext("2d");
  const font = `14px ${getComputedStyle(document.body).fontFamily}`;
  pen.font = font;
  const below = coloring ? legend(pen, coloring, width, colors) : { height: 0, draw: () => {} };
  const drawn = view.drawLarge(times);
  const scale = drawn.width / width;
  Object.assign(canvas, { width: drawn.width, height: Math.round(scale * (height + below.height)) });
  pen.fillStyle = colors.paper;
  pen.fillRect(0, 0, canvas.width, canvas.height);
  pen.drawImage(drawn, 0, 0);
  view.resize();
  pen.scale(scale, scale);
  pen.textBaseline = "middle";
  pen.font = font;
  below.draw(height);
  const sides = view.rectangles();
  if (sides.length > 1) {
    pen.fillStyle = colors.mark;
    const { x, y } = sides[1];
    if (x > 0) pen.fillRect(x - 1, 0, 2, height);
    else pen.fillRect(0, y - 1, width, 2);
    sides.forEach((side, index) => {
      pen.font = font;
      sideName(pen, names[index], side, colors);
    });
  }
  return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
}
