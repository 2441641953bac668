import { defaultFov, withFov, withProjection } from './camera';
import { Choice, ColorField, NumberRow } from './controls';
import { type Scene, type Vec3, viewNames, type ViewName } from './scene';
import { editPose, editScene, pose, scene, surround } from './state';

/** A named view keeps the projection and, with perspective, the field of view. */
export function setView(view: ViewName): void {
  editScene('', (old) => {
    const projection = old.camera?.projection ?? 'perspective';
    const fov = projection === 'perspective' ? { fov: old.camera?.fov ?? defaultFov } : {};
    return { ...old, camera: { view, projection, ...fov } };
  });
}

const backgrounds: { name: string; color: () => Vec3 }[] = [
  { name: 'surround', color: surround },
  { name: 'black', color: () => [0, 0, 0] },
  { name: 'white', color: () => [1, 1, 1] },
];

function Background({ now }: { now: Scene }) {
  const set = (background: Vec3) => editScene('background', (old) => ({ ...old, background }));
  return (
    <div class="line" role="group" aria-label="Background">
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
            aria-pressed={now.camera?.view === name || (!now.camera && name === 'front')}
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
          usual={defaultFov}
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
        <button type="button" onClick={() => setView('front')}>
          Reset view
        </button>
      </div>
      <Background now={now} />
    </>
  );
}
