// A run in progress: it is paused, stepped and let go on, and the page grows with it.

import { source } from '../run/data.js';
import { el } from '../run/draw.js';
import { timeText } from '../run/time.js';
import { bytesOf, request } from './served.js';

const SPEEDS_OF_RUN = [0, 0.5, 1, 2, 5, 10, 20, 50], REFILL_MS = 3000, RETRY_MS = 1000, MOST_LINES = 1000;

/** The last lines that were logged. */
class Log {
  constructor(/** @type {import('./ask.js').Ask} */ ask) {
    this.ask = ask;
    this.name = 'log';
    this.title = 'Log';
    this.follows = false;
    /** @type {any[]} */
    this.lines = [];
    this.text = el('input', { type: 'search', placeholder: 'text', 'aria-label': 'text of the log', oninput: () => this.load() });
    this.list = el('table', { class: 'log' });
    this.box = el('div', {}, el('div', { class: 'filters' }, this.text), this.list);
  }
  add(/** @type {any} */ line) {
    this.lines.push(line);
    this.lines.splice(0, this.lines.length - MOST_LINES);
  }
  async load() {
    const text = this.text.value.toLowerCase();
    this.list.replaceChildren(...this.lines.filter((line) => (line.logger + ' ' + line.text).toLowerCase().includes(text)).reverse().map((line) =>
      el('tr', { class: line.level }, el('td', { class: 'number' }, timeText(Math.max(0, line.t), 1)), el('td', {}, line.level), el('td', {}, line.logger), el('td', {}, el('code', {}, line.text)))));
  }
}

/** What only a run that has ended says: how it ended, and its tables. */
async function showEnd() {
  for (let tries = 0; tries < 20; ++tries) {
    const page = new DOMParser().parseFromString(await (await fetch(location.pathname)).text(), 'text/html');
    const head = page.querySelector('header');
    if (page.documentElement.dataset.live !== 'true' && head) {
      document.querySelector('header')?.replaceWith(head);
      for (const old of document.querySelectorAll('body > section')) old.remove();
      document.querySelector('main')?.after(...page.querySelectorAll('body > section'));
      return;
    }
    await new Promise((done) => setTimeout(done, RETRY_MS));
  }
}

export class Live {
  constructor(/** @type {import('./ask.js').Ask} */ ask) {
    this.ask = ask;
    this.page = ask.page;
    this.waiting = new AbortController(); // for news
    if (document.documentElement.dataset.live !== 'true') return;
    ask.live = true;
    for (const one of ask.backwards) one.hidden = true; // a run in progress goes one way
    this.log = new Log(ask);
    ask.tabs.push(this.log);
    ask.addTabs();
    this.running = false;
    this.ended = false;
    this.next = 0;
    const button = (/** @type {string} */ text, /** @type {string} */ title, /** @type {() => void} */ act) => el('button', { type: 'button', title, onclick: act }, text);
    this.pause = button('pause', 'stops before the next rule that fires, or at the next tick (p)', () => this.order(this.running ? { pause: true } : { continue: true }));
    this.tick = button('tick ▶', 'to the next tick', () => this.order({ tick: 1 }));
    this.speed = el('select', { 'aria-label': 'speed of the run', onchange: () => this.order({ speed: Number(this.speed.value) }) },
      ...SPEEDS_OF_RUN.map((one) => el('option', { value: one }, one ? one + ' × real time' : 'as fast as it can')));
    this.follow = el('input', { type: 'checkbox', checked: true });
    this.state = el('b', { class: 'state', role: 'status' });
    this.box = el('div', { class: 'live' }, el('span', { class: 'chip light' }, 'live'), this.state, this.pause, this.tick, this.speed, el('label', {}, this.follow, ' follow'));
    this.page.player.after(this.box);
    this.page.acts.p = () => this.pause.click();
    this.page.keys.append(this.page.keyRow('p', 'pause the run, or let it go on'));
    ask.placed = (place) => this.placed(place);
    this.listen();
  }

  /** The answer to a question or an order says where the run is. */
  placed(/** @type {import('./served.js').Stand} */ place) {
    // News of a run that goes on come more often.
    if (place.running && !this.running) this.waiting.abort();
    this.running = place.running;
    if (place.live) this.show(place.t);
  }

  async order(/** @type {any} */ what) {
    if ('speed' in what || 'pause' in what) {
      // Does not wait for what is asked.
      try {
        this.ask.stand((await request('go', what)).place);
      } catch (error) {
        this.ask.fail(error);
      }
      return;
    }
    await this.ask.go(what);
  }

  async listen() {
    while (!this.ended) {
      try {
        this.waiting = new AbortController();
        const news = await request('events?after=' + this.next, undefined, this.waiting.signal);
        this.next = news.next;
        await this.take(news);
      } catch (error) {
        if (this.waiting.signal.aborted) continue;
        this.ask.fail(error);
        await new Promise((done) => setTimeout(done, RETRY_MS));
      }
    }
  }
  async take(/** @type {any} */ news) {
    const stopped = news.events.some((/** @type {any} */ event) => event.event === 'stopped');
    this.running = news.running;
    for (const event of news.events) {
      if (event.event === 'log') this.log?.add(event);
      if (event.event === 'stopped') this.ask.place.textContent = event.text;
      if (event.event === 'end') this.ended = true;
    }
    if (news.live === false) this.ended = true;
    const t = news.t ?? this.page.clock.end;
    this.show(t);
    const due = performance.now() - (this.filled || 0) > REFILL_MS;
    if (!this.ended && (stopped || due)) await this.grow(t);
    if (this.ended) {
      this.ask.wentOver();
      await showEnd();
      this.show(await this.grow(t)); // the last news may be older than the end
      await this.ask.question('where', {});
    }
    if (this.ask.tab === this.log) this.log?.load();
    else if (this.ask.tab.follows && (stopped || this.ended || (due && !this.ask.box.matches(':focus-within')))) this.ask.refresh();
  }
  show(/** @type {number} */ t) {
    this.state.textContent = this.ended ? 'has ended at ' + timeText(t) : (this.running ? 'runs, ' : 'stands at ') + timeText(t);
    this.pause.textContent = this.running ? 'pause' : 'continue';
    for (const one of [this.pause, this.tick, this.speed]) one.disabled = this.ended;
    const { clock, span } = this.page;
    if (t > clock.end) span.grow(t);
    if (this.follow.checked && !clock.playing && t >= 0) clock.seek(t);
  }
  /**
   * What the run has recorded meanwhile.
   * @returns {Promise<number>} up to when
   */
  async grow(/** @type {number} */ t) {
    this.filled = performance.now();
    const { page } = this, { scene } = page;
    const [run, bytes] = await Promise.all([source.run(), bytesOf('scene.bin?from=' + scene.size)]);
    if (bytes?.length) scene.read(bytes);
    run.end = Math.max(run.end, t);
    const had = page.field;
    page.fill(run, true);
    if (!had && page.field) await page.field.toggle(true);
    if (this.follow.checked && !page.clock.playing) page.clock.seek(t);
    return run.end;
  }
}
