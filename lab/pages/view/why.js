// Why something is so, and why not, as graphs. They stay as they were asked while their boxes lead to other times.

import { el } from '../run/draw.js';
import { timeText } from '../run/time.js';
import { askButton, done, factText } from './facts.js';
import { Graph } from './graph.js';
import { valuesText } from './rules.js';

/**
 * @typedef {import('./graph.js').Node} Node
 * @typedef {import('./graph.js').Row} Row
 * @typedef {{ n: number, t_s: number, kind: string, text: string, fact?: string, place?: string, values?: Object<string, string>, because: number[],
 *   outside?: string, note?: string, asserted?: { t_s: number, by: import('./served.js').Doer } }} Step
 */

const LONGEST_WAY = 30; // boxes that are opened at first
const FACT_KINDS = ['assert', 'modify', 'retract', 'decision'];
const FIRED = 'fire';

/** A field for what is asked, and the graph of the answer. */
class GraphTab {
  constructor(/** @type {import('./ask.js').Ask} */ ask, /** @type {string} */ name, /** @type {string} */ title, /** @type {string} */ hint) {
    this.ask = ask;
    this.name = name;
    this.title = title;
    this.follows = false;
    this.asks = true;
    this.hint = hint;
    this.graph = new Graph();
    this.what = el('input', { type: 'search', placeholder: hint, 'aria-label': title, list: 'words', onchange: () => this.begin(), oninput: () => ask.complete(this.what.value) });
    this.again = el('button', { type: 'button', hidden: true, onclick: () => this.begin() });
    this.asked = el('span', { class: 'note' });
    this.box = el('div', { class: 'asked' }, el('div', { class: 'filters' }, this.what, el('button', { type: 'button', onclick: () => this.begin() }, 'ask'), this.again, this.asked), this.graph.problem, this.graph.box);
    /** @type {number|null} */
    this.t = null;
    this.shown = '';
    /** @type {Step[]} */
    this.steps = [];
    ask.page.clock.listen(() => this.compare());
  }
  /** Asks about the time that is shown. */
  begin() {
    this.t = null;
    this.ask.what = this.what.value.trim();
    return this.ask.refresh();
  }
  async load() {
    const what = this.ask.what;
    this.what.value = what;
    if (!what) {
      this.graph.clear();
      this.asked.textContent = 'Write ' + this.hint + ', or click a fact or a rule.';
      return;
    }
    if (this.t !== null && this.shown === what) return;
    const root = await this.answer(what);
    if (!root) return;
    this.shown = what;
    const asked = this.ask.page.clock.t;
    this.graph.problem.textContent = '';
    this.graph.start(root);
    await this.follow(root);
    this.graph.box.scrollTo(0, 0);
    this.t = asked; // from now on clicks go to other times
    this.compare();
  }
  compare() {
    if (this.t === null) return;
    const { t } = this.ask.page.clock;
    this.asked.textContent = 'as of ' + timeText(this.t);
    this.again.hidden = t === this.t;
    this.again.textContent = 'ask again at ' + timeText(t);
  }
  /** @returns {Promise<Node|undefined>} */
  async answer(/** @type {string} */ what) {
    throw new Error(what);
  }
  async follow(/** @type {Node} */ root) {
    this.ask.page.address.later();
    root.act?.();
  }
}

export class Why extends GraphTab {
  constructor(/** @type {import('./ask.js').Ask} */ ask) {
    super(ask, 'why', 'Why', 'a fact (f-12), a pattern (order (id 3)) or a rule');
  }
  async answer(/** @type {string} */ what) {
    const answer = await this.ask.question('why', { what });
    if (!answer) return undefined;
    this.steps = answer.steps;
    return this.nodeOf(0);
  }
  /**
   * The box of a firing, of the fact that was asked about, or of what came from outside.
   * @returns {Node}
   */
  nodeOf(/** @type {number} */ index) {
    const step = this.steps[index], key = String(step.n), at = timeText(Math.max(0, step.t_s), 3);
    const show = () => this.show(step);
    if (step.kind === FIRED)
      return { key, kind: 'rule', title: step.text, lines: [at + (step.place ? '  ' + step.place : ''), valuesText(step.values)].filter(Boolean), rows: step.because.map((one) => this.rowOf(one)), act: show };
    if (!FACT_KINDS.includes(step.kind)) return { key, kind: 'outside', title: step.text, lines: [at + ', from outside', step.outside || step.note || ''].filter(Boolean), rows: [], act: show };
    const lines = [done(step.kind) + ' at ' + at, step.note || '', step.asserted ? 'asserted at ' + timeText(Math.max(0, step.asserted.t_s), 3) : ''];
    return { key, kind: 'fact', title: step.text, lines: lines.filter(Boolean), rows: step.because.length ? [{ text: done(step.kind) + ' by', open: () => step.because.map((one) => this.nodeOf(one)) }] : this.outsideRow(step), act: show };
  }
  /**
   * A fact that a rule matched; it leads to the rule that made it so.
   * @returns {Row}
   */
  rowOf(/** @type {number} */ index) {
    const step = this.steps[index];
    if (!FACT_KINDS.includes(step.kind)) return { text: step.text, open: () => [this.nodeOf(index)] };
    const more = done(step.kind) + ' at ' + timeText(Math.max(0, step.t_s), 3) + (step.note ? ' ' + step.note : '') + (step.outside ? ', from ' + step.outside : '');
    return { text: step.text, more, kind: 'fact', act: () => this.show(step), open: step.because.length ? () => step.because.map((one) => this.nodeOf(one)) : undefined };
  }
  /** @returns {Row[]} */
  outsideRow(/** @type {Step} */ step) {
    return step.outside ? [{ text: 'from ' + step.outside }] : [];
  }

  /** The latest cause of each box, up to what came from outside; not through a rule that stands there already. */
  async follow(/** @type {Node} */ root) {
    const seen = new Set();
    let node = root;
    for (let length = 0; length < LONGEST_WAY; ++length) {
      seen.add(node.title);
      const row = node.rows.find((one) => one.open);
      const [next] = (await row?.open?.()) || [];
      if (!row || !next || seen.has(next.title)) break;
      const [fresh] = await this.graph.open(node, row);
      if (!fresh) break;
      node = fresh;
    }
    await super.follow(root);
  }

  /** Goes to the time of a step, and shows it. */
  show(/** @type {Step} */ step) {
    const { ask } = this;
    if (this.t !== null) ask.page.clock.seek(Math.max(0, step.t_s));
    if (step.kind === FIRED) return ask.showRule(step.text, { values: step.values, marks: false, title: 'fired at ' + timeText(Math.max(0, step.t_s), 3) });
    const what = step.fact || step.text;
    return ask.showDetail(what, el('h3', {}, step.fact || (FACT_KINDS.includes(step.kind) ? 'a fact' : step.kind)), FACT_KINDS.includes(step.kind) ? factText(step.text) : el('p', {}, step.text),
      el('p', { class: 'note' }, done(step.kind) + ' at ' + timeText(Math.max(0, step.t_s), 3) + (step.note ? ' ' + step.note : '') + (step.outside ? ', from ' + step.outside + ' of the journal' : '')),
      FACT_KINDS.includes(step.kind) ? el('p', { class: 'buttons' }, askButton('who waits for it', 'rules that need it, and what they lack', () => ask.whyNot(what)),
        step.fact ? askButton('its history', 'each of its changes', () => ask.showFact(what)) : '') : '');
  }
}

const isAboutFact = (/** @type {string} */ what) => what.startsWith('(') || what.startsWith('f-');

export class WhyNot extends GraphTab {
  constructor(/** @type {import('./ask.js').Ask} */ ask) {
    super(ask, 'why-not', 'Why not', 'a rule, a fact (f-12) or a pattern (product (order 2))');
  }
  async answer(/** @type {string} */ what) {
    const answer = await this.ask.question('why_not', { what });
    if (!answer) return undefined;
    return isAboutFact(what) ? this.factNode(what, answer) : this.ruleNode(what, answer);
  }

  async follow(/** @type {Node} */ root) {
    for (const row of root.rows) if (row.atOnce) await this.graph.open(root, row);
    await super.follow(root);
  }

  /**
   * A rule and its conditions; the one that does not hold leads to the rules that could change that.
   * @returns {Node}
   */
  ruleNode(/** @type {string} */ rule, /** @type {any} */ answer) {
    const found = answer.explanations[0], unmet = found.first_unmet;
    const lines = [found.file + ':' + found.line, verdictText(found), found.fired ? 'fired ' + found.fired + ' times, the last at ' + timeText(found.last_fired_s, 3) : 'has not fired so far'];
    /** @type {Row[]} */
    const rows = [];
    for (const one of found.conditions || (unmet ? [{ condition: unmet.condition, text: unmet.pattern || '', holds: false }] : [])) {
      const fails = one.condition === unmet?.condition;
      rows.push({ kind: fails ? 'fails' : one.holds ? 'holds' : 'unsure', text: one.condition + '  ' + one.text, below: fails ? unmet.because : '', atOnce: fails,
        open: fails && found.makers ? () => this.makerNodes(found.makers) : undefined });
    }
    if (unmet?.fact)
      rows.push({ kind: 'fact', text: unmet.fact, act: () => this.ask.showDetail(unmet.fact, el('h3', {}, 'the nearest fact'), factText(unmet.fact),
        el('p', { class: 'buttons' }, askButton('why', 'how it came about', () => this.ask.why(unmet.fact)))) });
    for (const fact of (found.holds?.facts || [])) rows.push({ kind: 'fact', text: fact });
    if (found.lost) rows.push({ kind: '', text: 'was on the agenda up to ' + timeText(found.lost.t_s, 3) + ', until ' + (found.lost.by ? 'rule ' + found.lost.by : 'something outside of rules') + ' took it off',
      act: () => { this.ask.page.clock.seek(found.lost.t_s); if (found.lost.by) this.ask.showRule(found.lost.by); } });
    return { key: 'rule ' + rule, kind: 'rule', title: rule, lines, rows, act: () => this.ask.showRule(rule, { t: this.t }) };
  }

  /**
   * Rules that could bring it about, and what became of the fact that was there.
   * @returns {Node[]}
   */
  makerNodes(/** @type {any} */ makers) {
    /** @type {Node[]} */
    const nodes = [];
    if (makers.last_made) {
      const { last_made: made, then } = makers;
      const row = (/** @type {string} */ what, /** @type {any} */ change) => ({ text: what + ' at ' + timeText(Math.max(0, change.t_s), 3) + ' by ' + change.by, act: () => {
        this.ask.page.clock.seek(Math.max(0, change.t_s));
        if (change.by.startsWith('rule ')) this.ask.showRule(change.by.slice(5));
      } });
      nodes.push({ key: 'last ' + made.fact + made.t_s, kind: 'fact', title: made.fact, lines: ['the last fact that matched ' + makers.pattern], rows: [row(done(made.what), made), ...(then ? [row(done(then.what), then)] : [])],
        act: () => this.ask.page.clock.seek(Math.max(0, made.t_s)) });
    }
    for (const one of makers.rules) {
      const fired = one.fired ? 'fired ' + one.fired + ' times, the last at ' + timeText(one.last_s, 3) : 'has not fired so far';
      nodes.push({ key: 'maker ' + one.rule, kind: 'rule', title: one.rule, lines: [one.place, one.how + ' such facts' + (one.through ? ' by ' + one.through : '') + '; ' + fired],
        rows: one.lacks ? [this.lacksRow(one.rule, one.lacks)] : [], act: () => this.ask.showRule(one.rule, { t: this.t }) });
    }
    return nodes.length ? nodes : [{ key: 'nobody ' + makers.pattern, kind: 'outside', title: 'no rule ' + (makers.forbids ? 'takes such a fact away' : 'makes such a fact'), lines: [makers.pattern], rows: [] }];
  }
  /** @returns {Row} */
  lacksRow(/** @type {string} */ rule, /** @type {string} */ lacks) {
    return { kind: 'fails', text: 'lacks ' + lacks.split(': ')[0], below: lacks.slice(lacks.indexOf(': ') + 2), act: () => this.ask.showRule(rule, { t: this.t }), open: async () => {
      const answer = await this.ask.question('why_not', { what: rule }, this.t);
      const found = answer.explanations[0];
      return found.makers ? this.makerNodes(found.makers) : [];
    } };
  }

  /**
   * A fact and the rules that need it; a fact that is missing and the rules that could make it.
   * @returns {Node}
   */
  factNode(/** @type {string} */ what, /** @type {any} */ answer) {
    if (!answer.fact) {
      /** @type {Row[]} */
      const rows = answer.makers ? [{ text: 'rules that could make it', kind: 'fails', atOnce: true, open: () => this.makerNodes(answer.makers) }] : [];
      return { key: 'fact', kind: 'fact', title: what, lines: ['no fact matches', answer.nearest || ''].filter(Boolean), rows };
    }
    const row = (/** @type {any} */ user, /** @type {string} */ kind, /** @type {string} */ below) => ({ kind, text: user.rule, below, more: user.place + '  ' + user.condition,
      act: () => this.ask.showRule(user.rule, { t: this.t }), open: async () => [this.ruleNode(user.rule, await this.ask.question('why_not', { what: user.rule }, this.t))] });
    const fired = (/** @type {any} */ user) => (user.fired ? 'has fired for it' + (user.last_s ? ' at ' + timeText(user.last_s, 3) : '') : 'has not fired for it') + (user.lacks ? ', lacks ' + user.lacks : '');
    return { key: 'fact', kind: 'fact', title: answer.text, lines: [answer.fact + ', rules that need it:'], act: () => this.ask.showFact(answer.fact), rows: [
      ...answer.waiting.map((/** @type {any} */ user) => row(user, user.lacks ? 'fails' : 'holds', fired(user))),
      ...answer.nearly.map((/** @type {any} */ user) => row(user, 'unsure', 'needs another value: ' + user.differs)),
      ...(answer.forbidden || []).map((/** @type {any} */ user) => row(user, 'unsure', 'must not have it'))] };
  }
}

function verdictText(/** @type {any} */ found) {
  if (found.verdict === 'condition') return 'condition ' + found.first_unmet.condition + ' does not hold';
  if (found.verdict === 'waiting') return 'all conditions hold: ' + found.agenda.above + ' activations stand above it';
  if (found.verdict === 'focus') return 'all conditions hold, but its module is not in focus';
  if (found.verdict === 'fired') return 'all conditions hold, and it fired for that at ' + timeText(found.holds.fired_s, 3);
  return 'all conditions hold, but it is not on the agenda: a test has not been evaluated again';
}
