// Short notes over the picture: what happened, why, and what to do.
import { signal } from '@preact/signals';

export interface Note {
  id: number;
  text: string;
  kind: 'error' | 'news' | 'work';
  /** Of work: the share that is done, and how to end it. */
  share?: number;
  cancel?: () => void;
}

export const notes = signal<Note[]>([]);

const newsLast_ms = 6000;
let lastId = 0;

export function dismiss(id: number): void {
  notes.value = notes.value.filter((note) => note.id !== id);
}

/** The note's number. The same text is not shown twice. */
export function tell(text: string, kind: 'error' | 'news'): number {
  const id = ++lastId;
  notes.value = [...notes.value.filter((note) => note.text !== text), { id, text, kind }].slice(-4);
  if (kind === 'news') setTimeout(() => dismiss(id), newsLast_ms);
  return id;
}

export const tellError = (error: unknown): void => {
  if (error instanceof DOMException && error.name === 'AbortError') return;
  tell(error instanceof Error ? error.message : String(error), 'error');
};

/** Shows a piece of work while it lasts, with a way to end it, and tells what went wrong. */
export async function withNote<Result>(
  text: string,
  work: (progress: (share: number, label?: string) => void, signal: AbortSignal) => Promise<Result>,
): Promise<Result | undefined> {
  const id = ++lastId;
  const controller = new AbortController();
  const update = (share?: number, label?: string) => {
    const said = label ? `${text}: ${label}` : text;
    const note: Note = { id, text: said, kind: 'work', cancel: () => controller.abort() };
    if (share !== undefined) note.share = share;
    notes.value = [...notes.value.filter((one) => one.id !== id), note];
  };
  update();
  try {
    return await work(update, controller.signal);
  } catch (error) {
    tellError(error);
    return undefined;
  } finally {
    dismiss(id);
  }
}
