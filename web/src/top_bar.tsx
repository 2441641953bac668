import type { TargetedEvent } from 'preact';
import { useEffect, useRef } from 'preact/hooks';
import { Choice, Menu, MenuItem } from './controls';
import {
  copyCommand, goTo, loadScene, openFiles, saveHere, savePicture, saveScene, startAgain,
} from './files';
import { layerName, type InputReport, type Layer } from './scene';
import {
  edit, edited, hello, helpOpen, history, inputs, pictureSize, redo, scene, undo,
} from './state';
import { signal } from '@preact/signals';
import { toggleSplit } from './split';

const saveFormat = signal<'png' | 'exr'>('png');

const layers = (): Layer[] => hello.value?.layers ?? [];

export const setShow = (show: Layer): void => edit('', (now) => ({ ...now, show }));

const sizeOf = (input: InputReport): string =>
  input.kind === 'mesh' ? `${input.triangles} triangles` : input.dims.join(' × ');

function openChosen(event: TargetedEvent<HTMLInputElement>): void {
  void openFiles([...(event.currentTarget.files ?? [])]);
  event.currentTarget.value = '';
}

function FileMenu() {
  const file = useRef<HTMLInputElement>(null);
  const folder = useRef<HTMLInputElement>(null);
  const sceneFile = useRef<HTMLInputElement>(null);
  useEffect(() => {
    folder.current!.webkitdirectory = true; // which the types of JSX do not know
  }, []);
  const name = scene.value?.input.join(', ') ?? '';
  const shortName = name === 'example:ct-head' ? 'CT head (example)' : name.split('/').pop() || 'isolux';
  return (
    <>
      <Menu label={<span class="file-name">{shortName}</span>} name={`Scan: ${shortName}`}>
        {inputs.value.length > 1 &&
          inputs.value.map((input) => (
            <MenuItem
              key={input.input}
              chosen={scene.value?.input.includes(input.input) ?? false}
              hint={`${input.format}, ${sizeOf(input)}`}
              onChoose={() => goTo(input)}
            >
              {input.input}
            </MenuItem>
          ))}
        <MenuItem hint="DICOM, NIfTI, NRRD, MetaImage, TIFF, OBJ, PLY, STL, glTF; or drop it on the page" onChoose={() => file.current?.click()}>
          Open files…
        </MenuItem>
        <MenuItem hint="a DICOM series, or a stack of TIFFs" onChoose={() => folder.current?.click()}>
          Open a folder…
        </MenuItem>
        <MenuItem hint="a scene that was saved here, or by --save-scene" onChoose={() => sceneFile.current?.click()}>
          Load a scene…
        </MenuItem>
        <MenuItem hint="as isolux view began" onChoose={startAgain}>
          Start again
        </MenuItem>
      </Menu>
      <input ref={file} type="file" multiple hidden aria-label="Scan to open" data-testid="open-file"
        onChange={openChosen} />
      <input ref={folder} type="file" hidden aria-label="Folder to open" data-testid="open-folder"
        onChange={openChosen} />
      <input ref={sceneFile} type="file" accept=".json,application/json" hidden aria-label="Scene to load"
        data-testid="load-scene"
        onChange={(event) => {
          const chosen = event.currentTarget.files?.[0];
          if (chosen) void loadScene(chosen);
          event.currentTarget.value = '';
        }} />
    </>
  );
}

function ShowMenu() {
  const now = edited.value;
  return (
    <Menu label={<>Show<span class="wide">: {layerName(now?.show ?? 'picture')}</span></>}>
      {layers().map((layer) => (
        <MenuItem key={layer} chosen={now?.show === layer} onChoose={() => setShow(layer)}>
          {layerName(layer)}
        </MenuItem>
      ))}
    </Menu>
  );
}

function SplitControl() {
  const other = edited.value?.other ?? null;
  return (
    <>
      <button type="button" aria-pressed={other !== null} title="two at once, with a divider (/)" onClick={toggleSplit}>
        Split
      </button>
      {other && (
        <select
          aria-label="Right half of the split"
          value={other}
          onChange={(event) => {
            const layer = event.currentTarget.value as Layer;
            edit('', (now) => ({ ...now, other: layer }));
          }}
        >
          {layers().map((layer) => (
            <option key={layer} value={layer}>
              {layerName(layer)}
            </option>
          ))}
        </select>
      )}
    </>
  );
}

function SaveMenu() {
  const width = useRef<HTMLInputElement>(null);
  const height = useRef<HTMLInputElement>(null);
  const [w, h] = pictureSize.value;
  const format = saveFormat.value;
  return (
    <Menu label="Save">
      <div class="menu-line">
        <Choice
          name="Kind of picture"
          value={format}
          choices={[
            { value: 'png', label: 'PNG', hint: 'the picture as it is shown' },
            { value: 'exr', label: 'EXR', hint: 'all layers, linear, for measuring' },
          ]}
          onChange={(value) => {
            saveFormat.value = value;
          }}
        />
      </div>
      <MenuItem hint={`${w} × ${h} · Ctrl+S saves this as PNG`} onChoose={() => saveHere(format)}>
        As large as here
      </MenuItem>
      {[1024, 2048, 4096].map((side) => (
        <MenuItem key={side} onChoose={() => savePicture(format, [side, side])}>
          {side} × {side}
        </MenuItem>
      ))}
      <div class="menu-line">
        <input ref={width} type="number" min={1} max={32768} aria-label="Width in pixels" value={1920} />
        ×
        <input ref={height} type="number" min={1} max={32768} aria-label="Height in pixels" value={1080} />
        <button
          type="button"
          onClick={() =>
            savePicture(format, [width.current!.valueAsNumber, height.current!.valueAsNumber])
          }
        >
          Save
        </button>
      </div>
      <hr />
      <MenuItem hint="for --scene, or to load here again" onChoose={saveScene}>
        The scene as a file
      </MenuItem>
      <MenuItem hint="the isolux render that makes this picture" onChoose={copyCommand}>
        Copy as command
      </MenuItem>
    </Menu>
  );
}

export function TopBar() {
  const past = history.value?.past.length ?? 0;
  const future = history.value?.future.length ?? 0;
  return (
    <header class="top">
      <h1>isolux</h1>
      <FileMenu />
      <span class="space" />
      <button type="button" aria-label="Undo" title="Undo (Ctrl+Z)" disabled={past === 0} onClick={undo}>
        ↶
      </button>
      <button type="button" aria-label="Redo" title="Redo (Ctrl+Shift+Z)" disabled={future === 0} onClick={redo}>
        ↷
      </button>
      <span class="space" />
      <ShowMenu />
      <SplitControl />
      <SaveMenu />
      <button
        type="button"
        aria-label="Help: keys and gestures"
        title="Keys and gestures (?)"
        onClick={() => {
          helpOpen.value = true;
        }}
      >
        ?
      </button>
    </header>
  );
}
