// Figures over time.

import { el, tip } from './draw.js';
import { lastNotAfter } from './scene.js';
import { timeText } from './time.js';

const HEIGHT = 140;

export function addChart(/** @type {import('./axis.js').Axis} */ axis, /** @type {import('./data.js').Part} */ part) {
  const lines = part.lines || [];
  const values = lines.flatMap((line) => line.steps.map((step) => step[1]));
  const top = Math.max(10, ...values), bottom = Math.min(0, ...values);
  const end = axis.clock.end || 1, y = (/** @type {number} */ value) => 4 + ((HEIGHT - 8) * (top - value)) / (top - bottom);
  const shown = lines.map((line) => {
    const times = line.steps.map((step) => step[0]);
    const path = el('path', { class: line.part ? 'part' : 'whole', style: { '--ink': axis.kinds.ink(line.kind) },
      d: `M0 ${y(0)}` + line.steps.map(([t, value]) => `H${t}V${y(value)}`).join('') + `H${end}` });
    const value = el('b', {}, '0');
    const at = (/** @type {number} */ t) => line.steps[lastNotAfter(times, t)]?.[1] ?? 0;
    const box = el('input', { type: 'checkbox', checked: true, onchange: () => path.toggleAttribute('hidden', !box.checked) });
    const key = el('label', { class: 'line' + (line.part ? ' part' : ''), style: { '--ink': axis.kinds.ink(line.kind) } }, box, el('i', {}), line.text + ' ', value);
    return { line, at, box, path, value, key };
  });
  axis.title(part.title, ...shown.map((one) => one.key));
  const scale = el('div', { class: 'scale' });
  const { track, plot } = axis.row(scale, 'chart');
  plot.addEventListener('pointermove', (/** @type {PointerEvent} */ event) => {
    const t = axis.timeAt(event);
    tip.show(event, [timeText(t), ...shown.filter((one) => one.box.checked && one.at(t)).map((one) => (one.line.text + ' ' + one.at(t)))]);
  });
  const steps = niceSteps(bottom, top);
  for (const value of steps) scale.append(el('span', { style: { top: y(value) + 'px' } }, String(value)));
  track.append(el('svg', { viewBox: `0 0 ${end} ${HEIGHT}`, preserveAspectRatio: 'none', height: HEIGHT },
    ...steps.map((value) => el('line', { class: 'grid', x1: 0, x2: end, y1: y(value), y2: y(value) })),
    ...shown.filter((one) => one.line.part).map((one) => one.path), ...shown.filter((one) => !one.line.part).map((one) => one.path)));
  axis.listen(axis.clock, () => {
    for (const { at, value } of shown) {
      const text = String(at(axis.clock.t));
      if (value.textContent !== text) value.textContent = text;
    }
  });
}

/** Round numbers from bottom to top, about four. */
export function niceSteps(/** @type {number} */ bottom, /** @type {number} */ top) {
  const rough = (top - bottom) / 4, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((one) => one * power).find((one) => one >= rough) || rough;
  const out = [];
  for (let i = Math.ceil(bottom / step); i * step <= top; ++i) out.push(Number((i * step).toPrecision(12)));
  return out;
}
