// Controls that panels are made of: the browser's own, put together and named.
import type { ComponentChildren } from 'preact';
import { useId, useRef } from 'preact/hooks';
import { hexOf, linearOf } from './colors';
import type { Vec3 } from './scene';
import { tidy } from './vectors';

interface NumberRowProps {
  label: string;
  /** What a screen reader says, where the label alone would not do. */
  name?: string;
  hint?: string;
  value: number;
  low: number;
  high: number;
  step: number;
  unit?: string;
  /** Where double-click and Backspace lead. */
  usual?: number;
  /** Equal ways are equal factors; `low` must be above 0. */
  logarithmic?: boolean;
  /** A lamp's: in the lamp's colour. */
  warm?: boolean;
  /** Numbers outside of the slider's range may be typed. */
  open?: boolean;
  id?: string;
  onChange: (value: number) => void;
}

const sliderSteps = 1000;
const finely = 0.1;

/** A number with its label, unit, slider and field. */
export function NumberRow(row: NumberRowProps) {
  const ownId = useId();
  const id = row.id ?? ownId;
  const grip = useRef<{ from: number; shift: boolean } | null>(null);
  const toSlider = (v: number) =>
    row.logarithmic
      ? (sliderSteps * Math.log(Math.max(v, row.low) / row.low)) / Math.log(row.high / row.low)
      : v;
  const fromSlider = (s: number) =>
    row.logarithmic ? Number((row.low * (row.high / row.low) ** (s / sliderSteps)).toPrecision(3)) : s;
  const reset = () => row.usual !== undefined && row.onChange(row.usual);

  const slide = (slider: HTMLInputElement) => {
    const raw = slider.valueAsNumber;
    const held = grip.current;
    if (!held?.shift) return row.onChange(fromSlider(raw));
    const fine = held.from + finely * (raw - held.from);
    slider.value = String(fine);
    row.onChange(tidy(fromSlider(fine)));
  };
  const name = row.name ?? row.label;
  const share = (toSlider(row.value) - (row.logarithmic ? 0 : row.low)) /
    (row.logarithmic ? sliderSteps : row.high - row.low);
  return (
    <div
      class={'number-row' + (row.warm ? ' warm' : '') + (row.label.length === 1 ? ' wide' : '')}
      title={row.hint}
    >
      <label for={id} onDblClick={reset}>
        {row.label}
      </label>
      <input
        id={id}
        type="range"
        aria-label={name}
        min={row.logarithmic ? 0 : row.low}
        max={row.logarithmic ? sliderSteps : row.high}
        step={row.logarithmic ? 1 : row.step}
        value={toSlider(row.value)}
        style={{ '--share': String(Math.min(1, Math.max(0, share))) }}
        aria-valuetext={`${tidy(row.value)}${row.unit ? ' ' + row.unit : ''}`}
        onInput={(event) => slide(event.currentTarget)}
        onPointerDown={(event) => {
          grip.current = { from: toSlider(row.value), shift: event.shiftKey };
        }}
        onPointerMove={(event) => {
          if (grip.current) grip.current.shift = event.shiftKey;
        }}
        onPointerUp={() => {
          grip.current = null;
        }}
        onDblClick={reset}
        onKeyDown={(event) => {
          if (event.key === 'Backspace') reset();
        }}
      />
      <input
        type="number"
        aria-label={name + ', as a number'}
        min={row.open ? undefined : row.low}
        max={row.open ? undefined : row.high}
        step="any"
        value={tidy(row.value)}
        onChange={(event) => {
          const typed = event.currentTarget.valueAsNumber;
          if (!Number.isFinite(typed)) event.currentTarget.value = String(row.value);
          else row.onChange(row.open ? typed : Math.min(row.high, Math.max(row.low, typed)));
        }}
        onKeyDown={(event) => {
          const steps = { ArrowUp: 1, ArrowDown: -1 }[event.key];
          if (!steps) return;
          event.preventDefault();
          const by = row.step * (event.shiftKey ? finely : 1) * steps;
          const next = row.logarithmic ? fromSlider(toSlider(row.value) + 10 * steps) : row.value + by;
          row.onChange(row.open ? tidy(next) : Math.min(row.high, Math.max(row.low, tidy(next))));
        }}
      />
      <span class="unit">{row.unit}</span>
    </div>
  );
}

/** A linear colour, as the browser's own field for colours shows it. */
export function ColorField(props: { name: string; value: Vec3; onChange: (color: Vec3) => void }) {
  return (
    <input
      type="color"
      aria-label={props.name}
      title={props.name}
      value={hexOf(props.value)}
      onInput={(event) => props.onChange(linearOf(event.currentTarget.value))}
    />
  );
}

/** One of a few, all of which are seen. */
export function Choice<Value extends string>(props: {
  name: string;
  value: Value | undefined;
  choices: readonly { value: Value; label: string; hint?: string }[];
  onChange: (value: Value) => void;
}) {
  const group = useId();
  return (
    <div class="choice" role="radiogroup" aria-label={props.name}>
      {props.choices.map(({ value, label, hint }) => (
        <label key={value} title={hint}>
          <input
            type="radio"
            name={group}
            checked={value === props.value}
            onChange={() => props.onChange(value)}
          />
          <span>{label}</span>
        </label>
      ))}
    </div>
  );
}

/** A button with a panel below it that closes by itself. */
export function Menu(props: {
  label: ComponentChildren;
  name?: string;
  class?: string;
  children: ComponentChildren;
}) {
  const id = useId();
  const button = useRef<HTMLButtonElement>(null);
  const panel = useRef<HTMLDivElement>(null);
  const place = () => {
    if (!button.current || !panel.current) return;
    const at = button.current.getBoundingClientRect();
    const { offsetWidth, offsetHeight } = panel.current;
    const left = Math.max(8, Math.min(at.left, innerWidth - offsetWidth - 8));
    const below = at.bottom + 4 + offsetHeight <= innerHeight;
    panel.current.style.left = `${left}px`;
    panel.current.style.top = `${below ? at.bottom + 4 : Math.max(8, at.top - 4 - offsetHeight)}px`;
  };
  return (
    <>
      <button ref={button} type="button" class={props.class} popovertarget={id} aria-label={props.name}>
        {props.label}
        <span class="caret" aria-hidden="true" />
      </button>
      <div
        id={id}
        ref={panel}
        class="menu"
        popover="auto"
        onToggle={place}
        onClick={(event) => {
          const item = (event.target as Element).closest('button');
          if (item && !item.hasAttribute('data-stays')) panel.current?.hidePopover();
        }}
      >
        {props.children}
      </div>
    </>
  );
}

export function MenuItem(props: {
  children: ComponentChildren;
  hint?: string | undefined;
  chosen?: boolean;
  onChoose: () => void;
}) {
  return (
    <button
      type="button"
      class="item"
      aria-pressed={props.chosen}
      onClick={props.onChoose}
    >
      <span>{props.children}</span>
      {props.hint && <small>{props.hint}</small>}
    </button>
  );
}
