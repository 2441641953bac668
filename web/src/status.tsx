// The line that says what the picture is, and how far it is. On a phone it shows only while it has
// something to tell, over the picture.
import { effect, signal } from '@preact/signals';
import { token } from './connection';
import { connection, wish } from './server';
import { connected, drawn, frame, hello, refining } from './state';

/** Whether what is shown stays coarse, since somebody has said so. */
const stopped = signal(false);
effect(() => {
  void [frame.value, drawn.value]; // what comes next is another matter
  stopped.value = false;
});

function stop(): void {
  connection.stop();
  refining.value = null;
  stopped.value = true;
}

function goOn(): void {
  stopped.value = false;
  wish();
}

/** Whether the picture is the exact one; a long way there can be cut short, and gone on with. */
function Settling({ settled }: { settled: boolean }) {
  const progress = refining.value;
  if (settled) return <span>settled</span>;
  if (stopped.value) {
    return (
      <span class="refining">
        coarse: refining was stopped
        <button type="button" onClick={goOn}>
          Go on
        </button>
      </span>
    );
  }
  if (!progress) return <span>refining</span>;
  return (
    <span class="refining">
      refining: {progress.label} {Math.round(100 * progress.share)} %
      <progress max={1} value={progress.share} aria-label="Refining" />
      <button type="button" onClick={stop}>
        Stop
      </button>
    </span>
  );
}

export function Status() {
  const now = frame.value;
  const say = (text: string) => <footer class="status telling">{text}</footer>;
  if (!token) return say('Open the whole URL that isolux view printed, with its # part.');
  if (!connected.value) return say(hello.value ? 'The server is away; waiting for it…' : 'Connecting…');
  if (!now) return say('Drawing…');
  const ms = (value: number) => value.toFixed(value < 10 ? 1 : 0) + ' ms';
  return (
    <footer class={refining.value || stopped.value ? 'status telling' : 'status'} data-settled={now.settled}
      data-frame={now.id} data-counters={JSON.stringify(now.counters)}>
      <span class="figures">
        {now.size[0]} × {now.size[1]}
      </span>
      {now.ms.light > 0.05 && <span class="figures">lit in {ms(now.ms.light)}</span>}
      {now.ms.trace > 0.05 && <span class="figures">traced in {ms(now.ms.trace)}</span>}
      <Settling settled={now.settled} />
    </footer>
  );
}
