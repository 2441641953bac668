// What is hidden is not drawn, but stays in the state.
import type { InputReport, Light, Scene, Surface } from './scene';
import { worldOfIndex } from './lamps';

/** Which input a surface belongs to, counted from 0: without a word, the first volume. */
export function inputNumber(one: Surface | Light, names: string[], reports: InputReport[]): number {
  if (one.input) return one.input - 1;
  const isVolume = (name: string) =>
    reports.some((report) => report.input === name && report.kind === 'volume');
  return Math.max(0, names.findIndex(isVolume));
}

/**
 * The scene without its hidden surfaces. An input of which nothing is left to be seen goes too: a
 * mesh is drawn whether it is named or not, and so is a volume where no volume's surface is.
 */
export function withoutHidden(scene: Scene, hidden: number[], reports: InputReport[]): Scene {
  if (hidden.length === 0) return scene;
  const of = (one: Surface | Light) => inputNumber(one, scene.input, reports);
  const left = scene.surface.filter((_, n) => !hidden.includes(n));
  const gone = scene.surface.filter((_, n) => hidden.includes(n)).map(of);
  const kept = scene.input.map((_, n) => n).filter((n) => !gone.includes(n) || left.some((one) => of(one) === n));
  const numbered = (one: Surface): Surface => ({ ...one, input: kept.indexOf(of(one)) + 1 });
  const placed = (one: Light): Light => {
    if (one.space !== 'index') return one;
    const at = of(one);
    if (kept.includes(at)) return { ...one, input: kept.indexOf(at) + 1 };
    const report = reports.find(({ input }) => input === scene.input[at]);
    return report?.kind === 'volume' ? worldOfIndex(one, report) : one;
  };
  return {
    ...scene,
    input: kept.map((n) => scene.input[n]!),
    surface: left.map(numbered),
    light: scene.light.map(placed),
  };
}
