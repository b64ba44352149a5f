// SPDX-License-Identifier: MIT
// Shows an animated scene at any time.
import { AnimationMixer } from "three";

/** Length of the longest animation [s]. */
export const durationOf = (animations) => Math.max(0, ...animations.map(({ duration }) => duration));

export class Player {
  /**
   * @param {import("three").Object3D} scene
   * @param {import("three").AnimationClip[]} animations
   */
  constructor(scene, animations) {
    this.duration = durationOf(animations);
    /** Times with names such as years, if the file has them. @type {{time: number, name: string}[]} */
    this.times = animations.flatMap(({ userData }) => userData.times ?? []);
    this.mixer = new AnimationMixer(scene);
    for (const clip of animations) this.mixer.clipAction(clip).play();
    // The file's nodes are at rest at the last moment.
    this.time = this.duration;
  }

  /** The name of the last time that has passed, or null. */
  get name() {
    return this.times.findLast(({ time }) => time <= this.time + 1e-6)?.name ?? null;
  }

  /** @param {number} time  [s] */
  show(time) {
    this.time = Math.min(Math.max(time, 0), this.duration);
    // At its end an animation restarts.
    this.mixer.setTime(Math.min(this.time, this.duration * (1 - 1e-6)));
  }
}
