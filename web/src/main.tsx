import './style.css';
import { computed, effect, useSignal } from '@preact/signals';
import { render } from 'preact';
import { Section } from './controls';
import { token } from './connection';
import { ExplainPanel } from './explain_panel';
import { openDropped } from './files';
import { HintLines } from './hint_lines';
import { Help } from './help';
import { listenToKeys } from './keys';
import { LampPanel, PlaceRow } from './lamp_panel';
import { LightPanel } from './light_panel';
import { dismiss, notes } from './notes';
import { Picture } from './picture';
import { connection } from './server';
import { connected, explained, frame, hello, refining } from './state';
import { SurfacePanel } from './surface_panel';
import { TopBar } from './top_bar';
import { ViewPanel } from './view_panel';

const sections = [
  { id: 'lamp', title: 'Lamp', panel: LampPanel, open: true },
  { id: 'surface', title: 'Surface', panel: SurfacePanel, open: true },
  { id: 'light', title: 'Light', panel: LightPanel, open: false },
  { id: 'view', title: 'View', panel: ViewPanel, open: false },
  { id: 'explain', title: 'Explain', panel: ExplainPanel, open: false },
];

const showSection = (id: string): void => {
  const section = document.querySelector<HTMLDetailsElement>(`#${id}-section`);
  if (!section) return;
  section.open = true;
  // Once it has its height.
  requestAnimationFrame(() => section.scrollIntoView({ block: 'start' }));
};

function Dock() {
  const raised = useSignal(false);
  return (
    <aside class={raised.value ? 'dock raised' : 'dock'} aria-label="Controls">
      <div class="first-row">
        <PlaceRow axis={0} id="lamp-x-first" />
      </div>
      <nav class="tabs" aria-label="Parts of the controls">
        {sections.map(({ id, title }) => (
          <button
            key={id}
            type="button"
            onClick={() => {
              raised.value = true;
              showSection(id);
            }}
          >
            {title}
          </button>
        ))}
        <button
          type="button"
          aria-expanded={raised.value}
          aria-label={raised.value ? 'Lower the controls' : 'Raise the controls'}
          onClick={() => {
            raised.value = !raised.value;
          }}
        >
          {raised.value ? '▾' : '▴'}
        </button>
      </nav>
      <div class="sections">
        {sections.map(({ id, title, panel: Panel, open }) => (
          <Section key={id} id={`${id}-section`} title={title} open={open}>
            <Panel />
          </Section>
        ))}
      </div>
    </aside>
  );
}

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

/** Whether the picture is the exact one; a long way there can be cut short. */
function Settling({ settled }: { settled: boolean }) {
  const progress = refining.value;
  const stopped = useSignal(false);
  if (settled) return <span>settled</span>;
  if (!progress) return <span>{stopped.value ? 'coarse: refining was stopped' : 'refining'}</span>;
  return (
    <span>
      refining: {progress.label} {Math.round(100 * progress.share)} %{' '}
      <button
        type="button"
        class="stop"
        onClick={() => {
          connection.stop();
          refining.value = null;
          stopped.value = true;
        }}
      >
        Stop
      </button>
    </span>
  );
}

function Status() {
  const now = frame.value;
  if (!token) return <footer class="status">Open the whole URL that isolux view printed, with its # part.</footer>;
  if (!connected.value) {
    return <footer class="status">{hello.value ? 'The server is away; waiting for it…' : 'Connecting…'}</footer>;
  }
  if (!now) return <footer class="status">Drawing…</footer>;
  const ms = (value: number) => value.toFixed(value < 10 ? 1 : 0) + ' ms';
  return (
    <footer class="status" data-settled={now.settled} data-frame={now.id}
      data-counters={JSON.stringify(now.counters)}>
      <span>
        {now.size[0]} × {now.size[1]}
      </span>
      {now.ms.light > 0.05 && <span>lit in {ms(now.ms.light)}</span>}
      {now.ms.trace > 0.05 && <span>traced in {ms(now.ms.trace)}</span>}
      <Settling settled={now.settled} />
    </footer>
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
