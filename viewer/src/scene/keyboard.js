// SPDX-License-Identifier: MIT
// Keys and clicks on the picture, besides those that move it.

const CLICK_PX = 6;

const click = (id) => () => document.getElementById(id)?.click();

/**
 * Shortcuts while the picture has the focus; the list of keys in panel.js says them.
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

/** Presses that are no drags, by their place in the window [CSS pixels]. */
export function listenToClicks(canvas, use) {
  let down = null;
  canvas.addEventListener("pointerdown", ({ clientX, clientY }) => (down = [clientX, clientY]));
  canvas.addEventListener("pointerup", ({ clientX, clientY }) => {
    if (down && Math.hypot(clientX - down[0], clientY - down[1]) < CLICK_PX) use(clientX, clientY);
    down = null;
  });
}
