// The contract's colours are linear; a colour field of the browser holds sRGB bytes.
import type { Vec3 } from './scene';

const toByte = (linear: number): number => {
  const v = Math.min(1, Math.max(0, linear));
  return Math.round(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));
};
const fromByte = (byte: number): number => {
  const v = byte / 255;
  return v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
};

export const hexOf = (linear: Vec3): string =>
  '#' + linear.map((v) => toByte(v).toString(16).padStart(2, '0')).join('');

export const linearOf = (hex: string): Vec3 => {
  const byte = (at: number) =>
    Number(fromByte(Number.parseInt(hex.slice(at, at + 2), 16)).toFixed(4));
  return [byte(1), byte(3), byte(5)];
};
