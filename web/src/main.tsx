import './style.css';
import { computed, effect, useSignal } from '@preact/signals';
import { render } from 'preact';
import { Dock, showSection } from './dock';
import { openDropped } from './files';
import { HandBar } from './hand_bar';
import { Help } from './help';
import { HintLines } from './hint_lines';
import { listenToKeys } from './keys';
import { dismiss, notes } from './notes';
import { Picture } from './picture';
import { explained } from './state';
import { Status } from './status';
import { TopBar } from './top_bar';

function Notes() {
  return (
    <div class="notes" role="status" aria-live="polite">
      {notes.value.map((note) => (
        <div key={note.id} class={'note ' + note.kind}>
          <span>{note.text}</span>
          {note.kind === 'work' && <progress max={1} value={note.share} aria-label={note.text} />}
          <button type="button" onClick={note.cancel ?? (() => dismiss(note.id))}>
            {note.cancel ? 'Cancel' : 'Close'}
          </button>
        </div>
      ))}
    </div>
  );
}

function Page() {
  const dropping = useSignal(false);
  return (
    <div
      class={dropping.value ? 'page dropping' : 'page'}
      onDragOver={(event) => {
        event.preventDefault();
        dropping.value = true;
      }}
      onDragLeave={(event) => {
        if (event.relatedTarget === null) dropping.value = false;
      }}
      onDrop={(event) => {
        event.preventDefault();
        dropping.value = false;
        if (event.dataTransfer) void openDropped(event.dataTransfer);
      }}
    >
      <TopBar />
      <main class="stage">
        <Picture />
        <HandBar />
        <HintLines />
        <Notes />
        {dropping.value && <p class="drop-hint">Drop a scan or a mesh: a file, several, or a folder</p>}
      </main>
      <Dock />
      <Status />
      <Help />
    </div>
  );
}

const hasExplanation = computed(() => explained.value !== null);
effect(() => {
  if (hasExplanation.value) showSection('explain');
});
listenToKeys();
render(<Page />, document.getElementById('page')!);
