// Opening, saving and sharing.
import { batch } from '@preact/signals';
import { tell, tellError, withNote } from './notes';
import type { InputReport, Scene } from './scene';
import { connection, withSurround } from './server';
import { beginWith, bounds, drawn, hello, inputs, pictureSize } from './state';
import { download, type Opened, openFile, savedPicture } from './transfer';

const mostSceneBytes = 256 << 10;

const startOf = (opened: Opened): void =>
  batch(() => {
    inputs.value = opened.inputs;
    bounds.value = opened.bounds;
    opening.set(opened.scene.input[0] ?? '', opened);
    beginWith(withSurround(opened.scene));
  });

/** How dropped files began, to go back to them. */
const opening = new Map<string, Opened>();

export async function openFiles(files: File[]): Promise<void> {
  const [file, ...others] = files;
  if (!file) return;
  if (others.length > 0) {
    tell(`${files.length} files: one at a time is opened; put a series of slices into one zip`, 'error');
    return;
  }
  if (file.name.endsWith('.json')) return loadScene(file);
  const opened = await withNote(`Opening ${file.name}`, (progress, signal) =>
    openFile(file, progress, signal),
  );
  if (!opened) return;
  startOf(opened);
  const report = opened.inputs.at(-1);
  for (const note of report?.notes ?? []) tell(`${file.name}: ${note}`, 'news');
}

/** Goes back to an input that is open. */
export function goTo(input: InputReport): void {
  const opened = opening.get(input.input);
  if (opened) startOf({ ...opened, inputs: inputs.value });
  else startAgain();
}

export function startAgain(): void {
  const said = hello.value;
  if (!said) return;
  batch(() => {
    bounds.value = said.bounds;
    beginWith(withSurround(said.scene));
  });
}

export async function loadScene(file: File): Promise<void> {
  try {
    if (file.size > mostSceneBytes) throw new Error(`${file.name}: is too large for a scene`);
    const read = JSON.parse(await file.text()) as Scene;
    // A scene without inputs is about whatever is open.
    const input = read.input?.length ? read.input : (drawn.value?.input ?? []);
    const { scene } = await connection.describe({ ...read, input });
    if (!scene.light) scene.light = [];
    if (!scene.surface?.length) throw new Error(`${file.name}: names no surface; add "surface"`);
    beginWith(scene);
    tell(`Loaded ${file.name}`, 'news');
  } catch (error) {
    tellError(error instanceof SyntaxError ? new Error(`${file.name}: is not valid JSON`) : error);
  }
}

export function savePicture(format: 'png' | 'exr', size: [number, number]): void {
  const scene = drawn.value;
  if (!scene) return;
  void withNote(`Drawing ${size[0]} × ${size[1]}`, async (_, signal) => {
    const picture = await savedPicture({ ...scene, size }, format, signal);
    download(picture, `isolux.${format}`);
  });
}

export const saveHere = (format: 'png' | 'exr'): void => savePicture(format, pictureSize.value);

export async function saveScene(): Promise<void> {
  try {
    if (!drawn.value) return;
    const { scene } = await connection.describe(drawn.value);
    download(new Blob([JSON.stringify(scene, null, 2) + '\n'], { type: 'application/json' }), 'isolux.json');
  } catch (error) {
    tellError(error);
  }
}

export async function copyCommand(): Promise<void> {
  try {
    if (!drawn.value) return;
    const { command } = await connection.describe(drawn.value);
    await navigator.clipboard.writeText(`${command} -o picture.png`);
    tell('Copied the command', 'news');
  } catch (error) {
    tellError(error);
  }
}
