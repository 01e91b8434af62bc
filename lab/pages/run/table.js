// Events: marks on the time axis, a row for each kind, and a table with filters.

import { el, timeButton } from './draw.js';

const ROWS_AT_FIRST = 200;

export function addEventRows(/** @type {import('./axis.js').Axis} */ axis, /** @type {import('./data.js').RunEvent[]} */ events,
  /** @type {import('./time.js').Choice} */ choice, /** @type {(id: string|undefined) => import('./data.js').Task|null} */ taskOf) {
  const kinds = [...new Set(events.filter((event) => event.t !== null).map((event) => event.kind))];
  if (kinds.length) axis.title('Events');
  for (const kind of kinds) {
    const { track } = axis.row(el('span', { class: 'ink', style: { '--ink': axis.kinds.ink(kind) } }, kind), 'events');
    for (const event of events) {
      const t = event.t;
      if (t === null || event.kind !== kind) continue;
      track.append(axis.mark({ t, kind }, [(event.who ? event.who + ': ' : '') + event.text, event.reason || ''], () => {
        const task = taskOf(event.task);
        if (task) choice.chooseTask(task);
        axis.clock.seek(t);
      }));
    }
  }
}

export class EventTable {
  constructor(/** @type {import('./axis.js').Axis} */ axis, /** @type {import('./data.js').RunEvent[]} */ events,
    /** @type {import('./time.js').Choice} */ choice, /** @type {(id: string|undefined) => import('./data.js').Task|null} */ taskOf,
    /** @type {any} the table that this one replaces */ before = null) {
    this.axis = axis;
    this.events = events;
    this.choice = choice;
    this.taskOf = taskOf;
    this.most = ROWS_AT_FIRST;
    const changed = () => {
      this.most = ROWS_AT_FIRST;
      this.show();
    };
    const names = [...new Set(events.map((event) => event.kind))];
    /** @type {Map<string, any>} */
    this.kinds = new Map(names.map((kind) => [kind, el('input', { type: 'checkbox', checked: before?.kinds.get(kind)?.checked ?? true, onchange: changed })]));
    this.who = el('select', { 'aria-label': 'of whom', onchange: changed }, el('option', { value: '' }, 'everybody'),
      ...[...new Set(events.map((event) => event.who || ''))].filter(Boolean).sort().map((who) => el('option', { value: who, selected: who === before?.who.value }, who)));
    this.text = el('input', { type: 'search', placeholder: 'text', 'aria-label': 'text of events', oninput: changed });
    this.text.value = before?.text.value || '';
    this.count = el('span', { class: 'note' });
    this.body = el('tbody', {});
    this.more = el('button', { type: 'button', onclick: () => { this.most *= 4; this.show(); } }, 'show more');
    const filters = [...this.kinds].map(([kind, box]) => {
      const look = axis.kinds.look(kind);
      return el('label', { class: 'chip' + look.class, style: look.style }, box, ' ' + kind);
    });
    this.box = el('section', { class: 'event-table' }, el('h2', {}, 'Events'),
      el('div', { class: 'filters' }, ...filters, this.who, this.text, this.count),
      el('div', { class: 'scroll' }, el('table', {},
        el('thead', {}, el('tr', {}, ...['time', 'kind', 'who', 'what', 'why'].map((head) => el('th', {}, head)))), this.body)), this.more);
    this.show();
    axis.listen(axis.clock, () => this.follow());
  }

  get chosen() {
    const text = this.text.value.toLowerCase(), who = this.who.value;
    return this.events.filter((event) => this.kinds.get(event.kind).checked && (!who || event.who === who) &&
      (!text || [event.text, event.reason, event.who, event.kind].some((part) => (part || '').toLowerCase().includes(text))));
  }

  show() {
    const chosen = this.chosen;
    this.rows = chosen.slice(0, this.most).map((event) => {
      const task = this.taskOf(event.task), look = this.axis.kinds.look(event.kind);
      const row = el('tr', {}, el('td', {}, timeButton(this.axis.clock, event.t)),
        el('td', {}, el('span', { class: 'chip' + look.class, style: look.style }, event.kind)),
        el('td', {}, event.who ? el('button', { type: 'button', class: 'link', onclick: () => this.choice.chooseName(event.who || '') }, event.who) : ''),
        el('td', {}, task ? el('button', { type: 'button', class: 'link', onclick: () => this.choice.chooseTask(task) }, event.text) : event.text),
        el('td', {}, event.reason || ''));
      return { t: event.t, row };
    });
    this.body.replaceChildren(...this.rows.map((one) => one.row));
    this.count.textContent = chosen.length + ' of ' + this.events.length;
    this.more.hidden = chosen.length <= this.most;
    this.now = null;
    this.follow();
  }

  /** The last that has happened stands out. */
  follow() {
    let now = null;
    for (const one of this.rows || []) if (one.t !== null && one.t <= this.axis.clock.t) now = one.row;
    if (now === this.now) return;
    this.now?.classList.remove('now');
    now?.classList.add('now');
    this.now = now;
  }

  /** To the next event of those chosen, or the one before. */
  jump(/** @type {number} */ direction) {
    const { clock } = this.axis;
    const times = this.chosen.flatMap((event) => (event.t === null ? [] : [event.t]));
    const next = direction > 0 ? times.find((t) => t > clock.t + 1e-6) : times.filter((t) => t < clock.t - 1e-6).pop();
    if (next !== undefined) clock.seek(next);
  }
}
