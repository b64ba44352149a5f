// SPDX-License-Identifier: MIT
// Keys and clicks on the view, except those that move it.

const CLICK_PX = 6;

const click = (id) => () => document.getElementById(id)?.click();

/** Shortcuts of a page while its view has the focus; panel.js lists them. */
export function listenToKeys(canvas, page) {
  const actions = {
    1: () => page.setMode("orbit"),
    2: () => page.setMode("walk"),
    f: click("whole"),
    c: click("crowns"),
    o: click("overlaps"),
    p: click("save"),
    "?": () => page.dialog.showModal(),
    Escape: () => page.list && page.choose(null),
  };
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    actions[event.key]?.();
  });
}

/** Clicks (not drags), by their position in the window [CSS pixels]. */
export function listenToClicks(canvas, use) {
  let down = null;
  canvas.addEventListener("pointerdown", ({ clientX, clientY }) => (down = [clientX, clientY]));
  canvas.addEventListener("pointerup", ({ clientX, clientY }) => {
    if (down && Math.hypot(clientX - down[0], clientY - down[1]) < CLICK_PX) use(clientX, clientY);
    down = null;
  });
}
