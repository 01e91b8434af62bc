// Who makes facts, and who needs them.

import { el, timeButton } from '../run/draw.js';
import { factText, ruleButton } from './facts.js';
import { sortedTable } from './sorted.js';

const HINT = 'a template, a pattern (order (state NEW)) or a fact (f-12)';

export class Users {
  constructor(/** @type {import('./ask.js').Ask} */ ask) {
    this.ask = ask;
    this.name = 'users';
    this.title = 'Makers and users';
    this.follows = true;
    this.asks = true;
    this.what = el('input', { type: 'search', placeholder: HINT, 'aria-label': 'of which facts', list: 'words', oninput: () => ask.complete(this.what.value), onchange: () => { ask.what = this.what.value.trim(); ask.refresh(); } });
    this.list = el('div', {});
    this.box = el('div', {}, el('div', { class: 'filters' }, this.what), this.list);
  }
  async load() {
    const { ask } = this, { what } = ask;
    this.what.value = what;
    if (!what) return this.list.replaceChildren(el('p', { class: 'note' }, 'Write ' + HINT + '.'));
    const makers = await ask.question('producers', { what });
    const users = makers && await ask.question('consumers', { what });
    if (!users) return undefined;
    return this.list.replaceChildren(el('h3', {}, 'Rules that make ' + makers.pattern), this.makers(makers.rules), el('h3', {}, 'Rules that need such facts'), ...this.users(users));
  }
  time(/** @type {number|undefined} */ t) {
    return t === undefined ? '' : timeButton(this.ask.page.clock, Math.max(0, t));
  }
  rule(/** @type {any} */ one) {
    return [ruleButton(one.rule, this.ask), el('div', { class: 'note' }, one.place)];
  }
  lacks(/** @type {any} */ one) {
    return one.lacks ? el('button', { type: 'button', class: 'plain', title: 'why it does not fire', onclick: () => this.ask.whyNot(one.rule) }, one.lacks) : '';
  }
  makers(/** @type {any[]} */ rules) {
    if (!rules.length) return el('p', {}, 'None.');
    return sortedTable(['rule', 'how', 'fired', 'last', 'what it lacks'], rules.map((one) => ({ cells: [this.rule(one), one.how + (one.through ? ' by ' + one.through : ''), one.fired, this.time(one.last_s), this.lacks(one)],
      keys: [one.rule, one.how, one.fired, one.last_s ?? null, one.lacks || ''] })));
  }
  users(/** @type {any} */ answer) {
    const all = [...(answer.waiting || []).map((/** @type {any} */ one) => ({ ...one, how: 'needs it' })), ...(answer.nearly || []).map((/** @type {any} */ one) => ({ ...one, how: 'needs another value: ' + one.differs })),
      ...(answer.forbidden || []).map((/** @type {any} */ one) => ({ ...one, how: 'must not have it' }))];
    const about = answer.fact ? [el('p', {}, answer.fact + ' ', factText(answer.text))] : [el('p', {}, 'No such fact is there.' + (answer.nearest ? ' ' + answer.nearest : ''))];
    if (!all.length) return [...about, answer.fact ? el('p', {}, 'None.') : ''];
    return [...about, sortedTable(['rule', 'condition', 'how', 'fired for it', 'last', 'what it lacks'], all.map((one) => ({ cells: [this.rule(one), el('code', {}, one.condition), one.how, one.fired, this.time(one.last_s), this.lacks(one)],
      keys: [one.rule, one.condition, one.how, one.fired, one.last_s ?? null, one.lacks || ''] })))];
  }
}
