// SPDX-License-Identifier: MIT
// Keys and clicks on the view, except those that move it.

const CLICK_PX = 6;

const click = (id) => () => document.getElementById(id)?.click();

/**
 * Shortcuts while the view has the focus; panel.js lists them.
 * @param {{setMode: (mode: string) => void, showKeys: () => void, chooseNone: () => void}} act
 */
export function listenToKeys(canvas, act) {
  const actions = {
    1: () => act.setMode("orbit"),
    2: () => act.setMode("walk"),
    f: click("whole"),
    c: click("crowns"),
    o: click("overlaps"),
    p: click("save"),
    "?": act.showKeys,
    Escape: act.chooseNone,
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
