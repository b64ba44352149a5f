// SPDX-License-Identifier: MIT
// The view: renderer, camera, light, one side or two. A frame is drawn only when something has changed.
import { ACESFilmicToneMapping, AmbientLight, Box3, Color, DirectionalLight, Frustum, HemisphereLight, Matrix4, PCFShadowMap, PerspectiveCamera, Raycaster, Scene, Vector2, Vector3, WebGLRenderer } from "three";
import { layersOf } from "./sides.js";
import { AdaptiveBudget, BUDGETS } from "./levels.js";
import { Sky } from "./sky.js";

const VIEW_DEG = 45;
const SUN = new Vector3(-0.55, 0.75, 0.45).normalize();
const MOST_PIXEL_RATIO = 2;
/** While walking, shadows are drawn to this distance, and again after this many steps [m]. */
const SHADOW_REACH_M = 60;
const SHADOW_STEP_M = 15;

function sunOf(side) {
  const sun = new DirectionalLight(0xfff4e0, 2.6);
  sun.layers.set(layersOf(side).own);
  sun.target.layers.set(layersOf(side).own);
  sun.shadow.autoUpdate = false;
  sun.shadow.bias = -0.0004;
  sun.shadow.normalBias = 0.06;
  return sun;
}

/** Without a graphics card a frame of a million triangles takes seconds, so detail starts low. */
function drawsInSoftware(renderer) {
  const context = renderer.getContext();
  const known = context.getExtension("WEBGL_debug_renderer_info");
  return known !== null && /swiftshader|llvmpipe|software|basic render/i.test(context.getParameter(known.UNMASKED_RENDERER_WEBGL));
}

export class View {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new WebGLRenderer({ canvas, antialias: true, powerPreference: "high-performance" });
    this.renderer.info.autoReset = false;
    this.renderer.toneMapping = ACESFilmicToneMapping;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.renderer.localClippingEnabled = true;
    this.castFromOwnLayer();
    this.scene = new Scene();
    this.sky = new HemisphereLight(0xdfeaf5, 0x6b6450, 1.5);
    this.scene.add(this.sky, new AmbientLight(0xffffff, 0.35));
    this.camera = new PerspectiveCamera(VIEW_DEG, 1, 0.1, 5000);
    this.outdoors = new Sky();
    this.isWalking = false;
    this.suns = [sunOf(0), sunOf(1)];
    for (const sun of this.suns) this.scene.add(sun, sun.target);
    this.sides = [];
    this.marks = [];
    this.adaptive = new AdaptiveBudget();
    this.isSoftware = drawsInSoftware(this.renderer);
    if (this.isSoftware) this.adaptive.budget = this.adaptive.least;
    this.detail = "automatic";
    this.listeners = [];
    this.stats = { calls: 0, triangles: 0, milliseconds: 0, trees: 0, byLevel: [] };
    this.resize();
  }

  /** Shadow casters are on a layer of their own: they are drawn only when the shadows change. */
  castFromOwnLayer() {
    const { shadowMap } = this.renderer;
    const render = shadowMap.render;
    shadowMap.enabled = true;
    shadowMap.render = (lights, scene, camera) => {
      const { mask } = camera.layers;
      camera.layers.enable(layersOf(this.drawn ?? 0).caster);
      render.call(shadowMap, lights, scene, camera);
      camera.layers.mask = mask;
    };
  }

  get size() {
    return { width: this.canvas.clientWidth || 1, height: this.canvas.clientHeight || 1 };
  }

  resize() {
    const { width, height } = this.size;
    this.renderer.setPixelRatio(Math.min(MOST_PIXEL_RATIO, window.devicePixelRatio));
    this.renderer.setSize(width, height, false);
    this.invalidate();
  }

  /** @param {{stand: import("./stand.js").Stand}[]} sides  one or two */
  setSides(sides) {
    for (const { stand } of this.sides) {
      this.scene.remove(stand.group);
      stand.dispose();
    }
    this.sides = sides;
    for (const { stand } of sides) this.scene.add(stand.group);
    this.shadowsChanged();
  }

  get box() {
    return this.sides.reduce((box, { stand }) => box.union(stand.box), new Box3());
  }

  setShadows(isOn) {
    for (const sun of this.suns) sun.castShadow = isOn;
    this.shadowsChanged();
  }

  /** Sky and haze, and shadows that follow the camera. */
  setWalking(isWalking) {
    if (isWalking === this.isWalking) return;
    this.isWalking = isWalking;
    this.scene.fog = isWalking ? this.outdoors.haze : null;
    if (isWalking) this.scene.add(this.outdoors.dome);
    else this.scene.remove(this.outdoors.dome);
    this.shadowsChanged();
  }

  /** What the shadow camera contains: all shown trees, or the scene if it has none of its own; while walking, the surroundings. */
  shadowed() {
    const { box } = this;
    if (box.isEmpty()) box.setFromObject(this.scene);
    if (box.isEmpty()) return null;
    const center = box.getCenter(new Vector3());
    const radius = box.getSize(new Vector3()).length() / 2;
    if (!this.isWalking || radius <= SHADOW_REACH_M) return { center, radius };
    return { center: this.camera.position.clone(), radius: SHADOW_REACH_M };
  }

  /** Whether the camera has left the middle of the shadows. */
  shadowsAreBehind() {
    return this.isWalking && this.shadowCenter !== undefined && this.shadowRadius === SHADOW_REACH_M && this.camera.position.distanceTo(this.shadowCenter) > SHADOW_STEP_M;
  }

  /** Adjusts the sun's shadow camera. */
  shadowsChanged() {
    const shadowed = this.shadowed();
    if (shadowed) {
      const { center, radius } = shadowed;
      this.shadowCenter = center;
      this.shadowRadius = radius;
      for (const sun of this.suns) {
        sun.target.position.copy(center);
        sun.position.copy(center).addScaledVector(SUN, radius + 10);
        Object.assign(sun.shadow.camera, { left: -radius, right: radius, top: radius, bottom: -radius, near: 1, far: 2 * radius + 20 });
        sun.shadow.camera.updateProjectionMatrix();
        const size = Math.min(radius > 40 && !this.isSoftware ? 4096 : 2048, this.renderer.capabilities.maxTextureSize);
        if (sun.shadow.mapSize.x !== size) {
          sun.shadow.mapSize.set(size, size);
          sun.shadow.map?.dispose();
          sun.shadow.map = null;
        }
        sun.shadow.needsUpdate = true;
      }
    }
    this.invalidate();
  }

  /** Draws with a restored context: everything on the graphics card was lost. */
  restore() {
    for (const { stand } of this.sides) stand.forgetFarViews();
    this.castFromOwnLayer();
    for (const sun of this.suns) sun.shadow.map = null;
    this.shadowsChanged();
  }

  setBackground(color) {
    this.scene.background = new Color(color);
    this.outdoors.paint(color);
    this.invalidate();
  }

  /** The position of each side on the canvas: side by side, or one above the other if the canvas is high. */
  rectangles() {
    const { width, height } = this.size;
    if (this.sides.length < 2) return [{ x: 0, y: 0, width, height }];
    if (width >= height) {
      const half = Math.floor(width / 2);
      return [
        { x: 0, y: 0, width: half, height },
        { x: half, y: 0, width: width - half, height },
      ];
    }
    const half = Math.floor(height / 2);
    return [
      { x: 0, y: 0, width, height: half },
      { x: 0, y: half, width, height: height - half },
    ];
  }

  get budget() {
    const whole = this.detail === "automatic" ? this.adaptive.budget : BUDGETS[this.detail];
    return whole / Math.max(1, this.sides.length);
  }

  aim(rectangle) {
    this.camera.aspect = rectangle.width / rectangle.height;
    // A narrow view shows the same width as a square one.
    const half = Math.tan(((VIEW_DEG / 2) * Math.PI) / 180);
    this.camera.fov = (2 * Math.atan(half / Math.min(1, this.camera.aspect)) * 180) / Math.PI;
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
  }

  /** Distance from the center, in a direction, at which a box and other points just fit into a side of the view. */
  distanceToFit(box, center, direction, others = []) {
    const corners = [box.min, box.max].flatMap(({ x }) => [box.min, box.max].flatMap(({ y }) => [box.min, box.max].map(({ z }) => new Vector3(x, y, z))));
    this.aim(this.rectangles()[0]);
    const tall = Math.tan((this.camera.fov * Math.PI) / 360);
    const right = new Vector3(0, 1, 0).cross(direction).normalize();
    const up = direction.clone().cross(right);
    // A corner that is so far aside, and nearer than the center by its part along the direction, is at the margin of the view.
    const needed = (corner) => {
      const from = corner.clone().sub(center);
      const aside = Math.max(Math.abs(from.dot(right)) / (0.92 * tall * this.camera.aspect), Math.abs(from.dot(up)) / (0.88 * tall), this.camera.near);
      return from.dot(direction) + aside;
    };
    return Math.max(...[...corners, ...others].map(needed));
  }

  draw() {
    const start = performance.now();
    const { renderer, camera, scene } = this;
    renderer.info.reset();
    if (this.shadowsAreBehind()) this.shadowsChanged();
    this.outdoors.follow(camera);
    const rectangles = this.rectangles();
    const frustum = new Frustum();
    const { height: whole } = this.size;
    let trees = 0;
    renderer.setScissorTest(true);
    rectangles.forEach((rectangle, number) => {
      const side = this.sides[number];
      this.aim(rectangle);
      frustum.setFromProjectionMatrix(new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse));
      const pixelsPerRadian = rectangle.height / (2 * Math.tan((camera.fov * Math.PI) / 360));
      if (side) trees += side.stand.update(frustum, camera.position, pixelsPerRadian, this.budget).trees;
      side?.stand.drawFarViews(renderer);
      camera.layers.set(0);
      camera.layers.enable(layersOf(number).own);
      this.drawn = number;
      const bottom = whole - rectangle.y - rectangle.height;
      renderer.setViewport(rectangle.x, bottom, rectangle.width, rectangle.height);
      renderer.setScissor(rectangle.x, bottom, rectangle.width, rectangle.height);
      renderer.render(scene, camera);
    });
    const { calls, triangles } = renderer.info.render;
    this.stats = { calls, triangles, milliseconds: performance.now() - start, trees, byLevel: this.sides.map(({ stand }) => stand.treesByLevel()) };
    this.listeners.forEach((listener) => listener(this.stats));
  }

  onDrawn(listener) {
    this.listeners.push(listener);
  }

  /** Requests a frame. */
  invalidate() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame((now) => {
      this.waiting = false;
      if (this.lastFrame !== undefined && now - this.lastFrame < 500) this.adaptive.observe(now - this.lastFrame);
      this.lastFrame = now;
      this.draw();
    });
  }

  /** The side and the ray under a point of the canvas [CSS pixels]. */
  rayAt(x, y) {
    const rectangles = this.rectangles();
    const number = Math.max(0, rectangles.findIndex((one) => x >= one.x && x < one.x + one.width && y >= one.y && y < one.y + one.height));
    const rectangle = rectangles[number];
    this.aim(rectangle);
    const raycaster = new Raycaster();
    raycaster.setFromCamera(new Vector2((2 * (x - rectangle.x)) / rectangle.width - 1, 1 - (2 * (y - rectangle.y)) / rectangle.height), this.camera);
    return { side: this.sides[number], origin: raycaster.ray.origin, direction: raycaster.ray.direction };
  }

  /** The position of a point of the page's frame on the canvas, on a side [CSS pixels]. */
  onCanvas(point, number = 0) {
    const rectangle = this.rectangles()[number];
    this.aim(rectangle);
    const projected = new Vector3(point.x, point.y, point.z).project(this.camera);
    return { x: rectangle.x + ((projected.x + 1) / 2) * rectangle.width, y: rectangle.y + ((1 - projected.y) / 2) * rectangle.height };
  }

  /** Draws with several pixels per pixel of the screen, as many as the graphics card can. @returns {HTMLCanvasElement}  valid until the next event; resize() ends it */
  drawLarge(times) {
    const { width, height } = this.size;
    const { maxTextureSize } = this.renderer.capabilities;
    this.renderer.setPixelRatio(Math.min(times, maxTextureSize / Math.max(width, height)));
    this.renderer.setSize(width, height, false);
    this.draw();
    return this.canvas;
  }
}
