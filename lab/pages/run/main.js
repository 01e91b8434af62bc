// Puts the page together: player, keys, links.

import { Axis } from './axis.js';
import { addChart } from './chart.js';
import { additions, source } from './data.js';
import { el, Kinds } from './draw.js';
import { Field } from './field.js';
import { make3d } from './field3d.js';
import { addLanes } from './lanes.js';
import { Now } from './now.js';
import { addTasks } from './orders.js';
import { Scene } from './scene.js';
import { addEventRows, EventTable } from './table.js';
import { themeButton } from './theme.js';
import { Choice, Clock, readTime, Span, timeText } from './time.js';

const SPEEDS = [0.5, 1, 2, 5, 10, 20, 50, 100];
const KEYS = [['Space', 'play or stop'], ['← →', '1 s back or on; with Shift 10 s'], ['Home End', 'begin or end'], ['[ ]', 'event before or after'],
  ['+ −', 'show less or more of the run'], ['0', 'the whole run'], ['v', 'in 3D or from above'], ['d', 'light or dark'], ['Esc', 'nothing chosen'], ['?', 'these keys']];

function player(/** @type {Clock} */ clock, /** @type {any[]} */ more) {
  const play = el('button', { type: 'button', class: 'play', 'aria-label': 'play', onclick: () => clock.play() });
  const slider = el('input', { type: 'range', id: 'slider', min: 0, max: clock.end, step: 0.1, 'aria-label': 'time', oninput: () => clock.seek(Number(slider.value)) });
  const time = el('input', { type: 'text', id: 'time', size: 8, 'aria-label': 'time, as 5:12.4', onchange: () => {
    const t = readTime(time.value);
    if (Number.isNaN(t)) time.value = timeText(clock.t);
    else clock.seek(t);
  } });
  const speed = el('select', { 'aria-label': 'speed', onchange: () => { clock.speed = Number(speed.value); } },
    ...SPEEDS.map((one) => el('option', { value: one, selected: one === clock.speed }, one + ' ×')));
  const length = el('span', { class: 'note' });
  clock.listen(() => {
    play.textContent = clock.playing ? '❚❚' : '▶';
    play.setAttribute('aria-label', clock.playing ? 'stop' : 'play');
    slider.max = clock.end;
    slider.value = clock.t;
    length.textContent = 'of ' + timeText(Math.floor(clock.end), 0);
    slider.setAttribute('aria-valuetext', timeText(clock.t));
    if (document.activeElement !== time) time.value = timeText(clock.t);
  });
  return el('div', { class: 'player' }, play, slider, time, length, speed, ...more);
}

/** `#t=312.4&order=5`: the address says what is shown, and shows what it says. */
class Address {
  constructor(/** @type {Clock} */ clock, /** @type {Choice} */ choice) {
    this.clock = clock;
    this.choice = choice;
    /** @type {import('./data.js').Task[]} */
    this.tasks = [];
    /** What else the address names: `text` gives it, `read` takes it. Names of tasks come after those.
     * @type {{names: string[], text: () => Object<string, string>, read: (wanted: URLSearchParams) => void}[]} */
    this.others = [];
    this.timer = 0;
  }
  /** From now on. */
  follow() {
    this.read();
    addEventListener('hashchange', () => this.read());
    this.clock.listen(() => this.later());
    this.choice.listen(() => this.later());
  }
  read() {
    const wanted = new URLSearchParams(location.hash.slice(1));
    const known = ['t', 'of', ...this.others.flatMap((one) => one.names)];
    for (const [key, value] of wanted)
      if (!known.includes(key)) {
        const fits = (/** @type {(task: import('./data.js').Task) => boolean} */ test) => this.tasks.find((task) => task.word === key && test(task));
        const task = fits((one) => one.id === value) || fits((one) => one.id.endsWith('-' + value));
        if (task) this.choice.chooseTask(task);
      }
    if (wanted.has('of')) this.choice.chooseName(wanted.get('of') || '');
    const t = readTime(wanted.get('t') || '');
    if (!Number.isNaN(t)) this.clock.seek(t);
    for (const other of this.others) other.read(wanted);
  }
  get text() {
    const parts = ['t=' + Number(this.clock.t.toFixed(2))];
    const { task, name } = this.choice;
    if (task) parts.push(encodeURIComponent(task.word || 'task') + '=' + encodeURIComponent(task.id));
    if (name) parts.push('of=' + encodeURIComponent(name));
    for (const other of this.others)
      for (const [key, value] of Object.entries(other.text())) if (value) parts.push(key + '=' + encodeURIComponent(value));
    return '#' + parts.join('&');
  }
  /** Browsers take few changes in a second. */
  later() {
    if (this.timer) return;
    this.timer = setTimeout(() => {
      this.timer = 0;
      if (location.hash !== this.text) history.replaceState(null, '', this.text);
    }, this.clock.playing ? 1000 : 60);
  }
}

/** After the browser has painted. */
const painted = () => new Promise((done) => requestAnimationFrame(() => setTimeout(done)));

export class Page {
  constructor(/** @type {HTMLElement} */ app, /** @type {import('./data.js').Run} */ run, /** @type {Scene} */ scene) {
    this.app = app;
    this.run = run;
    this.scene = scene;
    this.clock = new Clock(run.end);
    this.span = new Span(this.clock);
    this.choice = new Choice();
    this.axis = new Axis(this.clock, this.span, new Kinds(run.kinds), run);
    this.address = new Address(this.clock, this.choice);
    /** @type {Field|null} */
    this.field = null;
    /** @type {EventTable|null} */
    this.table = null;
    this.top = el('div', { class: 'top' });
    this.keys = el('table', {}, ...KEYS.map(([key, what]) => this.keyRow(key, what)));
    this.dialog = el('dialog', { class: 'keys' }, el('h2', {}, 'Keys'), this.keys, el('form', { method: 'dialog' }, el('button', {}, 'close')));
    this.theme = themeButton(() => this.field?.draw());
    /** @type {Object<string, (shift: boolean) => void>} */
    this.acts = {};
    const help = el('button', { type: 'button', title: 'keys (?)', 'aria-label': 'keys', onclick: () => this.dialog.showModal() }, '?');
    this.player = player(this.clock, [this.theme, help]);
    app.replaceChildren(this.player, this.top, this.axis.box, this.dialog);
    this.showNow();
  }

  keyRow(/** @type {string} */ key, /** @type {string} */ what) {
    return el('tr', {}, el('th', {}, key), el('td', {}, what));
  }

  /** The field and what is so now. */
  showNow() {
    if (!this.field && !this.scene.empty) {
      this.field = new Field(this.scene, this.clock, this.choice, (canvas) =>
        make3d(canvas, source, this.field?.area || { minX: 0, minY: 0, maxX: 1, maxY: 1 }, () => this.field?.draw()));
      this.top.prepend(this.field.box);
    }
    const now = new Now(this.axis, this.scene, this.choice);
    this.now?.box.remove();
    this.now = now;
    this.top.append(now.box);
    this.top.classList.toggle('alone', !this.field);
  }

  /** What the run has recorded; again when that has grown. */
  fill(/** @type {import('./data.js').Run} */ run, again = false) {
    const { axis, choice } = this;
    this.run = run;
    if (again) {
      axis.clear(run);
      this.span.grow(run.end);
      this.showNow();
    }
    const tasks = run.parts.flatMap((part) => (part.tasks || []).map((task) => Object.assign(task, { word: part.word })));
    const byId = new Map(tasks.map((task) => [task.id, task]));
    const taskOf = (/** @type {string|undefined} */ id) => byId.get(id || '') || null;
    this.address.tasks = tasks;
    if (again && choice.task) choice.chooseTask(taskOf(choice.task.id));
    for (const part of run.parts) {
      if (part.type === 'lanes') addLanes(axis, part, choice, taskOf);
      if (part.type === 'tasks') addTasks(axis, part, choice);
      if (part.type === 'chart') addChart(axis, part);
    }
    addEventRows(axis, run.events, choice, taskOf);
    const table = new EventTable(axis, run.events, choice, taskOf, this.table);
    if (this.table) this.table.box.replaceWith(table.box);
    else axis.box.after(table.box);
    table.box.hidden = !run.events.length;
    this.table = table;
    axis.place();
  }

  listenToKeys() {
    const { clock, span, choice } = this;
    Object.assign(this.acts, {
      ' ': () => clock.play(), ArrowLeft: (/** @type {boolean} */ shift) => clock.seek(clock.t - (shift ? 10 : 1)), ArrowRight: (/** @type {boolean} */ shift) => clock.seek(clock.t + (shift ? 10 : 1)),
      Home: () => clock.seek(0), End: () => clock.seek(clock.end), '+': () => span.zoom(0.5), '=': () => span.zoom(0.5), '-': () => span.zoom(2), '0': () => span.show(0, clock.end),
      '[': () => this.table?.jump(-1), ']': () => this.table?.jump(1), v: () => this.field?.toggle(), d: () => this.theme.click(), '?': () => this.dialog.showModal(), Escape: () => choice.chooseName(''),
    });
    addEventListener('keydown', (event) => {
      const target = /** @type {HTMLElement} */ (event.target);
      const act = this.acts[event.key];
      const types = target.matches('input[type=text], input[type=search], select');
      const presses = event.key === ' ' && target.matches('button, input, summary, a, [role=button]');
      if (!act || types || presses || event.ctrlKey || event.metaKey || event.altKey || this.dialog.open) return;
      event.preventDefault();
      act(event.shiftKey);
    });
  }
}

async function start() {
  const [run, bytes] = await Promise.all([source.run(), source.scene()]);
  const page = new Page(/** @type {HTMLElement} */ (document.getElementById('app')), run, new Scene(bytes));
  const { field, scene } = page;
  if (field && scene.until < run.end - 1 && !additions.length) field.note.textContent = 'The page has the field up to ' + timeText(scene.until, 0) + '; scene.bin has the rest.';
  await painted();
  page.fill(run);
  page.listenToKeys();
  for (const add of additions) add(page);
  page.address.follow();
  Object.assign(window, { cxlab: page }); // for the console, for pages around this one, and for tests
  document.documentElement.dataset.ready = 'true';
  await painted();
  if (field) await field.toggle(true);
}

start().catch((error) => {
  const app = document.getElementById('app');
  if (app) app.textContent = 'This page cannot be shown: ' + error.message;
  throw error;
});
