import type { Vec3 } from './scene';

export const add = (a: Vec3, b: Vec3): Vec3 => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const subtract = (a: Vec3, b: Vec3): Vec3 => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (s: number, a: Vec3): Vec3 => [s * a[0], s * a[1], s * a[2]];
export const dot = (a: Vec3, b: Vec3): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a: Vec3, b: Vec3): Vec3 => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];
export const length = (a: Vec3): number => Math.hypot(...a);
export const normalize = (a: Vec3): Vec3 => scale(1 / (length(a) || 1), a);
export const largest = (a: Vec3): number => Math.max(...a);

/** `v` turned about the unit vector `axis`; Rodrigues' formula. */
export function turned(v: Vec3, axis: Vec3, angle: number): Vec3 {
  const c = Math.cos(angle);
  const s = Math.sin(angle);
  return add(add(scale(c, v), scale(s, cross(axis, v))), scale((1 - c) * dot(axis, v), axis));
}

/** The same place to about seven digits, so that numbers stay readable. */
export const rounded = (a: Vec3): Vec3 => [tidy(a[0]), tidy(a[1]), tidy(a[2])];

/** To whole multiples of the step, a power of ten. */
export const toStep = (a: Vec3, step: number): Vec3 =>
  a.map((v) => Number((Math.round(v / step) * step).toPrecision(9))) as Vec3;

export const tidy = (value: number): number => Number(value.toPrecision(7));
