import { CoefficientRow } from './coefficient_row';
import { ColorField, NumberRow } from './controls';
import { inputNumber } from './hidden';
import { Histogram } from './histogram';
import { colorOf, materialOf, withColor } from './materials';
import { newSurface, type InputReport, type Surface, type VolumeReport } from './scene';
import {
  edit, edited, editScene, editSurface, honours, inputs, mainVolume, reportOf, scene, surface,
} from './state';

export const inputOf = (one: Surface): InputReport | undefined => {
  const names = scene.value?.input ?? [];
  return reportOf(names[inputNumber(one, names, inputs.value)]);
};

/** "bone", "skin", "custom", or what the mesh is called. */
export function nameOf(one: Surface): string {
  const input = inputOf(one);
  if (input?.kind !== 'volume') return input?.input.split('/').pop() ?? 'mesh';
  const at = input.suggested_iso.indexOf(one.iso ?? NaN);
  return input.suggested_iso_names[at] ?? 'custom';
}

function addSurface(): void {
  const list = scene.value?.surface ?? [];
  const input = mainVolume.value;
  if (!input) return;
  const taken = list.map((one) => one.iso);
  const fresh = input.suggested_iso.find((iso) => !taken.includes(iso));
  const iso = fresh ?? Math.round(((list.at(-1)?.iso ?? 0) + input.max) / 2);
  editScene('', (old) => ({ ...old, surface: [...old.surface, { iso, ...newSurface }] }));
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
              {nameOf(one)} <small>{one.iso === undefined ? 'mesh' : Math.round(one.iso * 100) / 100}</small>
            </button>
            <ColorField
              name={`Colour of surface ${n + 1}`}
              value={colorOf(one, inputOf(one))}
              onChange={(color) => editSurface('color', n, (old) => withColor(old, inputOf(old), color))}
            />
            <button
              type="button"
              aria-pressed={isHidden}
              disabled={!isHidden && visible === 1}
              onClick={() => toggleHidden(n)}
            >
              {isHidden ? 'Show' : 'Hide'}
            </button>
            {one.iso !== undefined && (
              <button type="button" disabled={list.length === 1} onClick={() => removeSurface(n)}
                aria-label={`Remove surface ${n + 1}`}>
                ×
              </button>
            )}
          </li>
        );
      })}
    </ul>
  );
}

/** Where a surface of a volume lies. */
function IsoValue({ one, n, input, list }: { one: Surface; n: number; input: VolumeReport; list: Surface[] }) {
  const iso = one.iso ?? 0;
  const step = (input.max - input.min) / 400;
  const setIso = (to: number) =>
    editSurface('iso', n, (old) => ({ ...old, iso: Math.min(input.max, Math.max(input.min, to)) }));
  return (
    <>
      <Histogram list={list} input={input} onMove={(at, to) => {
        surface.value = at;
        editSurface('iso', at, (old) => ({ ...old, iso: to }));
      }} />
      <NumberRow
        id="iso"
        label="iso value"
        hint="the surface lies where the volume has this value"
        value={iso}
        low={input.min}
        high={input.max}
        step={step > 1 ? Math.round(step) : step}
        unit={input.units ?? ''}
        usual={input.suggested_iso[0] ?? iso}
        onChange={setIso}
      />
      <div class="line" role="group" aria-label="Iso values worth trying">
        {input.suggested_iso.map((suggested, at) => (
          <button key={suggested} type="button" aria-pressed={iso === suggested} onClick={() => setIso(suggested)}>
            {input.suggested_iso_names[at]}
          </button>
        ))}
        <button type="button" onClick={addSurface}>
          Add surface
        </button>
      </div>
    </>
  );
}

/** What a mesh file says of its material holds until something else is said here. */
function FileMaterial({ one, n, input }: { one: Surface; n: number; input: InputReport }) {
  if (input.kind !== 'mesh') return null;
  const { iso: _iso, input: number, ...said } = one;
  const many = input.colors || input.materials.length > 1 || input.materials.some(({ texture }) => texture);
  const isChanged = Object.keys(said).length > 0;
  if (!isChanged) {
    return many ? <p class="hint">The file has colours of its own; what you set here takes their place.</p> : null;
  }
  return (
    <div class="line">
      <button
        type="button"
        onClick={() => editSurface('', n, () => (number === undefined ? {} : { input: number }))}
      >
        Back to the file’s own material
      </button>
    </div>
  );
}

export function SurfacePanel() {
  const list = scene.value?.surface ?? [];
  const n = surface.value;
  const one = list[n];
  const input = one && inputOf(one);
  if (!one || !input) return null;
  const material = materialOf(one, input);
  const usual = materialOf({}, input);
  return (
    <>
      {input.kind === 'volume' && <IsoValue one={one} n={n} input={input} list={list} />}
      <Surfaces list={list} />
      {(['ka', 'kd', 'ks', 'kr'] as const)
        .filter((key) => honours('surface.' + key))
        .map((key) => (
          <CoefficientRow
            key={key}
            which={key}
            value={material[key]}
            usual={usual[key]}
            color={colorOf(one, input)}
            onChange={(to) => editSurface(key, n, (old) => ({ ...old, [key]: to }))}
          />
        ))}
      <NumberRow
        label="shininess"
        hint="Phong’s exponent: the larger, the smaller the highlight"
        value={material.shininess}
        low={1}
        high={1000}
        step={1}
        logarithmic
        open
        usual={usual.shininess}
        onChange={(value) =>
          editSurface('shininess', n, (old) => ({ ...old, shininess: Math.max(0, value) }))
        }
      />
      {honours('surface.opacity') && (
        <NumberRow
          label="opacity"
          hint="how much of what lies behind it hides"
          value={material.opacity}
          low={0}
          high={1}
          step={0.01}
          usual={1}
          onChange={(opacity) => editSurface('opacity', n, (old) => ({ ...old, opacity }))}
        />
      )}
      <FileMaterial one={one} n={n} input={input} />
    </>
  );
}
