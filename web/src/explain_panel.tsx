import { useEffect, useRef } from 'preact/hooks';
import type { Explanation, LightExplanation } from './connection';
import { askAbout, stopExplaining } from './explain';
import { fixed, shortNumber } from './numbers';
import { tell } from './notes';
import type { Layer, Scene, Vec3 } from './scene';
import { drawn, explained, lamp, peek } from './state';

const channels = ['R', 'G', 'B'] as const;

/** Fetched when the first formula is shown: it is larger than all the rest of the page. */
const katex = () => import('./katex').then((module) => module.default);

/** Set by KaTeX into the element itself: as text, its styles would not pass the content policy. */
function Formula({ tex, name }: { tex: string; name?: string }) {
  const place = useRef<HTMLDivElement>(null);
  useEffect(() => {
    void katex().then(({ render }) => {
      if (place.current) render(tex, place.current, { throwOnError: false, output: 'html' });
    });
  }, [tex]);
  return <div class="formula" role="img" aria-label={name ?? 'formula'} ref={place} />;
}

/** In the colour that the term has everywhere on the page. */
const tinted = (term: string, tex: string): string => {
  const color = getComputedStyle(document.documentElement).getPropertyValue('--' + term).trim();
  return String.raw`\textcolor{${color}}{${tex}}`;
};

const n3 = (value: number): string => fixed(value).replace('−', '-');

interface Term {
  layer: Layer | null;
  name: string;
  kind: string;
  value: Vec3;
}

function terms(why: Explanation): Term[] {
  const sum = (key: 'diffuse' | 'specular'): Vec3 =>
    why.lights.reduce<Vec3>(
      (all, one) => [all[0] + one[key][0], all[1] + one[key][1], all[2] + one[key][2]],
      [0, 0, 0],
    );
  const all: Term[] = [
    { layer: 'ambient', name: 'ambient', kind: 'ambient', value: why.ambient },
    { layer: 'diffuse', name: 'diffuse', kind: 'diffuse', value: sum('diffuse') },
    { layer: 'specular', name: 'specular', kind: 'specular', value: sum('specular') },
    { layer: 'indirect', name: 'indirect', kind: 'indirect', value: why.indirect },
    { layer: 'mirror', name: 'mirror', kind: 'mirror', value: why.mirror },
    { layer: null, name: 'background', kind: 'background', value: why.background },
  ];
  return all.filter(({ value }, n) => n < 3 || value.some((v) => v !== 0));
}

/** What comes from everywhere: the ambient term, or what has been computed in its place. */
function evenLight(why: Explanation, material: { ka: Vec3; kd: Vec3 }, c: number): string {
  if (!why.bounces) {
    return tinted('ambient', `${n3(material.ka[c] ?? 0)} \\cdot ${n3(why.ambient_light[c] ?? 0)}`);
  }
  const e = why.bounces.reduce((sum, one) => sum + (one[c] ?? 0), 0);
  return tinted('indirect', `${n3(material.kd[c] ?? 0)} \\cdot ${n3(e)}`);
}

/** The sums of one lamp in one channel, with the numbers put in. */
function numbersPutIn(
  why: Explanation,
  one: LightExplanation,
  scene: Scene,
  c: number,
  name: string,
): string {
  const { material } = why;
  const nearest = why.layers[0];
  if (!material || !nearest) return '';
  const light = scene.light[lamp.value];
  const intensity = light ? light.intensity * (light.color[c] ?? 0) : 1;
  const share = one.falloff * one.visibility;
  const factor = share === 1 ? '' : ` \\cdot ${n3(share)}`;
  const phong =
    one.cos_theta > 0 ? `${n3(Math.max(0, one.cos_phi))}^{${material.shininess}}` : '0';
  return String.raw`\begin{aligned}
    I_{\mathrm{${name}}} ={}& ${evenLight(why, material, c)}
    + ${tinted('diffuse', `${n3(material.kd[c] ?? 0)} \\cdot ${n3(intensity)} \\cdot ${n3(Math.max(0, one.cos_theta))}${factor}`)}\\
    &+ ${tinted('specular', `${n3(material.ks[c] ?? 0)} \\cdot ${n3(intensity)} \\cdot ${phong}${factor}`)}${why.lights.length > 1 ? String.raw`\\&+ \text{other lamps}` : ''}\\
    ={}& ${n3(nearest.total[c] ?? 0)} \end{aligned}`;
}

/** One sum for each channel, or a single one where all three are the same. */
function sums(why: Explanation, one: LightExplanation, scene: Scene): { name: string; tex: string }[] {
  const texts = channels.map((_, c) => numbersPutIn(why, one, scene, c, 'RGB'));
  if (new Set(texts).size === 1) return [{ name: 'RGB', tex: texts[0]! }];
  return channels.map((name, c) => ({ name, tex: numbersPutIn(why, one, scene, c, name) }));
}

function Bars({ all, total }: { all: Term[]; total: Vec3 }) {
  const most = Math.max(1, ...total);
  return (
    <div class="bars">
      {channels.map((name, c) => (
        <div class="bar-row" key={name}>
          <span>{name}</span>
          <span class="bar" role="img"
            aria-label={all.map((t) => `${t.name} ${n3(t.value[c] ?? 0)}`).join(', ')}>
            {all.map((term) => (
              <span
                key={term.name}
                class={'part ' + term.kind}
                style={{ width: `${(100 * (term.value[c] ?? 0)) / most}%` }}
              />
            ))}
          </span>
          <span class="figure">{fixed(total[c] ?? 0)}</span>
        </div>
      ))}
    </div>
  );
}

function TermTable({ all, total }: { all: Term[]; total: Vec3 }) {
  return (
    <table class="terms">
      <thead>
        <tr>
          <th scope="col">term</th>
          {channels.map((name) => (
            <th key={name} scope="col">
              {name}
            </th>
          ))}
        </tr>
      </thead>
      <tbody>
        {all.map((term) => {
          const look = () => {
            peek.value = term.layer;
          };
          const stop = () => {
            peek.value = null;
          };
          return (
            <tr key={term.name} onPointerEnter={look} onPointerLeave={stop}>
              <th scope="row">
                <button type="button" class={'term ' + term.kind} onFocus={look} onBlur={stop}>
                  {term.name}
                </button>
              </th>
              {term.value.map((v, c) => (
                <td key={c}>{fixed(v)}</td>
              ))}
            </tr>
          );
        })}
        <tr class="total">
          <th scope="row">total</th>
          {total.map((v, c) => (
            <td key={c}>{fixed(v)}</td>
          ))}
        </tr>
      </tbody>
    </table>
  );
}

/** What is seen through what: each layer counts by its opacity and what those before let through. */
function Layers({ why }: { why: Explanation }) {
  if (why.layers.length === 1 && why.layers[0]?.weight === 1) return null;
  return (
    <table class="terms">
      <thead>
        <tr>
          <th scope="col">layer</th>
          <th scope="col">weight</th>
          {channels.map((name) => (
            <th key={name} scope="col">
              {name}
            </th>
          ))}
        </tr>
      </thead>
      <tbody>
        {why.layers.map((one, n) => (
          <tr key={n}>
            <th scope="row">
              {n + 1}: opacity {shortNumber(one.opacity)}
            </th>
            <td>{fixed(one.weight)}</td>
            {one.total.map((v, c) => (
              <td key={c}>{fixed(v)}</td>
            ))}
          </tr>
        ))}
      </tbody>
    </table>
  );
}

const vector = (v: Vec3): string => v.map((x) => shortNumber(x)).join(', ');

/** What each bounce of indirect light adds, and where the first one comes from. */
function Bounces({ why }: { why: Explanation }) {
  const first = why.first_bounce;
  if (!why.bounces || !first) return null;
  const channelMean = (v: Vec3): number => (v[0] + v[1] + v[2]) / 3;
  const all = why.bounces.map(channelMean);
  const sum = all.reduce((a, b) => a + b, 0);
  const percentOf = (share: number): string => `${shortNumber(100 * share)} %`;
  return (
    <>
      <h3>
        <span class="indirect">indirect</span> = kd E, by bounces
      </h3>
      <table class="terms">
        <tbody>
          {all.map((value, n) => (
            <tr key={n}>
              <th scope="row">bounce {n + 1}</th>
              <td>{fixed(value, 4)}</td>
              <td>{sum > 0 ? percentOf(value / sum) : '–'}</td>
            </tr>
          ))}
        </tbody>
      </table>
      {first.light > 0 && (
        <>
          <h3>Where the first bounce comes from</h3>
          <table class="terms senders-table">
            <thead>
              <tr>
                <th scope="col">place</th>
                <th scope="col">at, mm</th>
                <th scope="col">share</th>
              </tr>
            </thead>
            <tbody>
              {first.senders.map(({ position, surface, share }, n) => (
                <tr key={n}>
                  <th scope="row">
                    {n + 1} <small>surface {surface}</small>
                  </th>
                  <td>{vector(position)}</td>
                  <td>{percentOf(share)}</td>
                </tr>
              ))}
              {first.sky > 0 && (
                <tr>
                  <th scope="row">open sky</th>
                  <td />
                  <td>{percentOf(first.sky)}</td>
                </tr>
              )}
            </tbody>
          </table>
        </>
      )}
    </>
  );
}

function asText(why: Explanation): string {
  const row = (name: string, v: readonly number[]) => `${name} = (${v.map((x) => x.toPrecision(9)).join(', ')})`;
  return [
    row('pixel', why.pixel).replace(/\.0+(?=[,)])/g, ''),
    row('p', why.position),
    row('n', why.normal),
    row('e', why.to_eye),
    row('ambient', why.ambient),
    ...why.lights.flatMap((one, n) => [
      `lamp ${n + 1}:`,
      row('  l', one.to_light),
      row('  r', one.reflected),
      `  cos theta = ${one.cos_theta.toPrecision(9)}, cos phi = ${one.cos_phi.toPrecision(9)}`,
      row('  diffuse', one.diffuse),
      row('  specular', one.specular),
    ]),
    row('mirror', why.mirror),
    row('indirect', why.indirect),
    ...(why.bounces ?? []).map((one, n) => row(`  E${n + 1}`, one)),
    ...(why.first_bounce?.senders ?? []).map(
      ({ surface, position, share }) =>
        row(`  ${(100 * share).toPrecision(3)} % of the first bounce from surface ${surface}, p`, position),
    ),
    row('background', why.background),
    row('total', why.total),
  ].join('\n');
}

const degrees = (cosine: number): string =>
  ((Math.acos(Math.min(1, Math.max(-1, cosine))) * 180) / Math.PI).toFixed(1) + '°';

function Hit({ why, scene }: { why: Explanation; scene: Scene }) {
  const one = why.lights[Math.min(lamp.value, why.lights.length - 1)];
  const all = terms(why);
  const copy = () =>
    navigator.clipboard
      .writeText(asText(why))
      .then(() => tell('Copied as text', 'news'))
      .catch(() => tell('The browser does not let this page copy; select the numbers instead', 'error'));
  return (
    <>
      <Formula
        name={`I equals ${why.bounces ? 'kd E' : 'ka Ia'} plus, for each lamp, kd I max(0, n dot l) plus ks I max(0, r dot e) to the shininess`}
        tex={String.raw`\begin{aligned} I ={}& ${why.bounces ? tinted('indirect', 'k_d E') : tinted('ambient', 'k_a I_a')}\\ &+ \textstyle\sum_{\text{lamps}} \big(${tinted('diffuse', String.raw`k_d I\max(0, n \cdot l)`)}\\ &\qquad\quad + ${tinted('specular', String.raw`k_s I\max(0, r \cdot e)^{s}`)}\big) \end{aligned}`}
      />
      {one && (
        <>
          <p class="cosines">
            <span class="n">n</span>·<span class="l">l</span> = cos θ = {fixed(one.cos_theta)}{' '}
            <small>θ = {degrees(one.cos_theta)}</small>
            <br />
            <span class="r">r</span>·<span class="e">e</span> = cos φ = {fixed(one.cos_phi)}{' '}
            <small>φ = {degrees(one.cos_phi)}</small>
            {one.visibility < 1 && (
              <>
                <br />
                <small>
                  In shadow: V = {fixed(one.visibility)} of the lamp’s light comes through.
                </small>
              </>
            )}
            {one.cos_theta <= 0 && (
              <>
                <br />
                <small>The lamp is behind the surface here: no diffuse light, no highlight.</small>
              </>
            )}
          </p>
          {sums(why, one, scene).map(({ name, tex }) => (
            <Formula key={name} name={`the sum in channel ${name}`} tex={tex} />
          ))}
        </>
      )}
      <Layers why={why} />
      <Bars all={all} total={why.total} />
      <TermTable all={all} total={why.total} />
      <Bounces why={why} />
      <p class="hint">
        shown as <span class="swatch" style={{ background: `rgb(${why.display.join(' ')})` }} />{' '}
        {why.display.join(', ')}. Point at a term to see it alone.
      </p>
      <div class="line">
        <button type="button" onClick={copy}>
          Copy as text
        </button>
        <button type="button" onClick={stopExplaining}>
          Close
        </button>
      </div>
    </>
  );
}

export function ExplainPanel() {
  const why = explained.value;
  const scene = drawn.value;
  if (!why || !scene) {
    return (
      <>
        <p class="hint">Click a pixel of the picture to see why it has its colour.</p>
        <div class="line">
          <button type="button" onClick={() => askAbout(0.5, 0.5)}>
            Explain the middle
          </button>
        </div>
      </>
    );
  }
  return (
    <div class="explain">
      <p class="hint" data-testid="explained-pixel">
        Pixel {why.pixel[0]}, {why.pixel[1]}
      </p>
      {why.hit ? (
        <Hit why={why} scene={scene} />
      ) : (
        <>
          <p>No surface is met here: the pixel shows the background.</p>
          <div class="line">
            <button type="button" onClick={stopExplaining}>
              Close
            </button>
          </div>
        </>
      )}
    </div>
  );
}
