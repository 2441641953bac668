import { defaultFov, usualFov, viewOf, withFov, withProjection } from './camera';
import { Choice, ColorField, NumberRow } from './controls';
import { fit } from './fit';
import { OptionControl } from './option_control';
import { type Scene, type Vec3, viewNames, type ViewName } from './scene';
import { editPose, editScene, pose, scene, surround } from './state';

/** A named view keeps the projection and, with perspective, the field of view. */
export function setView(view: ViewName): void {
  editScene('', (old) => {
    const projection = old.camera?.projection ?? 'perspective';
    const fov = projection === 'perspective' ? { fov: old.camera?.fov ?? defaultFov } : {};
    return { ...old, camera: { view, projection, ...fov } };
  });
  fit();
}

/** Moves the eye so that what is seen fills the window. */
export function fitHere(): void {
  editPose('', (old) => old);
  fit();
}

const backgrounds: { name: string; color: () => Vec3 }[] = [
  { name: 'grey', color: surround },
  { name: 'black', color: () => [0, 0, 0] },
  { name: 'white', color: () => [1, 1, 1] },
];

function Background({ now }: { now: Scene }) {
  const set = (background: Vec3) => editScene('background', (old) => ({ ...old, background }));
  return (
    <div class="line tight" role="group" aria-label="Background">
      <span class="label">background</span>
      {backgrounds.map(({ name, color }) => (
        <button key={name} type="button" onClick={() => set(color())}>
          {name}
        </button>
      ))}
      <ColorField name="Colour of the background" value={now.background} onChange={set} />
    </div>
  );
}

export function ViewPanel() {
  const now = scene.value;
  if (!now) return null;
  const projection = now.camera?.projection ?? 'perspective';
  return (
    <>
      <div class="grid3" role="group" aria-label="Named views">
        {viewNames.map((name, n) => (
          <button
            key={name}
            type="button"
            aria-pressed={viewOf(now.camera) === name}
            title={`key ${n + 1}`}
            onClick={() => setView(name)}
          >
            {name}
          </button>
        ))}
      </div>
      <div class="line">
        <Choice
          name="Projection"
          value={projection}
          choices={[
            { value: 'perspective', label: 'perspective' },
            { value: 'orthographic', label: 'orthographic', hint: 'without perspective, for measuring' },
          ]}
          onChange={(value) => editPose('', (old) => withProjection(old, value))}
        />
      </div>
      {projection === 'perspective' && (
        <NumberRow
          label="fov"
          name="Vertical field of view"
          hint="vertical field of view: wide near, narrow far; what is looked at keeps its size"
          value={pose()?.fov ?? defaultFov}
          low={5}
          high={120}
          step={1}
          unit="°"
          usual={usualFov}
          onChange={(fov) => editPose('fov', (old) => withFov(old, fov))}
        />
      )}
      <NumberRow
        label="exposure"
        hint="a factor on all light before it is shown"
        value={now.exposure}
        low={0.05}
        high={20}
        step={0.05}
        logarithmic
        open
        usual={1}
        onChange={(exposure) =>
          editScene('exposure', (old) => ({ ...old, exposure: Math.max(0, exposure) }))
        }
      />
      <div class="line">
        <Choice
          name="How light becomes a pixel"
          value={now.display}
          choices={[
            { value: 'srgb', label: 'sRGB', hint: 'as the eye expects it' },
            { value: 'raw', label: 'raw', hint: 'the number itself times 255, as in the lecture' },
          ]}
          onChange={(display) => editScene('', (old) => ({ ...old, display }))}
        />
      </div>
      <Background now={now} />
      <OptionControl name="visibility" label="found by" labels={{ raycast: 'rays', raster: 'rasteriser' }} />
      <div class="line">
        <button type="button" title="key F" onClick={fitHere}>
          Fit to window
        </button>
        <button type="button" title="key 1" onClick={() => setView('front')}>
          Reset view
        </button>
      </div>
    </>
  );
}
