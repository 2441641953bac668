// A control for an option of the scene, made of its row in the program's table of options. Where this
// version does not honour the option, there is none.
import { Choice, NumberRow } from './controls';
import type { Scene } from './scene';
import { editScene, hello, scene } from './state';

interface OptionControlProps {
  name: string;
  label: string;
  /** Other words for its choices. */
  labels?: Record<string, string>;
  /** What holds where the scene says nothing and the table has no default. */
  usual?: number;
  /** Where the slider ends; more may be typed. */
  usualHigh?: number;
  /** Options that are refused beside a value of this one. */
  drops?: (to: unknown) => string[];
}

/** @param drops  options that are refused beside this value. */
export const setOption = (name: string, to: unknown, about: string, drops: string[]): void =>
  editScene(about, (old) => {
    const changed: Scene = { ...old, [name]: to };
    for (const other of drops) delete changed[other];
    return changed;
  });

export function OptionControl({
  name, label, labels = {}, usual, usualHigh, drops = () => [],
}: OptionControlProps) {
  const option = hello.value?.options[name];
  const now = scene.value;
  if (!option || !now) return null;
  const value = now[name] ?? option.default ?? usual;
  const set = (to: unknown, about = '') => setOption(name, to, about, drops(to));
  if (option.choices.length === 2 && option.choices.includes('on')) {
    const on = value === 'on';
    return (
      <label class="check" title={option.sentence}>
        <input type="checkbox" checked={on} onChange={() => set(on ? 'off' : 'on')} />
        {label}
      </label>
    );
  }
  if (option.choices.length > 0) {
    return (
      <div class="line" title={option.sentence}>
        <span class="label">{label}</span>
        <Choice
          name={label}
          value={value as string}
          choices={option.choices.map((one) => ({ value: one, label: labels[one] ?? one }))}
          onChange={(to) => set(to)}
        />
      </div>
    );
  }
  const low = option.low ?? 0;
  return (
    <NumberRow
      label={label}
      hint={option.sentence}
      value={typeof value === 'number' ? value : low}
      low={low}
      high={usualHigh ?? option.high ?? 1}
      step={1}
      open={usualHigh !== undefined}
      unit={option.unit}
      usual={typeof option.default === 'number' ? option.default : (usual ?? low)}
      onChange={(to) => set(Math.min(option.high ?? to, Math.max(low, Math.round(to))), name)}
    />
  );
}
