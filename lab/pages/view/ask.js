// Questions about the rules of the run, at the time that the page shows: a panel that follows the slider.

import { additions } from '../run/data.js';
import { el } from '../run/draw.js';
import { timeText } from '../run/time.js';
import { askButton, factDetails, Facts, ruleButton } from './facts.js';
import { Live } from './live.js';
import { Agenda, Firings, Globals, Rules, sourceView, valuesText } from './rules.js';
import { request, Turns } from './served.js';
import { Users } from './users.js';
import { Why, WhyNot } from './why.js';

const REST_MS = 200; // the slider rests so long before something is asked
const KEYS_OF_ASK = [[', .', 'one firing back or on'], ['a', 'asks: to the field of the panel']];

export class Ask {
  constructor(/** @type {import('../run/main.js').Page} */ page) {
    this.page = page;
    this.turns = new Turns();
    this.env = '';
    this.what = '';
    this.live = false;
    /** The time of the slider that stands for a place between two firings. @type {number|null} */
    this.stood = null;
    this.asked = 0;
    /** @type {(place: import('./served.js').Stand) => void} is told where the run is */
    this.placed = () => {};
    this.waits = 0;
    this.envs = el('select', { 'aria-label': 'environment', onchange: () => { this.env = this.envs.value; this.refresh(); } });
    this.place = el('output', { class: 'place' });
    this.problem = el('p', { class: 'bad', role: 'alert', hidden: true });
    this.until = el('input', { type: 'search', list: 'words', placeholder: 'rule, (fact) or time', 'aria-label': 'up to which rule, fact or time',
      oninput: () => this.complete(this.until.value), onkeydown: (/** @type {KeyboardEvent} */ event) => { if (event.key === 'Enter') this.go({ [event.shiftKey ? 'back_until' : 'until']: this.until.value.trim() }); } });
    this.words = el('datalist', { id: 'words' });
    this.about = el('button', { type: 'button', class: 'about', hidden: true, onclick: () => this.factsAbout() });
    const button = (/** @type {string} */ text, /** @type {string} */ title, /** @type {() => void} */ act) => el('button', { type: 'button', title, onclick: act }, text);
    this.backwards = [button('◀ firing', 'to before the last rule that fired (,)', () => this.go({ back: 1 })),
      button('◀ until', 'back to where that happened last (Shift+Enter)', () => this.go({ back_until: this.until.value.trim() }))];
    this.moves = el('span', { class: 'moves' }, this.backwards[0], button('firing ▶', 'until one rule has fired (.)', () => this.go({ step: 1 })), this.backwards[1], this.until,
      button('until ▶', 'to where that happens next (Enter)', () => this.go({ until: this.until.value.trim() })));
    /** @type {any[]} */
    this.tabs = [new Facts(this), new Agenda(this), new Rules(this), new Firings(this), new Globals(this), new Why(this), new WhyNot(this), new Users(this)];
    this.tab = this.tabs[0];
    this.bar = el('div', { class: 'tabs', role: 'tablist', onkeydown: (/** @type {KeyboardEvent} */ event) => this.turn(event) });
    this.pane = el('div', { class: 'pane', role: 'tabpanel', tabindex: -1 });
    this.detail = el('div', { class: 'detail', 'aria-live': 'polite', hidden: true });
    this.box = el('section', { class: 'ask', 'aria-label': 'questions about the rules' },
      el('div', { class: 'head' }, el('h2', {}, 'Rules'), this.envs, this.moves, this.about, this.place), this.problem, this.words, this.bar, el('div', { class: 'answer' }, this.pane, this.detail));
    page.top.after(this.box);
    this.addTabs();
    Object.assign(page.acts, { ',': () => this.go({ back: 1 }), '.': () => this.go({ step: 1 }), a: () => this.focus() });
    page.keys.append(...KEYS_OF_ASK.map(([key, what]) => page.keyRow(key, what)));
    page.address.others.push({ names: ['ask', 'what', 'env', 'at'], text: () => this.address(), read: (wanted) => this.read(wanted) });
    // Nothing is asked while the slider is dragged.
    this.pressed = false;
    addEventListener('pointerdown', () => { this.pressed = true; }, true);
    for (const end of ['pointerup', 'pointercancel']) addEventListener(end, () => { this.pressed = false; this.moved(); }, true);
    page.clock.listen(() => this.moved());
    page.choice.listen(() => this.chosen());
  }

  addTabs() {
    this.bar.replaceChildren(...this.tabs.map((tab) => el('button', { type: 'button', role: 'tab', id: 'ask-' + tab.name, onclick: () => this.choose(tab.name) }, tab.title)));
    this.turnTo(this.tab.name);
  }
  turnTo(/** @type {string} */ name) {
    this.tab = this.tabs.find((tab) => tab.name === name) || this.tabs[0];
    for (const button of this.bar.children) {
      const chosen = button.id === 'ask-' + this.tab.name;
      button.setAttribute('aria-selected', String(chosen));
      button.tabIndex = chosen ? 0 : -1;
    }
    this.pane.replaceChildren(this.tab.box);
    this.pane.setAttribute('aria-labelledby', 'ask-' + this.tab.name);
  }
  choose(/** @type {string} */ name) {
    this.turnTo(name);
    this.page.address.later();
    return this.refresh();
  }
  /** Left and right among the tabs. */
  turn(/** @type {KeyboardEvent} */ event) {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!step) return;
    event.stopPropagation();
    const next = this.tabs[(this.tabs.indexOf(this.tab) + step + this.tabs.length) % this.tabs.length];
    this.choose(next.name);
    /** @type {HTMLElement} */ (this.bar.querySelector('[aria-selected=true]')).focus();
  }
  focus() {
    this.box.scrollIntoView({ block: 'nearest' });
    this.pane.querySelector('input')?.focus();
  }

  // --- The server

  /**
   * Where a question is asked: a time, or where the server stands; after it has opened the run again, at the time of that.
   * @returns {{t?: number, stood?: number}}
   */
  when(/** @type {number} */ t) {
    if (this.live) return {};
    return t === this.stood ? { stood: t } : { t };
  }
  /**
   * Asks about a time, that of the slider by default.
   * @returns {Promise<any>} nothing if something else has been asked meanwhile
   */
  async question(/** @type {string} */ name, /** @type {any} */ fields, /** @type {number|null} */ t = null) {
    const turn = this.asked;
    const answer = await this.turns.take(async () => {
      const when = this.when(t ?? this.page.clock.t);
      if ('t' in when) this.stood = null;
      return request('ask', { ask: name, ...(this.env ? { env: this.env } : {}), ...when, ...fields });
    }, () => turn === this.asked);
    if (!answer || turn !== this.asked) return undefined;
    this.stand(answer.place);
    return answer.answer;
  }
  /** Goes to another place, and the slider with it. */
  async go(/** @type {any} */ order) {
    if (Object.values(order).includes('')) return this.fail(new Error('Write a rule, a fact such as (order (id 3)), or a time, up to which it is to go.'));
    ++this.asked;
    this.busy(true);
    try {
      await this.turns.take(async () => {
        const when = this.when(this.page.clock.t);
        if ('t' in when && !('t' in order)) await request('go', when);
        const stood = 'stood' in when ? when : {};
        const { place } = await request('go', { ...stood, ...order, ...(this.envs.options.length > 1 ? { env: this.env } : {}) });
        this.stand(place);
        if (this.live) return;
        this.t = this.stood = Math.min(this.page.clock.end, Math.max(0, place.t));
        this.page.clock.seek(this.stood);
      });
      await this.load();
    } catch (error) {
      this.fail(error);
    } finally {
      this.busy(false);
    }
  }
  stand(/** @type {import('./served.js').Stand} */ place) {
    this.stands = place;
    this.place.textContent = place.text;
    this.placed(place);
    if (this.live && !place.live) this.wentOver();
    if (!this.env && place.env) this.envs.value = place.env;
  }
  /** A run in progress has ended: from now on it is played again, and goes both ways. */
  wentOver() {
    this.live = false;
    for (const one of this.backwards) one.hidden = false;
  }
  async findEnvironments() {
    const answer = await this.question('envs', {});
    if (!answer) return;
    const names = answer.environments.map((/** @type {any} */ one) => one.environment);
    if (names.join() !== [...this.envs.options].map((/** @type {any} */ one) => one.value).join()) {
      this.envs.replaceChildren(...names.map((/** @type {string} */ name) => el('option', { value: name }, name)));
      if (!names.includes(this.env)) this.env = '';
      this.envs.value = this.env || this.stands?.env || names[0] || '';
      this.env = this.envs.value;
    }
  }
  /** Names that begin with the last word of a text. */
  complete(/** @type {string} */ text) {
    clearTimeout(this.completing);
    const begun = /[^\s()]*$/.exec(text)?.[0] || '';
    if (begun.length < 2) return;
    this.completing = setTimeout(async () => {
      const answer = await this.question('words', { begun }).catch(() => undefined);
      const before = text.slice(0, text.length - begun.length);
      if (answer) this.words.replaceChildren(...answer.words.slice(0, 50).map((/** @type {any} */ one) => el('option', { value: before + one.word, label: one.kind })));
    }, REST_MS);
  }

  // --- What is shown

  /** The slider has moved. */
  moved() {
    const { clock } = this.page;
    if (this.live || clock.t === this.t) return;
    if (clock.t !== this.stood) this.stood = null;
    clearTimeout(this.timer);
    if (!clock.playing && !this.pressed) this.timer = setTimeout(() => this.tab.follows && this.refresh(), REST_MS);
  }
  /** An order, a robot or a machine has been chosen: its facts can be shown. */
  chosen() {
    const { task, name } = this.page.choice;
    this.about.hidden = !task && !name;
    this.about.textContent = 'facts about ' + (task ? task.name : name);
  }
  factsAbout() {
    const { task, name } = this.page.choice;
    // With two teams, an order's name begins with that of its team.
    this.tabs[0].what.value = task ? (task.word || '') + '=' + task.id.replace(/^.*-/, '') : '=' + name;
    this.choose(this.tabs[0].name);
  }
  /** Asks again what is shown. */
  async refresh() {
    ++this.asked;
    clearTimeout(this.timer);
    this.busy(true);
    const turn = this.asked;
    try {
      await this.load();
    } catch (error) {
      if (turn === this.asked) this.fail(error);
    } finally {
      this.busy(false);
    }
  }
  async load() {
    const turn = this.asked;
    this.problem.hidden = true;
    this.t = this.page.clock.t;
    if (!this.envs.options.length) await this.findEnvironments();
    if (turn !== this.asked) return;
    await this.tab.load();
    this.page.address.later();
  }
  fail(/** @type {any} */ error) {
    this.problem.textContent = error.message;
    this.problem.hidden = false;
  }
  busy(/** @type {boolean} */ on) {
    this.waits += on ? 1 : -1;
    this.box.setAttribute('aria-busy', String(this.waits > 0));
  }

  showDetail(/** @type {string} */ title, /** @type {any[]} */ ...content) {
    const close = el('button', { type: 'button', class: 'close', title: 'close', 'aria-label': 'close', onclick: () => { this.detail.hidden = true; } }, '×');
    this.detail.replaceChildren(close, ...content);
    this.detail.hidden = !content.length;
    this.detail.scrollTo(0, 0);
    this.detail.dataset.of = title;
  }
  /** Shows something that is asked for first. */
  async detailOf(/** @type {() => Promise<any>} */ find) {
    this.problem.hidden = true;
    this.busy(true);
    try {
      await find();
    } catch (error) {
      this.fail(error);
    } finally {
      this.busy(false);
    }
  }
  /** The source of a rule; with marks, which of its conditions hold. */
  showRule(/** @type {string} */ rule, /** @type {{marks?: boolean, values?: Object<string, string>, title?: string, t?: number|null}} */ { marks = true, values = undefined, title = '', t = null } = {}) {
    return this.detailOf(async () => {
      const source = await this.question('source', { rule }, t);
      if (!source) return;
      this.showDetail(rule, el('h3', {}, 'rule ', ruleButton(rule, this), el('span', { class: 'note' }, title)),
        el('p', { class: 'note' }, (source.file ? source.file + ':' + source.first_line : 'it is in no file') + (marks ? ', conditions as of ' + timeText(t ?? this.page.clock.t) : '')),
        el('p', { class: 'buttons' }, askButton('why', 'why it fired the last time', () => this.why(rule)), askButton('why not', 'what it lacks', () => this.whyNot(rule)),
          askButton('until ▶', 'to where it fires next', () => this.go({ until: rule })), askButton('◀ until', 'to where it fired last', () => this.go({ back_until: rule }))),
        values && Object.keys(values).length ? el('p', {}, el('code', {}, valuesText(values))) : '', sourceView(source, marks));
    });
  }
  showFact(/** @type {string} */ what) {
    return this.detailOf(async () => {
      const answer = await this.question('changes', { what });
      if (!answer) return;
      if (!answer.facts.length) throw new Error(what + ' is not there at ' + timeText(this.page.clock.t) + '.');
      this.showDetail(what, ...factDetails(answer.facts[answer.facts.length - 1], this));
    });
  }
  why(/** @type {string} */ what) {
    return this.graphOf('why', what);
  }
  whyNot(/** @type {string} */ what) {
    return this.graphOf('why-not', what);
  }
  /** Rules that make such facts, and those that need them. */
  usersOf(/** @type {string} */ what) {
    return this.graphOf('users', what);
  }
  graphOf(/** @type {string} */ name, /** @type {string} */ what) {
    this.what = what;
    this.tabs.find((tab) => tab.name === name).t = null;
    return this.choose(name);
  }

  // --- Links

  address() {
    const { tab } = this, t = tab.follows ? null : tab.t;
    /** @type {Object<string, string>} */
    const out = { ask: tab.name, what: tab.asks ? this.what : tab.what?.value || '', env: this.envs.options.length > 1 ? this.env : '' };
    // A graph stays as of the time at which it was asked.
    if (t !== null && t !== undefined && t !== this.page.clock.t) out.at = String(Number(t.toFixed(2)));
    return out;
  }
  read(/** @type {URLSearchParams} */ wanted) {
    const name = wanted.get('ask'), tab = this.tabs.find((one) => one.name === name);
    const env = wanted.get('env'), what = wanted.get('what') || '';
    const same = !tab || (tab === this.tab && what === this.address().what && (!env || env === this.env));
    if (same && this.begun) return;
    this.begun = true;
    if (env) this.env = env;
    if (tab?.asks) this.what = what;
    else if (tab?.what) tab.what.value = what;
    const { clock } = this.page, { t } = clock, at = Number(wanted.get('at'));
    const elsewhere = wanted.has('at') && at >= 0;
    if (elsewhere) clock.seek(at);
    this.choose(tab?.name || this.tab.name).then(() => elsewhere && clock.seek(t));
  }
}

additions.push((page) => {
  const ask = new Ask(page);
  Object.assign(page, { ask });
  new Live(ask);
});
