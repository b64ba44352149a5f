// SPDX-License-Identifier: MIT
// Sky and haze for walking; from outside, the stand is in front of one color.
import { BackSide, Box3, BufferAttribute, Color, FogExp2, Mesh, MeshBasicMaterial, SphereGeometry } from "three";

/** At 100 m an eleventh of a color is that of the haze, at 300 m more than half. */
const HAZE_PER_M = 0.003;
const ZENITH = { light: new Color("#5f93c4"), dark: new Color("#05080c") };
/** The horizon's color reaches a little above the horizon, where crowns end. */
const HORIZON_SHARE = 0.06;

export class Sky {
  constructor() {
    this.haze = new FogExp2(0xffffff, HAZE_PER_M);
    const geometry = new SphereGeometry(1, 24, 32);
    geometry.setAttribute("color", new BufferAttribute(new Float32Array(3 * geometry.attributes.position.count), 3));
    // The sky is no part of the scene's extent.
    geometry.boundingBox = new Box3();
    const material = new MeshBasicMaterial({ vertexColors: true, side: BackSide, fog: false, depthTest: false, depthWrite: false, toneMapped: false });
    this.dome = Object.assign(new Mesh(geometry, material), { name: "sky", frustumCulled: false, renderOrder: -1 });
    this.dome.raycast = () => {};
  }

  /** @param {string} horizon  color */
  paint(horizon) {
    const low = new Color(horizon);
    this.haze.color.copy(low);
    const high = low.getHSL({}).l > 0.5 ? ZENITH.light : ZENITH.dark;
    const { position, color } = this.dome.geometry.attributes;
    for (let index = 0; index < position.count; ++index) {
      const share = Math.min(1, Math.max(0, (position.getY(index) - HORIZON_SHARE) / (1 - HORIZON_SHARE)));
      const { r, g, b } = low.clone().lerp(high, share ** 0.6);
      color.setXYZ(index, r, g, b);
    }
    color.needsUpdate = true;
  }

  /** Puts the sky around the camera. */
  follow({ position, near }) {
    this.dome.position.copy(position);
    this.dome.scale.setScalar(10 * near);
  }
}
