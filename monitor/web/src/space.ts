// The little mathematics of the 3D panel: quaternions (Hamilton, w x y z), and a camera that circles a point. World: x
// east, y north, z up; base: x forward, y left, z up.

export type Vec = [number, number, number];
export interface Quat {
  w: number;
  x: number;
  y: number;
  z: number;
}

/** Takes coordinates of the base to the world's. */
export function rotate(q: Quat, [x, y, z]: Vec): Vec {
  const { w, x: a, y: b, z: c } = q;
  const tx = 2 * (b * z - c * y), ty = 2 * (c * x - a * z), tz = 2 * (a * y - b * x);
  return [x + w * tx + b * tz - c * ty, y + w * ty + c * tx - a * tz, z + w * tz + a * ty - b * tx];
}

/** Roll, pitch, yaw in rad: about x, y, z in turn from the world to the base (ZYX). */
export function angles({ w, x, y, z }: Quat): { roll: number; pitch: number; yaw: number } {
  return {
    roll: Math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
    pitch: Math.asin(Math.max(-1, Math.min(1, 2 * (w * y - z * x)))),
    yaw: Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)),
  };
}

export interface Camera {
  azimuth: number; // rad; from where it looks, counter-clockwise from east
  elevation: number; // rad, above the horizon
  distance: number; // m
  target: Vec;
}

export type Project = (p: Vec) => { x: number; y: number; depth: number } | null;

/** Null: behind the camera. */
export function projector(camera: Camera, width: number, height: number): Project {
  const { azimuth: a, elevation: e, distance, target } = camera;
  const back: Vec = [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)];
  const right: Vec = [-Math.sin(a), Math.cos(a), 0];
  const up: Vec = [-Math.sin(e) * Math.cos(a), -Math.sin(e) * Math.sin(a), Math.cos(e)];
  const focal = Math.min(width, height) * 1.1;
  return ([x, y, z]) => {
    const d: Vec = [x - target[0], y - target[1], z - target[2]];
    const depth = distance - (d[0] * back[0] + d[1] * back[1] + d[2] * back[2]);
    if (depth < 0.05) return null;
    const s = focal / depth;
    return {
      x: width / 2 + (d[0] * right[0] + d[1] * right[1]) * s,
      y: height / 2 - (d[0] * up[0] + d[1] * up[1] + d[2] * up[2]) * s,
      depth,
    };
  };
}
