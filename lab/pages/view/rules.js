// Rules: their source, what they did, those that wait to fire, and global variables.

import { el, timeButton } from '../run/draw.js';
import { askButton, factText, ruleButton } from './facts.js';
import { sortedTable } from './sorted.js';

const MOST_FIRINGS = 300;

/**
 * @typedef {{ condition: number, text: string, line: number, end_line: number, holds: boolean|null }} Condition
 * @typedef {{ rule: string, file: string|null, first_line: number, text: string, conditions?: Condition[]|null, because?: string|null }} Source
 */

/** @type {Object<string, string>} */
const SAID = { holds: ' holds', fails: ' does not hold', unsure: ': not looked at, because one before it does not hold' };

/** The rule as it is written. With `marks`: which conditions hold, and the first that does not. */
export function sourceView(/** @type {Source} */ source, marks = true) {
  const lines = source.text.split('\n');
  return el('div', { class: 'source scroll', tabindex: 0, role: 'group', 'aria-label': 'source of ' + source.rule }, ...lines.flatMap((line, i) => {
    const number = source.first_line + i;
    const of = marks ? (source.conditions || []).find((one) => one.line <= number && number <= one.end_line) : undefined;
    const state = !of ? '' : of.holds === true ? 'holds' : of.holds === false ? 'fails' : 'unsure';
    const row = el('div', { class: 'code ' + state, 'data-condition': of ? of.condition : undefined, title: of ? 'condition ' + of.condition + SAID[state] : undefined },
      el('span', { class: 'number', 'aria-hidden': 'true' }, number), el('code', {}, line || ' '));
    const ends = of && state === 'fails' && number === of.end_line;
    return ends && source.because ? [row, el('div', { class: 'because' }, 'condition ' + of.condition + ' does not hold: ' + source.because)] : [row];
  }));
}

class Tab {
  constructor(/** @type {import('./ask.js').Ask} */ ask, /** @type {string} */ name, /** @type {string} */ title) {
    this.ask = ask;
    this.name = name;
    this.title = title;
    this.follows = true;
    this.list = el('div', { class: 'scroll' });
    this.box = el('div', {}, this.list);
  }
  time(/** @type {number|null|undefined} */ t) {
    return t === null || t === undefined ? '' : timeButton(this.ask.page.clock, Math.max(0, t));
  }
}

export class Agenda extends Tab {
  constructor(/** @type {import('./ask.js').Ask} */ ask) {
    super(ask, 'agenda', 'Agenda');
  }
  async load() {
    const answer = await this.ask.question('agenda', {});
    if (!answer) return;
    const rows = answer.agenda.map((/** @type {any} */ one, /** @type {number} */ i) => el('tr', {}, el('td', { class: 'number' }, i + 1), el('td', { class: 'number' }, one.salience),
      el('td', {}, ruleButton((one.module === 'MAIN' ? '' : one.module + '::') + one.rule, this.ask)),
      el('td', {}, ...one.facts.flatMap((/** @type {string|null} */ fact) => [fact ? el('button', { type: 'button', class: 'link', title: 'its history', onclick: () => this.ask.showFact(fact) }, fact) : '*', ' ']))));
    this.list.replaceChildren(rows.length
      ? el('table', {}, el('tr', {}, ...['', 'salience', 'rule', 'facts'].map((head) => el('th', {}, head))), ...rows)
      : el('p', {}, 'No rule waits when the tick is over. A step forward goes to where one does.'),
    answer.focus.length ? el('p', { class: 'note' }, 'in focus: ' + answer.focus.join(', ')) : '');
  }
}

export class Globals extends Tab {
  constructor(/** @type {import('./ask.js').Ask} */ ask) {
    super(ask, 'globals', 'Globals');
  }
  async load() {
    const answer = await this.ask.question('globals', {});
    if (!answer) return;
    const rows = Object.entries(answer.globals).map(([name, value]) => el('tr', {}, el('th', {}, '?*' + name + '*'), el('td', {}, el('code', {}, Array.isArray(value) ? '(' + value.join(' ') + ')' : String(value)))));
    this.list.replaceChildren(rows.length ? el('table', {}, ...rows) : el('p', {}, 'There is no global variable.'));
  }
}

export class Rules extends Tab {
  constructor(/** @type {import('./ask.js').Ask} */ ask) {
    super(ask, 'rules', 'Rules');
    this.text = el('input', { type: 'search', placeholder: 'text', 'aria-label': 'text of rules', oninput: () => this.show() });
    this.which = el('select', { 'aria-label': 'which rules', onchange: () => this.show() },
      ...['all rules', 'fired', 'waited in vain', 'never matched'].map((one) => el('option', { value: one }, one)));
    this.count = el('span', { class: 'note' });
    this.box.prepend(el('div', { class: 'filters' }, this.text, this.which, this.count));
    /** @type {any[]} */
    this.rules = [];
  }
  async load() {
    const answer = await this.ask.question('rules', {});
    if (!answer) return;
    this.rules = answer.rules;
    this.show();
  }
  show() {
    const words = this.text.value.toLowerCase(), which = this.which.value;
    const state = (/** @type {any} */ rule) => (rule.fired ? 'fired' : rule.activated ? 'waited in vain' : 'never matched');
    const found = this.rules.filter((rule) => (which === 'all rules' || state(rule) === which) && (rule.rule + ' ' + (rule.place || '') + ' ' + (rule.unmet?.text || '')).toLowerCase().includes(words));
    this.count.textContent = found.length + ' of ' + this.rules.length;
    this.list.replaceChildren(sortedTable(['rule', 'fired', 'on the agenda', 'first', 'last', 'what it lacks'], found.map((rule) => ({
      cells: [[ruleButton(rule.rule, this.ask), el('div', { class: 'note' }, rule.place || '')], rule.fired, rule.activated ?? '', this.time(rule.first_s), this.time(rule.last_s),
        rule.unmet ? el('button', { type: 'button', class: 'plain', title: 'why it has not fired', onclick: () => this.ask.whyNot(rule.rule) },
          'condition ' + rule.unmet.condition + ': ', el('code', {}, rule.unmet.text), ' ' + rule.unmet.because) : state(rule) === 'fired' ? '' : state(rule)],
      keys: [rule.rule, rule.fired, rule.activated ?? null, rule.first_s ?? null, rule.last_s ?? null, rule.unmet ? rule.unmet.text : state(rule) === 'fired' ? null : state(rule)],
    }))));
  }
}

export class Firings extends Tab {
  constructor(/** @type {import('./ask.js').Ask} */ ask) {
    super(ask, 'firings', 'Firings');
    this.rule = el('input', { type: 'search', placeholder: 'all rules', 'aria-label': 'firings of which rule', onchange: () => this.ask.refresh() });
    this.count = el('span', { class: 'note' });
    this.box.prepend(el('div', { class: 'filters' }, this.rule, this.count));
  }
  async load() {
    const answer = await this.ask.question('firings', { rule: this.rule.value.trim(), limit: MOST_FIRINGS });
    if (!answer) return;
    const firings = [...answer.firings].reverse();
    this.count.textContent = firings.length ? 'the last ' + firings.length + ' of ' + (answer.total ?? firings.length) + ', the latest first' : 'none so far';
    this.list.replaceChildren(el('table', {}, ...firings.map((one) => el('tr', {}, el('td', {}, this.time(one.t_s)),
      el('td', {}, ruleButton(one.rule, this.ask)),
      el('td', {}, el('button', { type: 'button', class: 'plain', title: 'what it matched', onclick: () => this.ask.showDetail('', ...firingDetails(one, this.ask)) },
        el('code', {}, valuesText(one.values) || '(' + one.facts.length + ' facts)')))))));
  }
}

export const valuesText = (/** @type {Object<string, string>|undefined} */ values) => Object.entries(values || {}).map(([name, value]) => '?' + name + ' = ' + value).join('  ');

function firingDetails(/** @type {any} */ firing, /** @type {import('./ask.js').Ask} */ ask) {
  const values = Object.entries(firing.values);
  return [el('h3', {}, 'rule ', ruleButton(firing.rule, ask), ' at ', timeButton(ask.page.clock, Math.max(0, firing.t_s))), el('p', { class: 'note' }, firing.place || ''),
    el('p', { class: 'buttons' }, askButton('why', 'why it fired the last time', () => ask.why(firing.rule))),
    values.length ? el('table', {}, ...values.map(([name, value]) => el('tr', {}, el('th', {}, '?' + name), el('td', {}, el('code', {}, value))))) : '',
    el('h3', {}, 'It matched'), ...firing.facts.map((/** @type {string} */ fact) => el('p', {}, factText(fact)))];
}
