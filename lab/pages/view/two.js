// Two runs side by side on one slider, and where they part first.

import { el } from '../run/draw.js';
import { themeButton } from '../run/theme.js';
import { Clock, readTime, timeText } from '../run/time.js';
import { request } from './served.js';

const BEAT_MS = 100;

/** A run in a frame. Both have the same time. */
class Side {
  constructor(/** @type {string} */ letter, /** @type {string} */ id) {
    this.letter = letter;
    this.title = el('a', { href: '/run/' + encodeURIComponent(id) + '/', title: 'this run alone' }, id);
    this.said = el('p', { class: 'said' });
    this.frame = el('iframe', { src: '/run/' + encodeURIComponent(id) + '/?beside', title: 'run ' + letter });
    this.box = el('div', { class: 'side-run' }, el('h2', {}, letter + ': ', this.title), this.said, this.frame);
  }
  /**
   * The page in the frame, as soon as it is there.
   * @returns {any}
   */
  get page() {
    return this.frame.contentWindow?.cxlab;
  }
  /** @returns {Promise<void>} */
  async come() {
    while (!this.page?.address) await new Promise((done) => setTimeout(done, BEAT_MS));
    this.title.textContent = this.frame.contentDocument.title;
  }
}

class Two {
  constructor(/** @type {Side[]} */ sides) {
    this.sides = sides;
    this.clock = new Clock(Math.max(...sides.map((side) => side.page.clock.end)));
    const { clock } = this;
    const play = el('button', { type: 'button', class: 'play', onclick: () => clock.play() });
    const slider = el('input', { type: 'range', id: 'slider', min: 0, max: clock.end, step: 0.1, 'aria-label': 'time of both', oninput: () => clock.seek(Number(slider.value)) });
    const time = el('input', { type: 'text', id: 'time', size: 8, 'aria-label': 'time, as 5:12.4', onchange: () => {
      const t = readTime(time.value);
      if (!Number.isNaN(t)) clock.seek(t);
    } });
    this.flag = el('i', { class: 'flag', hidden: true });
    this.jump = el('button', { type: 'button', class: 'jump', disabled: true }, 'looks for the first difference …');
    this.text = el('pre', {});
    this.whole = el('details', { class: 'difference', hidden: true }, el('summary', {}, 'all that differs'), this.text);
    this.box = el('div', {}, el('div', { class: 'player' }, play, el('div', { class: 'range' }, slider, this.flag), time,
      el('span', { class: 'note' }, 'of ' + timeText(clock.end, 0)), this.jump, themeButton(() => this.paint())), this.whole);
    const read = () => {
      const t = readTime(new URLSearchParams(location.hash.slice(1)).get('t') || '');
      if (!Number.isNaN(t)) clock.seek(t);
    };
    read();
    addEventListener('hashchange', read);
    clock.listen(() => {
      play.textContent = clock.playing ? '❚❚' : '▶';
      play.setAttribute('aria-label', clock.playing ? 'stop' : 'play');
      slider.value = clock.t;
      if (document.activeElement !== time) time.value = timeText(clock.t);
      for (const side of sides) this.bring(side);
      if (!clock.playing && location.hash !== this.hash) history.replaceState(null, '', this.hash);
    });
    for (const side of sides)
      side.page.clock.listen(() => {
        // What is clicked in one goes for both; the end of the shorter run is no click.
        const { t, end } = side.page.clock;
        if (!this.bringing && t !== Math.min(clock.t, end)) clock.seek(t);
      });
    addEventListener('keydown', (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      const target = /** @type {HTMLElement} */ (event.target);
      if (target.matches('input[type=text]') || event.ctrlKey || event.metaKey || event.altKey) return;
      if (step) clock.seek(clock.t + step * (event.shiftKey ? 10 : 1));
      else if (event.key === ' ' && !target.matches('button, summary, a')) clock.play();
      else if (event.key === 'j') this.jump.click();
      else return;
      event.preventDefault();
    });
  }
  get hash() {
    return '#t=' + Number(this.clock.t.toFixed(2));
  }
  bring(/** @type {Side} */ side) {
    this.bringing = true;
    if (side.page) side.page.clock.seek(this.clock.t);
    this.bringing = false;
  }
  paint() {
    for (const side of this.sides) {
      if (!side.page) continue;
      side.frame.contentDocument.documentElement.dataset.theme = document.documentElement.dataset.theme;
      side.page.field?.draw();
    }
  }
  show(/** @type {{first: {t: number, a: string, b: string}|null, text: string}} */ found) {
    this.text.textContent = found.text;
    this.whole.hidden = false;
    const { first } = found;
    if (!first) {
      this.jump.textContent = 'the rules of both did the same';
      return;
    }
    this.jump.disabled = false;
    this.jump.textContent = 'first difference at ' + timeText(first.t);
    this.jump.title = 'goes there (j)';
    this.jump.onclick = () => this.clock.seek(first.t);
    this.flag.hidden = false;
    this.flag.title = 'first difference';
    this.flag.style.left = (100 * first.t) / (this.clock.end || 1) + '%';
    this.sides[0].said.textContent = first.a || 'nothing more';
    this.sides[1].said.textContent = first.b || 'nothing more';
  }
}

async function showTwo() {
  const app = /** @type {HTMLElement} */ (document.getElementById('app'));
  const wanted = new URLSearchParams(location.search), a = wanted.get('a') || '', b = wanted.get('b') || '';
  const sides = [new Side('a', a), new Side('b', b)];
  const beside = el('div', { class: 'beside' }, ...sides.map((side) => side.box));
  app.replaceChildren(el('nav', {}, el('a', { href: '/' }, 'all runs')), beside);
  await Promise.all(sides.map((side) => side.come()));
  const two = new Two(sides);
  beside.before(two.box);
  Object.assign(window, { cxlab: two });
  document.documentElement.dataset.ready = 'true';
  try {
    two.show(await request('/api/two?a=' + encodeURIComponent(a) + '&b=' + encodeURIComponent(b)));
  } catch (error) {
    two.jump.textContent = 'not compared';
    two.whole.before(el('p', { class: 'bad', role: 'alert' }, /** @type {Error} */ (error).message));
  }
}

showTwo().catch((error) => {
  /** @type {HTMLElement} */ (document.getElementById('app')).replaceChildren(el('p', { class: 'bad', role: 'alert' }, 'The runs cannot be shown: ' + error.message));
  throw error;
});
