// SPDX-License-Identifier: MIT
// Light or dark theme: that of the system, or the reader's choice.
import { element } from "./dom.js";

const KEY = "silvafit-theme";
const CHOICES = [
  ["auto", "As the system"],
  ["light", "Light"],
  ["dark", "Dark"],
];
const system = matchMedia("(prefers-color-scheme: dark)");
const listeners = [];

/* Pages that are opened from disk may have no storage. */
function stored() {
  try {
    return localStorage.getItem(KEY) ?? "auto";
  } catch {
    return "auto";
  }
}

function store(choice) {
  try {
    localStorage.setItem(KEY, choice);
  } catch {
    // The choice is then valid for this visit.
  }
}

let choice = CHOICES.some(([name]) => name === stored()) ? stored() : "auto";

function apply() {
  const theme = choice === "auto" ? (system.matches ? "dark" : "light") : choice;
  if (document.documentElement.dataset.theme === theme) return;
  document.documentElement.dataset.theme = theme;
  listeners.forEach((listener) => listener());
}

/** The result of a function that runs while the page has its light colors, as on paper. Nothing is painted meanwhile. */
export function inLight(find) {
  const { classList } = document.documentElement;
  const wasLight = classList.contains("print");
  classList.add("print");
  try {
    return find();
  } finally {
    if (!wasLight) classList.remove("print");
  }
}

export const onThemeChange = (listener) => listeners.push(listener);

export function startTheme() {
  apply();
  system.addEventListener("change", apply);
}

export function themeSwitch() {
  const options = CHOICES.map(([value, text]) => element("option", { value, selected: value === choice }, text));
  const select = element("select", { id: "theme" }, ...options);
  select.addEventListener("change", () => {
    choice = select.value;
    store(choice);
    apply();
  });
  return element("p", { class: "theme" }, element("label", {}, "Theme ", select));
}
