// The coefficients of a surface: its own, else its file's, else the usual ones.
import { type InputReport, newSurface, type Surface, type Vec3 } from './scene';
import { largest, scale } from './vectors';

export type Coefficient = 'ka' | 'kd' | 'ks' | 'kr';
export type Material = typeof newSurface;

export function materialOf(one: Surface, input: InputReport | undefined): Material {
  const { iso: _iso, input: _input, ...own } = one;
  const of = input?.kind === 'mesh' ? input.materials[0] : undefined;
  const file = of && { ka: of.ka, kd: of.kd, ks: of.ks, shininess: of.shininess };
  return { ...newSurface, ...file, ...own };
}

/** The colour of a surface is that of its diffuse coefficient at full strength. */
export function colorOf(one: Surface, input: InputReport | undefined): Vec3 {
  const { kd } = materialOf(one, input);
  const strength = largest(kd);
  return strength > 0 ? scale(1 / strength, kd) : [1, 1, 1];
}

const four = (v: Vec3): Vec3 => v.map((x) => Number(x.toFixed(4))) as Vec3;

/** The same strengths of ka and kd in another colour. */
export function withColor(one: Surface, input: InputReport | undefined, color: Vec3): Surface {
  const { ka, kd } = materialOf(one, input);
  const full = scale(1 / (largest(color) || 1), color);
  return { ...one, kd: four(scale(largest(kd), full)), ka: four(scale(largest(ka), full)) };
}

/** A coefficient of that strength, in its own colour, or in `color` where it has none. */
export function ofStrength(value: Vec3, strength: number, color: Vec3): Vec3 {
  const now = largest(value);
  return four(scale(strength, now > 0 ? scale(1 / now, value) : color));
}
