import { ColorField, NumberRow } from './controls';
import { Histogram } from './histogram';
import { newSurface, type InputReport, type Surface, type Vec3 } from './scene';
import { edit, edited, editScene, editSurface, honours, inputs, mainInput, scene, surface } from './state';
import { largest, scale } from './vectors';

/** The colour of a surface is that of its diffuse coefficient at full strength. */
export const colorOf = (one: Surface): Vec3 => {
  const strength = largest(one.kd);
  return strength > 0 ? scale(1 / strength, one.kd) : [1, 1, 1];
};

const four = (v: Vec3): Vec3 => v.map((x) => Number(x.toFixed(4))) as Vec3;

/** The same strengths of ka and kd in another colour. */
const withColor = (one: Surface, color: Vec3): Surface => {
  const full = scale(1 / (largest(color) || 1), color);
  return { ...one, kd: four(scale(largest(one.kd), full)), ka: four(scale(largest(one.ka), full)) };
};

const withStrength = (one: Surface, key: 'ka' | 'kd' | 'ks' | 'kr', strength: number): Surface => {
  const now = largest(one[key]);
  const color: Vec3 = now > 0 ? scale(1 / now, one[key]) : key === 'ks' || key === 'kr' ? [1, 1, 1] : colorOf(one);
  return { ...one, [key]: four(scale(strength, color)) };
};

const coefficients = [
  { key: 'ka', label: 'ka ambient', hint: 'ka Ia: light that comes evenly from everywhere' },
  { key: 'kd', label: 'kd diffuse', hint: 'kd I max(0, n · l): Lambert’s term, matt' },
  { key: 'ks', label: 'ks specular', hint: 'ks I max(0, r · e)ˢ: Phong’s highlight' },
  { key: 'kr', label: 'kr mirror', hint: 'kr times what the mirrored eye ray sees' },
] as const;

export const inputOf = (one: Surface): InputReport | undefined => {
  const name = scene.value?.input[(one.input ?? 1) - 1];
  return inputs.value.find((input) => input.input === name) ?? mainInput.value;
};

/** "bone", "skin", or "iso 300". */
export function nameOf(one: Surface): string {
  const input = inputOf(one);
  const at = input?.suggested_iso.indexOf(one.iso) ?? -1;
  return input?.suggested_iso_names[at] ?? 'custom';
}

function addSurface(): void {
  const list = scene.value?.surface ?? [];
  const input = mainInput.value;
  if (!input) return;
  const taken = list.map((one) => one.iso);
  const fresh = input.suggested_iso.find((iso) => !taken.includes(iso));
  const iso = fresh ?? Math.round(((list.at(-1)?.iso ?? 0) + input.max) / 2);
  editScene('', (old) => ({ ...old, surface: [...old.surface, { ...newSurface, iso }] }));
  surface.value = list.length;
}

function removeSurface(n: number): void {
  edit('', (now) => ({
    ...now,
    scene: { ...now.scene, surface: now.scene.surface.filter((_, at) => at !== n) },
    hidden: now.hidden.filter((at) => at !== n).map((at) => (at > n ? at - 1 : at)),
  }));
  surface.value = Math.max(0, n - 1);
}

const toggleHidden = (n: number): void =>
  edit('', (now) => ({
    ...now,
    hidden: now.hidden.includes(n) ? now.hidden.filter((at) => at !== n) : [...now.hidden, n],
  }));

function Surfaces({ list }: { list: Surface[] }) {
  const hidden = edited.value?.hidden ?? [];
  const visible = list.length - hidden.length;
  return (
    <ul class="surfaces" aria-label="Surfaces">
      {list.map((one, n) => {
        const isHidden = hidden.includes(n);
        return (
          <li key={n}>
            <button
              type="button"
              class="name"
              aria-pressed={n === surface.value}
              onClick={() => {
                surface.value = n;
              }}
            >
              {nameOf(one)} <small>{Math.round(one.iso * 100) / 100}</small>
            </button>
            <ColorField
              name={`Colour of surface ${n + 1}`}
              value={colorOf(one)}
              onChange={(color) => editSurface('color', n, (old) => withColor(old, color))}
            />
            <button
              type="button"
              aria-pressed={isHidden}
              disabled={!isHidden && visible === 1}
              onClick={() => toggleHidden(n)}
            >
              {isHidden ? 'Show' : 'Hide'}
            </button>
            <button type="button" disabled={list.length === 1} onClick={() => removeSurface(n)}
              aria-label={`Remove surface ${n + 1}`}>
              ×
            </button>
          </li>
        );
      })}
    </ul>
  );
}

export function SurfacePanel() {
  const list = scene.value?.surface ?? [];
  const n = surface.value;
  const one = list[n];
  const input = one && inputOf(one);
  if (!one || !input) return null;
  const step = (input.max - input.min) / 400;
  const setIso = (iso: number) =>
    editSurface('iso', n, (old) => ({
      ...old,
      iso: Math.min(input.max, Math.max(input.min, iso)),
    }));
  return (
    <>
      <Histogram list={list} input={input} onMove={(at, iso) => {
        surface.value = at;
        editSurface('iso', at, (old) => ({ ...old, iso }));
      }} />
      <NumberRow
        id="iso"
        label="iso value"
        hint="the surface lies where the volume has this value"
        value={one.iso}
        low={input.min}
        high={input.max}
        step={step > 1 ? Math.round(step) : step}
        unit={input.units ?? ''}
        usual={input.suggested_iso[0] ?? one.iso}
        onChange={setIso}
      />
      <div class="line" role="group" aria-label="Iso values worth trying">
        {input.suggested_iso.map((iso, at) => (
          <button key={iso} type="button" aria-pressed={one.iso === iso} onClick={() => setIso(iso)}>
            {input.suggested_iso_names[at]}
          </button>
        ))}
        <button type="button" onClick={addSurface}>
          Add surface
        </button>
      </div>
      <Surfaces list={list} />
      {coefficients
        .filter(({ key }) => honours('surface.' + key))
        .map(({ key, label, hint }) => (
          <NumberRow
            key={key}
            label={label}
            hint={hint}
            value={largest(one[key])}
            low={0}
            high={1}
            step={0.01}
            usual={largest(newSurface[key])}
            onChange={(value) => editSurface(key, n, (old) => withStrength(old, key, value))}
          />
        ))}
      <NumberRow
        label="shininess"
        hint="Phong’s exponent: the larger, the smaller the highlight"
        value={one.shininess}
        low={1}
        high={1000}
        step={1}
        logarithmic
        open
        usual={newSurface.shininess}
        onChange={(value) =>
          editSurface('shininess', n, (old) => ({ ...old, shininess: Math.max(0, value) }))
        }
      />
      {honours('surface.opacity') && (
        <NumberRow
          label="opacity"
          hint="how much of what lies behind it hides"
          value={one.opacity}
          low={0}
          high={1}
          step={0.01}
          usual={1}
          onChange={(opacity) => editSurface('opacity', n, (old) => ({ ...old, opacity }))}
        />
      )}
    </>
  );
}
