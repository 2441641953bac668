// ka, kd, ks or kr: its strength on a slider, and each channel for itself in a menu beside it.
import { hexOf } from './colors';
import { ColorField, Menu, NumberRow } from './controls';
import { type Coefficient, ofStrength } from './materials';
import type { Vec3 } from './scene';
import { largest, scale } from './vectors';

const words: Record<Coefficient, { label: string; hint: string }> = {
  ka: { label: 'ka ambient', hint: 'ka Ia: light that comes evenly from everywhere' },
  kd: { label: 'kd diffuse', hint: 'kd I max(0, n · l): Lambert’s term, matt' },
  ks: { label: 'ks specular', hint: 'ks I max(0, r · e)ˢ: Phong’s highlight' },
  kr: { label: 'kr mirror', hint: 'kr times what the mirrored eye ray sees' },
};

export function CoefficientRow(props: {
  which: Coefficient;
  value: Vec3;
  usual: Vec3;
  /** The surface's, for what is matt and has no colour yet. */
  color: Vec3;
  onChange: (value: Vec3) => void;
}) {
  const { which, value, onChange } = props;
  const { label, hint } = words[which];
  const isMatt = which === 'ka' || which === 'kd';
  const strength = largest(value);
  const full = ofStrength(value, 1, isMatt ? props.color : [1, 1, 1]);
  return (
    <div class="with-color">
      <NumberRow
        label={label}
        hint={hint}
        value={strength}
        low={0}
        high={1}
        step={0.01}
        usual={largest(props.usual)}
        onChange={(to) => onChange(ofStrength(value, to, full))}
      />
      <Menu
        class="swatch-button"
        name={`${label} in each channel`}
        label={<span class="swatch" style={{ background: hexOf(full) }} />}
      >
        <div class="channels">
          <p class="hint">{hint}</p>
          {(['R', 'G', 'B'] as const).map((name, c) => (
            <NumberRow
              key={name}
              label={name}
              name={`${label}, ${name}`}
              value={value[c] ?? 0}
              low={0}
              high={1}
              step={0.01}
              usual={props.usual[c] ?? 0}
              onChange={(to) => onChange(value.map((v, at) => (at === c ? to : v)) as Vec3)}
            />
          ))}
          <div class="line">
            <ColorField
              name={`${label}, its colour`}
              value={full}
              onChange={(color) => onChange(ofStrength(scale(1 / (largest(color) || 1), color), strength, color))}
            />
            <span class="hint">colour at this strength</span>
          </div>
        </div>
      </Menu>
    </div>
  );
}
