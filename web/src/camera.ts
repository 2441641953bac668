// Moving the eye, and where a place in the scene lies in the picture.
import type { FrameCamera } from './frame';
import type { Bounds, CameraDocument, Vec3, ViewName } from './scene';
import { add, cross, dot, length, normalize, rounded, scale, subtract, tidy, turned } from './vectors';

/** A camera that says where its eye is, as moving it makes it. */
export interface Pose extends CameraDocument {
  eye: Vec3;
  target: Vec3;
  up: Vec3;
}

export const defaultFov = 30;
/** What the page begins with, and goes back to: a face is not bulged as from near by. */
export const usualFov = 18;
/** How much of the picture's width or height is filled. */
export const fitShare = 0.9;
const superior: Vec3 = [0, 0, 1];

/** The pose of the camera that the last frame was drawn with. */
export function poseOf(document: CameraDocument | undefined, seen: FrameCamera, bounds: Bounds): Pose {
  const toTarget = subtract(document?.target ?? bounds.center, seen.eye);
  // On the axis of view, so that nothing jumps.
  const target = subtract(seen.eye, scale(Math.max(1e-3, -dot(toTarget, seen.back)), seen.back));
  const pose: Pose = {
    eye: seen.eye,
    target,
    up: seen.up,
    projection: seen.orthographic ? 'orthographic' : 'perspective',
  };
  if (seen.orthographic) pose.height = 2 * seen.half_height;
  else pose.fov = document?.fov ?? defaultFov;
  return pose;
}

const tidied = (pose: Pose): Pose => ({
  ...pose,
  eye: rounded(pose.eye),
  target: rounded(pose.target),
  up: rounded(pose.up),
});

/** Turns about the target: about the patient's long axis, and up and down without tipping over. */
export function orbited(pose: Pose, angleAcross: number, angleDown: number): Pose {
  const back = subtract(pose.eye, pose.target);
  let up = normalize(pose.up);
  // Upside down, the hand still takes the surface along.
  const yaw = up[2] < -1e-6 ? angleAcross : -angleAcross;
  let newBack = turned(back, superior, yaw);
  up = turned(up, superior, yaw);
  const right = normalize(cross(up, newBack));
  const tilted = turned(up, right, -angleDown);
  if (tilted[2] >= 0 || tilted[2] > up[2]) {
    newBack = turned(newBack, right, -angleDown);
    up = tilted;
  }
  return tidied({ ...pose, eye: add(pose.target, newBack), up });
}

/** mm that one pixel spans at the target. */
export function mmPerPixel(pose: Pose, pictureHeight: number): number {
  const height =
    pose.projection === 'orthographic'
      ? (pose.height ?? 1)
      : 2 * length(subtract(pose.eye, pose.target)) * Math.tan(((pose.fov ?? defaultFov) * Math.PI) / 360);
  return height / pictureHeight;
}

function axes(pose: Pose): { right: Vec3; up: Vec3 } {
  const back = normalize(subtract(pose.eye, pose.target));
  const right = normalize(cross(pose.up, back));
  return { right, up: cross(back, right) };
}

/** Moves along with the picture: what was under the hand stays there. Pixels; y runs down. */
export function panned(pose: Pose, dx: number, dy: number, pictureHeight: number): Pose {
  const mm = mmPerPixel(pose, pictureHeight);
  const { right, up } = axes(pose);
  const by = add(scale(-dx * mm, right), scale(dy * mm, up));
  return tidied({ ...pose, eye: add(pose.eye, by), target: add(pose.target, by) });
}

/** Nearer (factor < 1) or farther, while what is at (x, y) from the picture's middle stays there. */
export function zoomed(
  pose: Pose,
  factor: number,
  x: number,
  y: number,
  pictureHeight: number,
  bounds: Bounds,
): Pose {
  const mm = mmPerPixel(pose, pictureHeight);
  const size = mm * pictureHeight * factor;
  if (size < bounds.radius * 1e-3 || size > bounds.radius * 100) return pose;
  const { right, up } = axes(pose);
  const fixed = add(pose.target, add(scale(x * mm, right), scale(-y * mm, up)));
  const target = add(fixed, scale(factor, subtract(pose.target, fixed)));
  const back = subtract(pose.eye, pose.target);
  if (pose.projection === 'orthographic') {
    return tidied({ ...pose, target, eye: add(target, back), height: tidy((pose.height ?? 1) * factor) });
  }
  return tidied({ ...pose, target, eye: add(target, scale(factor, back)) });
}

/**
 * The pose from which what is seen in `part` of the picture (left, top, right, bottom, in shares)
 * fills it but for a margin. With perspective it comes near: things grow unevenly.
 */
export function fitted(
  pose: Pose,
  part: [number, number, number, number],
  width: number,
  height: number,
  bounds: Bounds,
): Pose {
  const [left, top, right, bottom] = part;
  const inMiddle = panned(
    pose,
    (0.5 - (left + right) / 2) * width,
    (0.5 - (top + bottom) / 2) * height,
    height,
  );
  const factor = Math.max(right - left, bottom - top) / fitShare;
  return zoomed(inMiddle, factor, 0, 0, height, bounds);
}

/** Another field of view, from where the target looks as large as before. */
export function withFov(pose: Pose, fov: number): Pose {
  const half = (deg: number) => Math.tan((deg * Math.PI) / 360);
  const factor = half(pose.fov ?? defaultFov) / half(fov);
  const back = scale(factor, subtract(pose.eye, pose.target));
  return tidied({ ...pose, fov, eye: add(pose.target, back) });
}

/** With or without perspective; the target looks as large as before. */
export function withProjection(pose: Pose, projection: Pose['projection']): Pose {
  if (projection === pose.projection) return pose;
  const { fov, height, ...rest } = pose;
  const half = Math.tan(((fov ?? defaultFov) * Math.PI) / 360);
  const back = subtract(pose.eye, pose.target);
  if (projection === 'orthographic') {
    return { ...rest, projection, height: tidy(2 * half * length(back)) };
  }
  const distance = (height ?? 1) / (2 * half);
  return tidied({
    ...rest,
    projection,
    fov: defaultFov,
    eye: add(pose.target, scale(distance, normalize(back))),
  });
}

export interface ScreenPoint {
  /** Shares of the picture's width and height. */
  x: number;
  y: number;
  /** mm in front of the eye; what is behind it has no place. */
  depth: number;
}

export function projected(camera: FrameCamera, aspect: number, p: Vec3): ScreenPoint | undefined {
  const from = subtract(p, camera.eye);
  const depth = -dot(from, camera.back);
  if (!camera.orthographic && depth <= 1e-6) return undefined;
  const half = camera.half_height * (camera.orthographic ? 1 : depth);
  return {
    x: 0.5 + dot(from, camera.right) / (2 * half * aspect),
    y: 0.5 - dot(from, camera.up) / (2 * half),
    depth,
  };
}

/** The place at that depth in front of the eye which is seen at (x, y); the inverse of projected. */
export function unprojected(camera: FrameCamera, aspect: number, point: ScreenPoint): Vec3 {
  const half = camera.half_height * (camera.orthographic ? 1 : point.depth);
  return add(
    camera.eye,
    add(
      scale(-point.depth, camera.back),
      add(
        scale((point.x - 0.5) * 2 * half * aspect, camera.right),
        scale((0.5 - point.y) * 2 * half, camera.up),
      ),
    ),
  );
}

const facing: [ViewName, Vec3][] = [
  ['front', [0, -1, 0]],
  ['back', [0, 1, 0]],
  ['left', [1, 0, 0]],
  ['right', [-1, 0, 0]],
  ['top', [0, 0, 1]],
  ['bottom', [0, 0, -1]],
];

/** The named view that looks along the same line, if there is one. */
export function viewOf(camera: CameraDocument | undefined): ViewName | undefined {
  if (!camera?.eye || !camera.target) return camera?.view ?? 'front';
  const back = normalize(subtract(camera.eye, camera.target));
  return facing.find(([, towards]) => dot(back, towards) > 0.99999)?.[0];
}
