// Tasks with the windows in which they are to be done: orders.

import { el, sideView, timeButton } from './draw.js';
import { timeText } from './time.js';

export function addTasks(/** @type {import('./axis.js').Axis} */ axis, /** @type {import('./data.js').Part} */ part, /** @type {import('./time.js').Choice} */ choice) {
  if (!(part.tasks || []).length) return;
  axis.title(part.title, el('span', { class: 'chip window' }, 'window'), el('span', {}, 'a bar from the begin of the work to its end'));
  for (const task of part.tasks || []) {
    const choose = () => choice.chooseTask(choice.task === task ? null : task);
    const name = el('button', { type: 'button', class: 'name task', title: task.text, onclick: choose },
      sideView(task.look || '', 20), el('span', { class: 'ink', style: { '--ink': task.kind ? axis.kinds.ink(task.kind) : 'inherit' } }, task.name));
    const { row, track } = axis.row(name, 'lane tasks');
    const jump = () => {
      choice.chooseTask(task);
      axis.clock.seek(task.begun ?? task.begin);
    };
    const lines = [task.name + ': ' + task.text, task.reason];
    // A window of something that is known later has its dash before.
    track.append(axis.bar({ begin: task.begin, end: Math.min(task.end, axis.clock.end), kind: '' }, 'window', ['window of ' + task.name, task.text, task.reason], task.begun === null ? task.state : '', jump));
    const begun = task.begun;
    if (begun !== null) {
      const end = task.done ?? axis.clock.end;
      track.append(axis.bar({ begin: begun, end: Math.max(begun, end), kind: task.state_kind }, 'inset', lines, task.state, jump));
    }
    for (const step of task.steps) {
      const t = step.end ?? step.begin;
      if (t === null) continue;
      track.append(axis.mark({ t, kind: task.state_kind }, [step.text + (step.where ? ' at ' + step.where : ''), step.reason || ''], () => {
        choice.chooseTask(task);
        axis.clock.seek(t);
      }));
    }
    axis.listen(choice, () => row.classList.toggle('chosen', choice.task === task));
  }
}

/** All that is known of a task. */
export function taskDetails(/** @type {import('./data.js').Task} */ task, /** @type {import('./axis.js').Axis} */ axis, /** @type {import('./time.js').Choice} */ choice) {
  const { clock, kinds } = axis, look = kinds.look(task.state_kind);
  const row = (/** @type {string} */ name, /** @type {any[]} */ ...values) => el('tr', {}, el('th', {}, name), el('td', {}, ...values));
  const steps = task.steps.map((step) => el('tr', {},
    el('td', {}, timeButton(clock, step.begin)), el('td', {}, step.text),
    el('td', {}, step.where ? el('button', { type: 'button', class: 'link', onclick: () => choice.chooseName(step.where || '') }, step.where) : ''),
    el('td', {}, timeButton(clock, step.end)),
    el('td', { class: 'number' }, step.waited_s ? step.waited_s.toFixed(1) + ' s' : ''), el('td', {}, step.reason || '')));
  return el('div', { class: 'details task' },
    el('h3', {}, sideView(task.look || '', 40), task.name + ' ', el('span', { class: 'chip' + look.class, style: look.style }, task.state)),
    el('table', {},
      row('wanted', task.text),
      row('known from', timeButton(clock, task.known)),
      row('window', timeButton(clock, task.begin), ' to ', timeButton(clock, task.end)),
      task.begun === null ? '' : row('begun', timeButton(clock, task.begun)),
      task.done === null ? '' : row('done', timeButton(clock, task.done), task.late_s > 0 ? ', late by ' + task.late_s.toFixed(1) + ' s' : ''),
      task.points === null ? '' : row('points', String(task.points)),
      row('outcome', task.reason)),
    steps.length ? el('div', { class: 'scroll' }, el('table', { class: 'steps' },
      el('tr', {}, ...['arrived', 'step', 'where', 'done', 'waited', 'what for'].map((head) => el('th', {}, head))), ...steps)) : '');
}

/** "in its window until 5:00", for the list of what is so now. */
export function taskState(/** @type {import('./data.js').Task} */ task, /** @type {number} */ t) {
  if (t < task.known) return '';
  if (task.done !== null && t >= task.done) return 'done' + (task.late_s > 0 ? ' late' : '');
  const work = task.begun !== null && t >= task.begun ? ', begun' : '';
  if (t < task.begin) return 'window from ' + timeText(task.begin, 0) + work;
  return (t <= task.end ? 'until ' + timeText(task.end, 0) : 'window over') + work;
}
