// What is so at the time that is shown, and what is chosen.

import { el } from './draw.js';
import { barAt } from './lanes.js';
import { taskDetails, taskState } from './orders.js';
import { timeText } from './time.js';

export class Now {
  constructor(/** @type {import('./axis.js').Axis} */ axis, /** @type {import('./scene.js').Scene} */ scene, /** @type {import('./time.js').Choice} */ choice) {
    this.axis = axis;
    this.scene = scene;
    this.choice = choice;
    const of = (/** @type {string} */ type) => axis.run.parts.filter((part) => part.type === type);
    /** @type {{cells: any[], text: (t: number) => string[]}[]} */
    this.lines = [];
    const list = el('table', { class: 'now' });
    const line = (/** @type {any} */ name, /** @type {(t: number) => string[]} */ text) => {
      const cells = [el('td', {}), el('td', { class: 'number' })];
      this.lines.push({ cells, text });
      list.append(el('tr', {}, el('th', {}, name), ...cells));
    };
    for (const part of of('lanes'))
      for (const lane of part.lanes || [])
        line(el('button', { type: 'button', class: 'link', onclick: () => choice.chooseName(lane.name) }, lane.name), (t) => {
          const bar = barAt(lane, t);
          return bar ? [bar.text + (bar.remark || ''), (t - bar.begin).toFixed(0) + ' s', bar.kind] : ['', '', ''];
        });
    if (!this.lines.length)
      for (const track of scene.tracks.values())
        if (track.moves && this.lines.length < 20)
          line(el('button', { type: 'button', class: 'link', onclick: () => choice.chooseName(track.name) }, track.name), (t) =>
            track.there.at(t) ? [track.state.at(t) || '', '', ''] : ['not there', '', '']);
    for (const part of of('tasks'))
      for (const task of part.tasks || [])
        line(el('button', { type: 'button', class: 'link', onclick: () => choice.chooseTask(task) }, task.name), (t) => [taskState(task, t), '', '']);
    this.details = el('div', { class: 'selection', 'aria-live': 'polite' });
    this.box = el('section', { class: 'now' }, this.details, el('div', { class: 'scroll' }, list));
    this.box.hidden = !this.lines.length && scene.empty;
    axis.listen(axis.clock, () => this.show());
    axis.listen(choice, () => this.showChosen());
  }

  show() {
    // At the end there is what was so last.
    const t = Math.min(this.axis.clock.t, this.axis.clock.end - 1e-3);
    for (const line of this.lines) {
      const [text, age, kind] = line.text(t);
      if (line.cells[0].textContent !== text) {
        line.cells[0].textContent = text;
        const ink = kind ? this.axis.kinds.fill(kind) : 'transparent';
        line.cells[0].style.setProperty('--fill', ink);
      }
      if (line.cells[1].textContent !== age) line.cells[1].textContent = age;
    }
    if (this.choice.name) this.showChosen();
  }

  showChosen() {
    const { task, name } = this.choice, { t } = this.axis.clock;
    const close = el('button', { type: 'button', class: 'close', title: 'close (Esc)', 'aria-label': 'close', onclick: () => this.choice.chooseName('') }, '×');
    if (task) {
      this.details.replaceChildren(close, taskDetails(task, this.axis, this.choice));
      return;
    }
    const track = name && this.scene.find(name);
    if (!track) {
      this.details.replaceChildren(...(name ? [close, el('h3', {}, name)] : []));
      return;
    }
    const there = track.there.at(Math.min(t, this.scene.until));
    const place = there && this.scene.placeOf(track, t).position.map((/** @type {number} */ value) => value.toFixed(2)).join(', ');
    const carrier = this.scene.tracks.get(track.carrier.at(t) || 0);
    const carries = [...this.scene.tracks.values()].filter((one) => one.there.at(t) && one.carrier.at(t) === track.id);
    const row = (/** @type {string} */ head, /** @type {any} */ value) => (value ? el('tr', {}, el('th', {}, head), el('td', {}, value)) : '');
    this.details.replaceChildren(close, el('h3', {}, track.name + ' '), el('table', {},
      row('kind', track.kind), row('state', there ? track.state.at(t) : 'not there at ' + timeText(t)), row('at', place && place + ' m'),
      row('carried by', carrier && carrier.name + ' ' + (track.place.at(t) || '')),
      row('carries', carries.map((one) => one.name + (one.state.at(t) ? ' (' + one.state.at(t) + ')' : '')).join(', '))));
  }
}
