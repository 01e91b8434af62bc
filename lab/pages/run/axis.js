// Rows that share one time axis. A row has a label and a track, on which the whole run lies from 0 to 100 %.

import { el, tip } from './draw.js';
import { timeText } from './time.js';

const STEPS = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1800, 3600, 7200, 36000];

export class Axis {
  constructor(/** @type {import('./time.js').Clock} */ clock, /** @type {import('./time.js').Span} */ span,
    /** @type {import('./draw.js').Kinds} */ kinds, /** @type {import('./data.js').Run} */ run) {
    this.clock = clock;
    this.span = span;
    this.kinds = kinds;
    this.run = run;
    this.ticks = el('div', { class: 'plot ticks' });
    this.cursor = el('div', { class: 'cursor', 'aria-hidden': 'true' });
    const button = (/** @type {string} */ text, /** @type {string} */ title, /** @type {() => void} */ act) => el('button', { type: 'button', title, onclick: act }, text);
    this.head = el('div', { class: 'row head' },
      el('div', { class: 'label' },
        button('+', 'show less of the run (+)', () => span.zoom(0.5)),
        button('−', 'show more of the run (-)', () => span.zoom(2)),
        button('all', 'show the whole run (0)', () => span.show(0, clock.end))),
      this.ticks);
    this.box = el('section', { class: 'timeline', 'aria-label': 'what happened when' }, this.head, this.cursor);
    /** @type {WeakMap<Element, {lines: string[], act: () => void}>} */
    this.told = new WeakMap();
    /** @type {{element: HTMLElement, length: number}[]} */
    this.texts = [];
    /** @type {(() => void)[]} */
    this.listening = [];
    this.left = 0; // of the tracks, px
    this.wide = 0;
    this.seeks(this.ticks);
    const told = (/** @type {Event} */ event) => this.told.get(/** @type {Element} */ (event.target));
    this.box.addEventListener('pointerover', (/** @type {PointerEvent} */ event) => {
      const of = told(event);
      if (of) tip.show(event, of.lines);
      else tip.hide();
    });
    this.box.addEventListener('pointerleave', () => tip.hide());
    this.box.addEventListener('click', (/** @type {Event} */ event) => told(event)?.act());
    this.box.addEventListener('wheel', (/** @type {WheelEvent} */ event) => {
      const plot = /** @type {Element} */ (event.target).closest('.plot');
      if (!plot) return;
      if (event.ctrlKey || event.metaKey || plot === this.ticks) span.zoom(Math.exp(event.deltaY * 0.002), this.timeAt(event));
      else if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY))
        span.show(span.from + ((event.deltaX || event.deltaY) / this.ticks.clientWidth) * span.length, span.length);
      else return;
      event.preventDefault();
    }, { passive: false });
    new ResizeObserver(() => this.place()).observe(this.box);
    span.listen(() => this.place());
    clock.listen(() => this.placeCursor());
  }

  /** Without rows, for what is known of the run now. */
  clear(/** @type {import('./data.js').Run} */ run) {
    for (const end of this.listening) end();
    this.listening = [];
    this.texts = [];
    this.run = run;
    this.box.replaceChildren(this.head, this.cursor);
  }
  /** As long as the rows are there. */
  listen(/** @type {{listen: (call: () => void) => () => void}} */ signal, /** @type {() => void} */ call) {
    this.listening.push(signal.listen(call));
  }

  share(/** @type {number} */ t) {
    return (100 * t) / (this.clock.end || 1);
  }
  timeAt(/** @type {MouseEvent} */ event) {
    const box = this.ticks.getBoundingClientRect();
    return this.span.from + ((event.clientX - box.left) / box.width) * this.span.length;
  }

  /** A press or a drag on empty ground goes to that time. */
  seeks(/** @type {HTMLElement} */ plot) {
    plot.addEventListener('pointerdown', (event) => {
      if (event.button !== 0 || /** @type {Element} */ (event.target).closest('.bar, .mark')) return;
      plot.setPointerCapture(event.pointerId);
      this.clock.seek(this.timeAt(event));
    });
    plot.addEventListener('pointermove', (event) => {
      if (plot.hasPointerCapture(event.pointerId)) this.clock.seek(this.timeAt(event));
    });
  }

  title(/** @type {string} */ text, /** @type {any[]} */ ...more) {
    this.box.append(el('div', { class: 'row title' }, el('h2', {}, text), el('div', { class: 'key' }, ...more)));
  }

  /** A row; what is appended to its track lies at `left: share(t)%`. */
  row(/** @type {any} */ label, /** @type {string} */ kind = '') {
    const track = el('div', { class: 'track' });
    const plot = el('div', { class: 'plot' }, track);
    for (const shade of this.run.shades) track.append(this.bar(shade, 'shade', [shade.text]));
    const row = el('div', { class: 'row ' + kind }, el('div', { class: 'label' }, label), plot);
    this.seeks(plot);
    this.box.append(row);
    return { row, track, plot };
  }

  /** An element from begin to end, with what the pointer shows of it. */
  bar(/** @type {{begin: number, end: number, kind: string}} */ bar, /** @type {string} */ shape, /** @type {string[]} */ lines, text = '', act = () => this.clock.seek(bar.begin)) {
    const look = this.kinds.look(bar.kind);
    const element = el('div', { class: 'bar ' + shape + look.class, style: { ...look.style, left: this.share(bar.begin) + '%', width: this.share(bar.end - bar.begin) + '%' } }, text);
    if (text) this.texts.push({ element, length: bar.end - bar.begin });
    this.told.set(element, { lines: [...lines, timeText(bar.begin) + ' to ' + timeText(bar.end) + ', ' + (bar.end - bar.begin).toFixed(1) + ' s'], act });
    return element;
  }
  mark(/** @type {{t: number, kind: string}} */ mark, /** @type {string[]} */ lines, act = () => this.clock.seek(mark.t)) {
    const element = el('div', { class: 'mark', style: { left: this.share(mark.t) + '%', '--ink': this.kinds.ink(mark.kind) } });
    this.told.set(element, { lines: [...lines, timeText(mark.t)], act });
    return element;
  }

  place() {
    const { from, length } = this.span, end = this.clock.end || 1;
    this.box.style.setProperty('--left', (-100 * from) / length + '%');
    this.box.style.setProperty('--width', (100 * end) / length + '%');
    this.left = this.ticks.offsetLeft;
    this.wide = this.ticks.clientWidth;
    const wide = this.wide || 600;
    const least = (length * 64) / wide;
    // A text that has no room is not begun.
    for (const { element, length: own } of this.texts) element.classList.toggle('short', (own / length) * wide < 34);
    const step = STEPS.find((one) => one >= least) || length;
    const ticks = [];
    for (let i = Math.ceil(from / step); i * step <= this.span.to + 1e-9; ++i) {
      const share = (100 * (i * step - from)) / length;
      ticks.push(el('span', { class: share > 96 ? 'tick last' : 'tick', style: { left: share + '%' } }, timeText(i * step, step < 1 ? 1 : 0)));
    }
    this.ticks.replaceChildren(...ticks);
    this.placeCursor();
  }
  placeCursor() {
    const share = (this.clock.t - this.span.from) / this.span.length;
    this.cursor.hidden = share < 0 || share > 1;
    // The browser moves what it has drawn, and draws no lane anew.
    this.cursor.style.transform = 'translateX(' + (this.left + share * this.wide) + 'px)';
  }
}
