// Puts the page together: player, keys, links.

import { Axis } from './axis.js';
import { addChart } from './chart.js';
import { source } from './data.js';
import { el, Kinds } from './draw.js';
import { Field } from './field.js';
import { make3d } from './field3d.js';
import { addLanes } from './lanes.js';
import { Now } from './now.js';
import { addTasks } from './orders.js';
import { Scene } from './scene.js';
import { addEventRows, EventTable } from './table.js';
import { Choice, Clock, readTime, Span, timeText } from './time.js';

const SPEEDS = [0.5, 1, 2, 5, 10, 20, 50, 100];
const KEYS = [['Space', 'play or stop'], ['← →', '1 s back or on; with Shift 10 s'], ['Home End', 'begin or end'], ['[ ]', 'event before or after'],
  ['+ −', 'show less or more of the run'], ['0', 'the whole run'], ['v', 'in 3D or from above'], ['d', 'light or dark'], ['Esc', 'nothing chosen'], ['?', 'these keys']];

/** Remembers a setting where the browser allows it. */
const memory = {
  get: (/** @type {string} */ key) => { try { return localStorage.getItem(key); } catch (error) { return null; } },
  set: (/** @type {string} */ key, /** @type {string} */ value) => { try { localStorage.setItem(key, value); } catch (error) { /* it is forgotten */ } },
};

/** Light, dark, or as the system has it. */
function themeButton(/** @type {() => void} */ changed) {
  const names = ['auto', 'light', 'dark'];
  const button = el('button', { type: 'button', title: 'light or dark (d)', onclick: () => show(names[(names.indexOf(memory.get('cxlab-theme') || 'auto') + 1) % 3]) });
  let shown = memory.get('cxlab-theme') || 'auto';
  const show = (/** @type {string} */ name) => {
    shown = names.includes(name) ? name : 'auto';
    memory.set('cxlab-theme', shown);
    document.documentElement.dataset.theme = shown;
    button.textContent = shown;
    changed();
  };
  button.onclick = () => show(names[(names.indexOf(shown) + 1) % names.length]);
  show(shown);
  return button;
}

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
  clock.listen(() => {
    play.textContent = clock.playing ? '❚❚' : '▶';
    play.setAttribute('aria-label', clock.playing ? 'stop' : 'play');
    slider.value = clock.t;
    slider.setAttribute('aria-valuetext', timeText(clock.t));
    if (document.activeElement !== time) time.value = timeText(clock.t);
  });
  return el('div', { class: 'player' }, play, slider, time, el('span', { class: 'note' }, 'of ' + timeText(clock.end, 0)), speed, ...more);
}

/** `#t=312.4&order=5`: the address says what is shown, and shows what it says. */
class Address {
  constructor(/** @type {Clock} */ clock, /** @type {Choice} */ choice, /** @type {import('./data.js').Task[]} */ tasks) {
    this.clock = clock;
    this.choice = choice;
    this.tasks = tasks;
    this.timer = 0;
    this.read();
    addEventListener('hashchange', () => this.read());
    clock.listen(() => this.later());
    choice.listen(() => this.later());
  }
  read() {
    const wanted = new URLSearchParams(location.hash.slice(1));
    for (const [key, value] of wanted)
      if (key !== 't' && key !== 'of') {
        const fits = (/** @type {(task: import('./data.js').Task) => boolean} */ test) => this.tasks.find((task) => task.word === key && test(task));
        const task = fits((one) => one.id === value) || fits((one) => one.id.endsWith('-' + value));
        if (task) this.choice.chooseTask(task);
      }
    if (wanted.has('of')) this.choice.chooseName(wanted.get('of') || '');
    const t = readTime(wanted.get('t') || '');
    if (!Number.isNaN(t)) this.clock.seek(t);
  }
  get text() {
    const parts = ['t=' + Number(this.clock.t.toFixed(2))];
    const { task, name } = this.choice;
    if (task) parts.push(encodeURIComponent(task.word || 'task') + '=' + encodeURIComponent(task.id));
    if (name) parts.push('of=' + encodeURIComponent(name));
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

async function start() {
  const app = /** @type {HTMLElement} */ (document.getElementById('app'));
  const [run, bytes] = await Promise.all([source.run(), source.scene()]);
  const scene = new Scene(bytes);
  const clock = new Clock(run.end), span = new Span(clock), choice = new Choice(), kinds = new Kinds(run.kinds);
  const axis = new Axis(clock, span, kinds, run);
  const tasks = run.parts.flatMap((part) => (part.tasks || []).map((task) => Object.assign(task, { word: part.word })));
  const byId = new Map(tasks.map((task) => [task.id, task]));
  const taskOf = (/** @type {string|undefined} */ id) => byId.get(id || '') || null;
  /** @type {Field|null} */
  const field = scene.empty ? null : new Field(scene, clock, choice, (canvas) => make3d(canvas, source, field?.area || { minX: 0, minY: 0, maxX: 1, maxY: 1 }, () => field?.draw()));
  const now = new Now(axis, scene, choice);
  const keys = el('dialog', { class: 'keys' }, el('h2', {}, 'Keys'), el('table', {}, ...KEYS.map(([key, what]) => el('tr', {}, el('th', {}, key), el('td', {}, what)))),
    el('form', { method: 'dialog' }, el('button', {}, 'close')));
  const theme = themeButton(() => field?.draw());
  const help = el('button', { type: 'button', title: 'keys (?)', 'aria-label': 'keys', onclick: () => keys.showModal() }, '?');
  if (field && scene.until < run.end - 1) field.note.textContent = 'The page has the field up to ' + timeText(scene.until, 0) + '; scene.bin has the rest.';
  app.replaceChildren(player(clock, [theme, help]), el('div', { class: 'top' + (field ? '' : ' alone') }, field && field.box, now.box), axis.box, keys);
  new Address(clock, choice, tasks);
  await painted();

  for (const part of run.parts) {
    if (part.type === 'lanes') addLanes(axis, part, choice, taskOf);
    if (part.type === 'tasks') addTasks(axis, part, choice);
    if (part.type === 'chart') addChart(axis, part);
  }
  addEventRows(axis, run.events, choice, taskOf);
  const table = new EventTable(axis, run.events, choice, taskOf);
  if (run.events.length) axis.box.after(table.box);
  axis.place();

  /** @type {Object<string, (shift: boolean) => void>} */
  const acts = {
    ' ': () => clock.play(), ArrowLeft: (shift) => clock.seek(clock.t - (shift ? 10 : 1)), ArrowRight: (shift) => clock.seek(clock.t + (shift ? 10 : 1)),
    Home: () => clock.seek(0), End: () => clock.seek(clock.end), '+': () => span.zoom(0.5), '=': () => span.zoom(0.5), '-': () => span.zoom(2), '0': () => span.show(0, clock.end),
    '[': () => table.jump(-1), ']': () => table.jump(1), v: () => field?.toggle(), d: () => theme.click(), '?': () => keys.showModal(), Escape: () => choice.chooseName(''),
  };
  addEventListener('keydown', (event) => {
    const target = /** @type {HTMLElement} */ (event.target);
    const act = acts[event.key];
    const types = target.matches('input[type=text], input[type=search], select');
    const presses = event.key === ' ' && target.matches('button, input, summary, a');
    if (!act || types || presses || event.ctrlKey || event.metaKey || event.altKey || keys.open) return;
    event.preventDefault();
    act(event.shiftKey);
  });
  Object.assign(window, { cxlab: { run, scene, clock, span, choice, field } }); // for the console, and for tests
  document.documentElement.dataset.ready = 'true';
  await painted();
  if (field) await field.toggle(true);
}

start().catch((error) => {
  const app = document.getElementById('app');
  if (app) app.textContent = 'This page cannot be shown: ' + error.message;
  throw error;
});
