// SPDX-License-Identifier: MIT
// Figures as files: all panels with their headings and the legend in one SVG or PNG, light and without the page's style sheet.
import { chartSvg } from "./chart-view.js";
import { save, slug } from "./csv.js";
import { element } from "./dom.js";
import { inLight } from "./theme.js";

const PANEL = { width: 440, height: 300 };
const GAP = 16;
const MARGIN = 12;
const LINE = 20;
/** Pixels of a PNG per pixel of the SVG: about 300 dots per inch if a panel is 11 cm wide. */
const PNG_SCALE = 3;

const escaped = (text) => text.replace(/[&<>"]/g, (sign) => `&#${sign.charCodeAt(0)};`);
const text = (content, x, y, more = "") => `<text x="${x}" y="${y}" ${more}>${escaped(content)}</text>`;

/** The key of a legend, drawn as by the page's style sheet. */
function keyDrawing(key, x, y) {
  const style = getComputedStyle(key);
  const [width, height, stroke] = [style.width, style.height, style.borderTopWidth].map(Number.parseFloat);
  if (height > 1) {
    const round = style.borderRadius.includes("50%") ? width / 2 : 0;
    const fill = style.backgroundColor;
    return `<rect x="${x}" y="${y - height / 2}" width="${width}" height="${height}" rx="${round}" fill="${fill}" stroke="${style.borderTopColor}" stroke-width="${stroke}" opacity="${style.opacity}"/>`;
  }
  const dash = style.borderTopStyle === "dashed" ? 'stroke-dasharray="6 3"' : "";
  return `<line x1="${x}" x2="${x + width}" y1="${y}" y2="${y}" stroke="${style.borderTopColor}" stroke-width="${stroke}" ${dash}/>`;
}

/** Entries side by side, on further lines if they do not fit. */
function legendDrawing(figure, width) {
  const pen = document.createElement("canvas").getContext("2d");
  pen.font = `13px ${getComputedStyle(document.body).fontFamily}`;
  let [x, y] = [MARGIN, MARGIN + LINE / 2];
  const parts = [...figure.querySelectorAll(".legend li")].map((entry) => {
    const key = entry.querySelector(".key, .dot");
    const keyWidth = Number.parseFloat(getComputedStyle(key).width) + 7;
    const entryWidth = keyWidth + pen.measureText(entry.textContent).width + 22;
    if (x > MARGIN && x + entryWidth > width) [x, y] = [MARGIN, y + LINE];
    const drawn = keyDrawing(key, x, y) + text(entry.textContent, x + keyWidth, y + 4.5);
    x += entryWidth;
    return drawn;
  });
  return { drawing: parts.join(""), height: parts.length > 0 ? y + LINE / 2 + MARGIN : MARGIN };
}

const nested = (svg, x, y, { width, height }) => svg.replace(/^<svg[^>]*>/, (tag) => {
  const box = tag.match(/viewBox="[^"]*"/)?.[0] ?? `viewBox="0 0 ${width} ${height}"`;
  return `<svg x="${x}" y="${y}" width="${width}" height="${height}" ${box}>`;
});

/** @param {{svg: string, title: string | null, width: number, height: number}[]} panels */
function composed(panels, figure) {
  const columns = Math.min(2, panels.length);
  const widest = Math.max(...panels.map(({ width }) => width));
  const width = 2 * MARGIN + columns * widest + (columns - 1) * GAP;
  const legend = legendDrawing(figure, width);
  let y = legend.height;
  let drawing = "";
  for (let first = 0; first < panels.length; first += columns) {
    const row = panels.slice(first, first + columns);
    const heading = row.some(({ title }) => title) ? LINE : 0;
    row.forEach(({ svg, title, ...size }, column) => {
      const x = MARGIN + column * (widest + GAP);
      drawing += (title ? text(title, x, y + LINE / 2 + 2, 'font-weight="600"') : "") + nested(svg, x, y + heading, size);
    });
    y += heading + Math.max(...row.map(({ height }) => height)) + GAP;
  }
  const { fontFamily } = getComputedStyle(document.body);
  return {
    width,
    height: y,
    svg:
      `<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="${width}" height="${y}" viewBox="0 0 ${width} ${y}" ` +
      `font-family="${escaped(fontFamily)}" font-size="13" fill="#1f2a24"><rect width="100%" height="100%" fill="#ffffff"/>${legend.drawing}${drawing}</svg>`,
  };
}

async function panelsOf(figure) {
  const charts = [...figure.querySelectorAll(".chart")];
  return Promise.all(
    charts.map(async (chart) => {
      const { svg, height } = await chartSvg(chart, PANEL);
      return { svg, width: PANEL.width, height, title: chart.parentElement.querySelector("h4")?.textContent ?? null };
    }),
  );
}

/** The figure as the text of an SVG file, with its size. */
export async function figureSvg(figure, panels = panelsOf) {
  const drawn = await panels(figure);
  return inLight(() => composed(drawn, figure));
}

async function png({ svg, width, height }) {
  const image = new Image();
  // The page may load pictures only from data URLs.
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(svg)}`;
  await image.decode();
  const canvas = element("canvas", { width: Math.round(width * PNG_SCALE), height: Math.round(height * PNG_SCALE) });
  canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
}

const fileName = (figure, title, extension) => `figure-${figure.dataset.number ?? ""}-${slug(title, 50)}.${extension}`;

/**
 * Buttons that save a figure as a vector and as a bitmap picture.
 * @param {HTMLElement} figure
 * @param {string} title
 * @param {(figure: HTMLElement) => Promise<{svg: string, title: string | null, width: number, height: number}[]>} panels
 */
export function pictureButtons(figure, title, panels = panelsOf) {
  const button = (format, content) => {
    const node = element("button", { type: "button", class: "download", "aria-label": `Save as ${format}: ${title}` }, `Save as ${format}`);
    node.addEventListener("click", async () => save(fileName(figure, title, format.toLowerCase()), await content(await figureSvg(figure, panels))));
    return node;
  };
  const vector = ({ svg }) => new Blob([svg], { type: "image/svg+xml" });
  return element("p", { class: "save" }, button("SVG", vector), " ", button("PNG", png));
}
