// Opening, saving and sharing.
import { batch } from '@preact/signals';
import { tell, tellError, withNote } from './notes';
import type { InputReport, Scene } from './scene';
import { connection, start } from './server';
import { beginWith, bounds, drawn, hello, inputs, pictureSize } from './state';
import { packed } from './tar';
import { download, type Opened, openFile, savedPicture, type Sent } from './transfer';

const mostSceneBytes = 256 << 10;

const startOf = (opened: Opened): void =>
  batch(() => {
    inputs.value = opened.inputs;
    bounds.value = opened.bounds;
    opening.set(opened.scene.input[0] ?? '', opened);
    start(opened.scene);
  });

/** How dropped files began, to go back to them. */
const opening = new Map<string, Opened>();

/** Several files are one scan: slices, a header with its voxels, a mesh with its textures. */
function sentOf(files: File[], folder: string | undefined): Sent {
  const [file, ...others] = files as [File, ...File[]];
  if (others.length === 0) return { bytes: file, name: file.name, isPacked: false };
  const name = folder || `${file.name} and ${others.length} more`;
  return { bytes: packed(files), name, isPacked: true };
}

/** @param folder  its name, where all of them came in one. */
export async function openFiles(files: File[], folder = files[0]?.webkitRelativePath.split('/')[0]): Promise<void> {
  const [file] = files;
  if (!file) return;
  if (files.length === 1 && file.name.endsWith('.json')) return loadScene(file);
  const sent = sentOf(files, folder);
  const opened = await withNote(`Opening ${sent.name}`, (progress, signal) => openFile(sent, progress, signal));
  if (!opened) return;
  startOf(opened);
  const report = opened.inputs.at(-1);
  for (const note of report?.notes ?? []) tell(`${report?.input}: ${note}`, 'news');
}

async function filesIn(entry: FileSystemEntry): Promise<File[]> {
  if (entry.isFile) {
    return [await new Promise<File>((resolve, reject) => (entry as FileSystemFileEntry).file(resolve, reject))];
  }
  const reader = (entry as FileSystemDirectoryEntry).createReader();
  const all: File[] = [];
  while (true) {
    // A reader gives a part of the entries at a time, and none when there are no more.
    const some = await new Promise<FileSystemEntry[]>((resolve, reject) => reader.readEntries(resolve, reject));
    if (some.length === 0) return all;
    all.push(...(await Promise.all(some.map(filesIn))).flat());
  }
}

/** Files and folders that were dropped on the page. */
export async function openDropped(data: DataTransfer): Promise<void> {
  const entries = [...data.items].map((item) => item.webkitGetAsEntry()).filter((one) => one !== null);
  const plain = [...data.files]; // both lists are gone once the event is over
  try {
    if (entries.length === 0) return await openFiles(plain);
    const files = (await Promise.all(entries.map(filesIn))).flat().filter(({ name }) => !name.startsWith('.'));
    const [only] = entries;
    if (files.length === 0) throw new Error(`${only?.name}: is an empty folder; drop one with a scan in it`);
    await openFiles(files, entries.length === 1 && only?.isDirectory ? only.name : undefined);
  } catch (error) {
    tellError(error);
  }
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
    start(said.scene);
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
    beginWith(scene);
    tell(`Loaded ${file.name}`, 'news');
  } catch (error) {
    tellError(error instanceof SyntaxError ? new Error(`${file.name}: is not valid JSON`) : error);
  }
}

export function savePicture(format: 'png' | 'exr', size: [number, number]): void {
  const scene = drawn.value;
  if (!scene) return;
  void withNote(`Drawing ${size[0]} × ${size[1]}`, async (progress, signal) => {
    const picture = await savedPicture({ ...scene, size }, format, progress, signal);
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
