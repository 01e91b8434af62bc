// Facts at the time that is shown, who made them, and how they changed.

import { el, timeButton } from '../run/draw.js';

const MOST_FACTS = 3000, FACTS_AT_FIRST = 150;

/** "(order (id 3) (state NEW))" as "order" and its parts "(id 3)", "(state NEW)". */
export function partsOf(/** @type {string} */ text) {
  const parts = [];
  let depth = 0, quoted = false, from = 1;
  for (let i = 0; i < text.length; ++i) {
    const c = text[i];
    if (quoted) {
      if (c === '\\') ++i;
      else if (c === '"') quoted = false;
      continue;
    }
    if (c === '"') quoted = true;
    else if (c === '(') ++depth;
    else if (c === ')') --depth;
    if ((c === ' ' && depth === 1) || (c === ')' && depth === 0)) {
      if (i > from) parts.push(text.slice(from, i));
      from = i + 1;
    }
  }
  return { head: parts[0] || text, slots: parts.slice(1) };
}

/** A fact with its template in bold; slots that are not in `before` stand out. */
export function factText(/** @type {string} */ text, /** @type {string|undefined} */ before = undefined) {
  const { head, slots } = partsOf(text), known = before === undefined ? null : new Set(partsOf(before).slots);
  return el('code', { class: 'fact' }, '(', el('b', {}, head), ...slots.flatMap((slot) => [' ', known && !known.has(slot) ? el('mark', {}, slot) : slot]), ')');
}

/** Whether a fact has that word: a part of its text, or `state=DONE` (a slot, or any slot of the template), or `=robot1` (any slot). */
export function hasWord(/** @type {string} */ word, /** @type {string} */ text) {
  const at = word.indexOf('=');
  if (at < 0) return text.toLowerCase().includes(word.toLowerCase());
  const name = word.slice(0, at), value = word.slice(at + 1), { head, slots } = partsOf(text);
  return slots.some((slot) => {
    const inner = slot.startsWith('(') ? slot.slice(1, -1) : slot, space = inner.indexOf(' ');
    const values = slot.startsWith('(') ? inner.slice(space + 1) : inner;
    return (!name || head === name || (slot.startsWith('(') && inner.slice(0, space) === name)) && values.split(' ').some((one) => one === value || one === '"' + value + '"');
  });
}

const spelled = (/** @type {any} */ value) => (Array.isArray(value) ? value.map(String).join(' ') : String(value));
/** As rules write it. */
export function textOfFact(/** @type {import('./served.js').Fact} */ fact) {
  const last = fact.changes[fact.changes.length - 1];
  if (last) return last.text;
  return '(' + [fact.template, ...Object.entries(fact.slots).map(([name, value]) => (name === 'implied' ? spelled(value) : `(${name} ${spelled(value)})`))].join(' ') + ')';
}

const DONE = new Map([['assert', 'asserted'], ['decision', 'asserted'], ['modify', 'changed'], ['retract', 'retracted']]);
export const done = (/** @type {string} */ what) => DONE.get(what) || what;

/** "by rule order-begin"; the rule opens its source. */
export function doerText(/** @type {import('./served.js').Doer} */ by, /** @type {import('./ask.js').Ask} */ ask) {
  const outside = { person: 'by a person', what_if: 'by a planned change', start: 'when the environment started', executive: 'by the executive or a plugin' };
  if (by.kind === 'rule') return [' by rule ', ruleButton(by.name || '', ask)];
  if (by.kind === 'input') return [' from outside: ' + (by.name || '')];
  return [' ' + (/** @type {any} */ (outside)[by.kind] || by.kind) + (by.name ? ': ' + by.name : '')];
}

export function ruleButton(/** @type {string} */ rule, /** @type {import('./ask.js').Ask} */ ask) {
  return el('button', { type: 'button', class: 'link', title: 'its source, and what it lacks', onclick: () => ask.showRule(rule) }, rule);
}
export function askButton(/** @type {string} */ text, /** @type {string} */ title, /** @type {() => void} */ act) {
  return el('button', { type: 'button', class: 'ask', title, onclick: act }, text);
}

/** All that is known of a fact. */
export function factDetails(/** @type {import('./served.js').Fact} */ fact, /** @type {import('./ask.js').Ask} */ ask) {
  const { clock } = ask.page;
  const text = textOfFact(fact), what = fact.fact || text;
  const changes = fact.changes.map((change, i) => el('tr', {},
    el('td', {}, timeButton(clock, Math.max(0, change.t_s))),
    el('td', {}, el('div', {}, done(change.what), ...doerText(change.by, ask)), factText(change.text, i ? fact.changes[i - 1].text : undefined))));
  return [el('h3', {}, fact.fact || fact.template, fact.present ? '' : el('span', { class: 'note' }, ' has gone')), factText(text),
    el('p', { class: 'buttons' }, askButton('why', 'how it came about', () => ask.why(what)),
      fact.present ? askButton('who waits for it', 'rules that need it, and what they lack', () => ask.whyNot(what)) : '',
      askButton('makers and users', 'rules that make such facts, and those that need them', () => ask.usersOf(what))),
    changes.length ? el('table', { class: 'changes' }, ...changes) : el('p', { class: 'note' }, 'nothing was recorded of it')];
}

export class Facts {
  constructor(/** @type {import('./ask.js').Ask} */ ask) {
    this.ask = ask;
    this.name = 'facts';
    this.title = 'Facts';
    this.follows = true;
    this.what = el('input', { type: 'search', placeholder: 'words, order=3, a template, (order (id 3)) or f-12', 'aria-label': 'which facts', list: 'templates',
      oninput: () => this.typed(), onchange: () => this.ask.refresh() });
    this.templates = el('datalist', { id: 'templates' });
    this.changed = el('input', { type: 'checkbox', checked: true, onchange: () => this.list() });
    this.count = el('span', { class: 'note' });
    this.body = el('tbody', {});
    this.more = el('button', { type: 'button', hidden: true, onclick: () => { this.most *= 4; this.list(); } }, 'show more');
    this.box = el('div', {}, el('div', { class: 'filters' }, this.what, this.templates, el('label', {}, this.changed, ' the latest changes first'), this.count),
      el('table', { class: 'facts' }, this.body), this.more);
    this.most = FACTS_AT_FIRST;
    /** @type {import('./served.js').Fact[]} */
    this.facts = [];
    /** @type {Set<string>} */
    this.known = new Set();
  }

  /** What the server is to find; words are found here. */
  get pattern() {
    const text = this.what.value.trim();
    return text.startsWith('(') || /^f-\d+$/.test(text) || this.known.has(text) ? text : '';
  }
  typed() {
    // A pattern is asked for when it is complete: with Enter.
    if (!this.what.value.trim().startsWith('(')) this.list();
    this.ask.page.address.later();
  }

  async load() {
    const pattern = this.pattern;
    const answer = await this.ask.question('facts', { what: pattern, limit: MOST_FACTS, brief: true });
    if (!answer) return;
    this.facts = answer.facts;
    this.total = answer.total ?? answer.facts.length;
    if (!pattern) {
      this.known = new Set(this.facts.map((fact) => fact.template));
      this.templates.replaceChildren(...[...this.known].sort().map((name) => el('option', { value: name })));
    }
    this.shown = pattern;
    this.list();
  }

  list() {
    /** @type {string[]} */
    const words = this.shown || this.what.value.trim().startsWith('(') ? [] : this.what.value.split(/\s+/).filter(Boolean);
    let found = this.facts.map((fact) => ({ fact, text: textOfFact(fact) })).filter((one) => words.every((word) => hasWord(word, one.text)));
    const lastOf = (/** @type {import('./served.js').Fact} */ fact) => fact.changes[fact.changes.length - 1]?.n ?? -1;
    if (this.changed.checked) found = found.sort((a, b) => lastOf(b.fact) - lastOf(a.fact));
    this.count.textContent = found.length + ' of ' + (this.total || this.facts.length) + ' facts';
    this.body.replaceChildren(...found.slice(0, this.most).map((one) => this.row(one.fact, one.text)));
    this.more.hidden = found.length <= this.most;
  }
  row(/** @type {import('./served.js').Fact} */ fact, /** @type {string} */ text) {
    const { ask } = this, first = fact.changes[0], last = fact.changes[fact.changes.length - 1];
    const made = (/** @type {import('./served.js').Change} */ change) => [done(change.what) + ' ', timeButton(ask.page.clock, Math.max(0, change.t_s)), ...doerText(change.by, ask)];
    return el('tr', {},
      el('td', {}, el('button', { type: 'button', class: 'link', title: 'why it is there', onclick: () => ask.why(fact.fact || text) }, fact.fact || '')),
      el('td', {}, el('button', { type: 'button', class: 'plain', title: 'its history', onclick: () => ask.showFact(fact.fact || text) }, factText(text)),
        el('div', { class: 'note' }, ...(first ? made(first) : []), ...(last && last !== first ? ['; last ', ...made(last)] : []))));
  }
}
