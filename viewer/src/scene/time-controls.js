// SPDX-License-Identifier: MIT
// The slider and the button of an animated scene.
import { element, section } from "../dom.js";
import { button } from "./panel.js";

/**
 * @param {import("./player.js").Player} player
 * @param {() => void} changed  after each move
 */
export function timeControls(player, changed) {
  const { duration } = player;
  const slider = element("input", { type: "range", id: "time", min: "0", max: String(duration), step: String(duration / 200), value: String(player.time) });
  const clock = element("span", { class: "quiet", id: "clock" });
  let isPlaying = false;

  const tell = () => {
    const text = player.name ?? `${player.time.toFixed(1)} of ${duration.toFixed(1)} s`;
    clock.textContent = text;
    slider.setAttribute("aria-valuetext", text);
  };
  const show = (time) => {
    player.show(time);
    slider.value = String(player.time);
    tell();
    changed();
  };
  const pause = () => {
    isPlaying = false;
    play.textContent = "Play";
  };
  const start = () => {
    isPlaying = true;
    play.textContent = "Pause";
    if (player.time >= duration) show(0);
    let last = performance.now();
    const next = (now) => {
      if (!isPlaying) return;
      show(player.time + Math.max(0, now - last) / 1000);
      last = now;
      if (player.time < duration) requestAnimationFrame(next);
      else pause();
    };
    requestAnimationFrame(next);
  };
  const play = button("play", "Play", () => (isPlaying ? pause() : start()));
  slider.addEventListener("input", () => {
    const wanted = Number(slider.value);
    pause();
    show(wanted);
  });
  tell();
  return section(
    "times",
    "Growth",
    {},
    element("p", { class: "control" }, element("label", { for: "time" }, "Time"), slider, clock),
    element("p", { class: "buttons" }, play),
  );
}
