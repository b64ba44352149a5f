// SPDX-License-Identifier: MIT
// Navigation: around the stand (orbit) or through it at eye height (walk), by mouse, touch and keyboard.
import { Euler, Vector3 } from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

export const EYE_HEIGHT_M = 1.7;
const WALK_M_PER_S = 3;
const RUN = 4;
const TURN_PER_S = 1.2;
const STEP_RAD = Math.PI / 36;
const SOUTH_WEST_ABOVE = new Vector3(-0.35, 0.42, 0.84).normalize();
const UP = new Vector3(0, 1, 0);

/** Speeds of the keys: [forward, right, turn left, look up] per second. */
const WALK_KEYS = {
  KeyW: [1, 0, 0, 0],
  KeyS: [-1, 0, 0, 0],
  KeyA: [0, -1, 0, 0],
  KeyD: [0, 1, 0, 0],
  ArrowUp: [1, 0, 0, 0],
  ArrowDown: [-1, 0, 0, 0],
  ArrowLeft: [0, 0, 1, 0],
  ArrowRight: [0, 0, -1, 0],
  PageUp: [0, 0, 0, 1],
  PageDown: [0, 0, 0, -1],
};

/** Directions of view to try: the current one, then other sides, then higher ones. */
function sightLines(away) {
  const lines = [];
  const level = away.clone().setY(0);
  const flat = level.lengthSq() > 1e-9 ? level.normalize() : new Vector3(0, 0, 1);
  const now = Math.asin(Math.min(1, Math.max(-1, away.y / away.length())));
  for (const height of [now, ...[0.6, 0.9, 1.2, 1.5].filter((angle) => angle > now)]) {
    for (const turn of [0, 1, -1, 2, -2, 3, -3, 4, -4, 5, -5, 6]) {
      const line = flat.clone().applyAxisAngle(UP, (turn * Math.PI) / 6).multiplyScalar(Math.cos(height)).setY(Math.sin(height));
      lines.push(line.multiplyScalar(away.length()));
    }
  }
  return lines;
}

export class Moves {
  /** @param {import("./view.js").View} view  @param {(x: number, z: number) => number} groundAt */
  constructor(view, groundAt, isCalm) {
    this.view = view;
    this.groundAt = groundAt;
    this.mode = "orbit";
    this.held = new Set();
    this.isWalking = false;
    this.orbit = new OrbitControls(view.camera, view.canvas);
    this.orbit.enableDamping = !isCalm;
    this.orbit.maxPolarAngle = Math.PI * 0.52;
    this.orbit.minDistance = 1;
    this.orbit.addEventListener("change", () => view.invalidate());
    view.onDrawn(() => this.mode === "orbit" && this.orbit.enableDamping && this.orbit.update());
    this.listen();
  }

  listen() {
    const { canvas } = this.view;
    canvas.addEventListener("keydown", (event) => this.keyDown(event));
    canvas.addEventListener("keyup", (event) => this.held.delete(event.code));
    canvas.addEventListener("blur", () => this.held.clear());
    canvas.addEventListener("pointermove", (event) => this.drag(event));
  }

  /** Looks from one point at another, both [x, y, z]. */
  lookFrom(from, at) {
    const { camera } = this.view;
    camera.position.fromArray(from);
    if (this.mode === "walk") {
      this.stand();
      camera.lookAt(...at);
    } else {
      this.orbit.target.fromArray(at);
      this.orbit.update();
    }
    this.view.invalidate();
  }

  /** The middle of the view; while walking, a point ahead. */
  target() {
    const { camera } = this.view;
    if (this.mode !== "walk") return this.orbit.target;
    return camera.position.clone().addScaledVector(camera.getWorldDirection(new Vector3()), 10);
  }

  /** Shows a whole box, and other points, from the south-west above. */
  frame(box, others = []) {
    this.setMode("orbit");
    const center = box.getCenter(new Vector3());
    const distance = Math.max(4, this.view.distanceToFit(box, center, SOUTH_WEST_ABOVE, others));
    this.orbit.target.copy(center);
    this.view.camera.position.copy(center).add(SOUTH_WEST_ABOVE.clone().multiplyScalar(distance));
    this.orbit.maxDistance = 5 * distance;
    this.view.camera.far = 6 * distance + 1000;
    this.orbit.update();
    this.view.invalidate();
  }

  /**
   * Shows a tree in the center of the view.
   * @param {(from: Vector3, ahead: Vector3) => boolean} isSeen  whether nothing hides it
   */
  lookAt({ place, crown }, isSeen = () => true) {
    if (this.mode === "walk") {
      this.view.camera.lookAt(place.x, place.y + crown.h / 2, place.z);
      this.view.invalidate();
      return;
    }
    const target = new Vector3(place.x, place.y + crown.h / 2, place.z);
    const away = this.view.camera.position.clone().sub(this.orbit.target);
    away.setLength(Math.min(away.length(), Math.max(8, 2.2 * crown.h)));
    const seen = sightLines(away).find((line) => isSeen(target.clone().add(line), line.clone().normalize().negate()));
    this.orbit.target.copy(target);
    this.view.camera.position.copy(target).add(seen ?? away);
    this.orbit.update();
    this.view.invalidate();
  }

  setMode(mode) {
    if (mode === this.mode) return;
    this.mode = mode;
    this.orbit.enabled = mode === "orbit";
    const { camera } = this.view;
    const ahead = camera.getWorldDirection(new Vector3());
    if (mode === "walk") {
      const { x, z } = this.orbit.target;
      const back = ahead.clone().setY(0).normalize();
      camera.position.set(x - 6 * back.x, 0, z - 6 * back.z);
      this.stand();
      camera.lookAt(camera.position.clone().add(back));
    } else {
      this.orbit.target.copy(camera.position).addScaledVector(ahead, 10);
      this.orbit.update();
    }
    this.view.invalidate();
  }

  /** Keeps the eye above the ground. */
  stand() {
    const { position } = this.view.camera;
    position.y = this.groundAt(position.x, position.z) + EYE_HEIGHT_M;
  }

  /** @param {[number, number, number, number]} move  as in WALK_KEYS, times seconds */
  walk([forward, right, left, up]) {
    const { camera } = this.view;
    const angles = new Euler().setFromQuaternion(camera.quaternion, "YXZ");
    angles.y += left * TURN_PER_S;
    angles.x = Math.min(1.5, Math.max(-1.5, angles.x + up * TURN_PER_S));
    angles.z = 0;
    camera.quaternion.setFromEuler(angles);
    const ahead = new Vector3(-Math.sin(angles.y), 0, -Math.cos(angles.y));
    const aside = new Vector3().crossVectors(ahead, UP);
    camera.position.addScaledVector(ahead, forward * WALK_M_PER_S).addScaledVector(aside, right * WALK_M_PER_S);
    this.stand();
    this.view.invalidate();
  }

  keyDown(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (this.mode === "walk") {
      if (!WALK_KEYS[event.code]) return;
      event.preventDefault();
      this.press(event.code, event.shiftKey);
    } else if (this.turn(event)) {
      event.preventDefault();
    }
  }

  /** Walks while keys, or buttons of the same names, are held. */
  press(code, isFast = false) {
    const isFirst = this.held.size === 0;
    this.held.add(code);
    this.isFast = isFast;
    // The first step is immediate, so that a short touch moves, too.
    if (isFirst) this.step(0.1);
    // Between a release and the next frame the loop is still running: a second one would double the speed.
    if (this.isWalking) return;
    this.isWalking = true;
    let before = performance.now();
    const next = (now) => {
      this.isWalking = this.held.size > 0 && this.mode === "walk";
      if (!this.isWalking) return;
      this.step(Math.min(0.1, Math.max(0, now - before) / 1000));
      before = now;
      requestAnimationFrame(next);
    };
    requestAnimationFrame(next);
  }

  release(code) {
    this.held.delete(code);
  }

  step(seconds) {
    const move = [0, 0, 0, 0];
    for (const code of this.held) WALK_KEYS[code].forEach((value, axis) => (move[axis] += value));
    const pace = this.isFast ? RUN : 1;
    this.walk([move[0] * seconds * pace, move[1] * seconds * pace, move[2] * seconds, move[3] * seconds]);
  }

  /** Keys of orbit: arrows turn, + and - zoom, WASD move the center. @returns whether the key has a function */
  turn({ code, key }) {
    const { camera } = this.view;
    const { target } = this.orbit;
    const away = camera.position.clone().sub(target);
    const turns = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[code];
    const shift = { KeyW: [1, 0], KeyS: [-1, 0], KeyA: [0, -1], KeyD: [0, 1] }[code];
    if (turns) {
      away.applyAxisAngle(UP, turns[0] * STEP_RAD);
      const polar = Math.acos(away.y / away.length());
      const wanted = Math.min(this.orbit.maxPolarAngle, Math.max(0.02, polar - turns[1] * STEP_RAD));
      away.applyAxisAngle(new Vector3().crossVectors(UP, away).normalize(), wanted - polar);
    } else if (key === "+" || key === "=") {
      away.multiplyScalar(0.9);
    } else if (key === "-") {
      away.multiplyScalar(1 / 0.9);
    } else if (shift) {
      const ahead = away.clone().setY(0).normalize().negate();
      const aside = new Vector3().crossVectors(ahead, UP);
      target.addScaledVector(ahead, shift[0] * away.length() * 0.05).addScaledVector(aside, shift[1] * away.length() * 0.05);
    } else {
      return false;
    }
    camera.position.copy(target).add(away);
    this.orbit.update();
    this.view.invalidate();
    return true;
  }

  /** In walk mode a drag turns the camera. */
  drag(event) {
    if (this.mode !== "walk" || event.buttons !== 1) return;
    const perPixel = 1 / this.view.size.height / TURN_PER_S;
    this.walk([0, 0, event.movementX * perPixel, event.movementY * perPixel]);
  }
}
