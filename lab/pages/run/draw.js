// Elements, colours, solids, the box with what is under the pointer.

import { timeText } from './time.js';

/**
 * An element with attributes ("on..." are listeners) and content: elements or texts, which are never read as HTML.
 * @returns {any}
 */
export function el(/** @type {string} */ tag, /** @type {Object<string, any>} */ attributes = {}, /** @type {any[]} */ ...content) {
  const svg = ['svg', 'path', 'rect', 'line', 'ellipse', 'circle', 'g', 'text', 'foreignObject'].includes(tag);
  const element = svg ? document.createElementNS('http://www.w3.org/2000/svg', tag) : document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else if (name === 'style') for (const [key, one] of Object.entries(value)) /** @type {HTMLElement} */ (element).style.setProperty(key, String(one));
    else if (value === true) element.setAttribute(name, '');
    else if (value !== false && value !== undefined && value !== null) element.setAttribute(name, String(value));
  }
  element.append(...content.flat().filter((one) => one !== null && one !== undefined && one !== ''));
  return element;
}

/** The looks of the world's kinds; one that it has not declared is grey. */
export class Kinds {
  constructor(/** @type {import('./data.js').Kind[]} */ kinds) {
    this.byName = new Map(kinds.map((kind) => [kind.name, kind]));
  }
  fill(/** @type {string} */ name) {
    const kind = this.byName.get(name);
    return (kind && (kind.fill || kind.ink)) || '#9a9a9a';
  }
  ink(/** @type {string} */ name) {
    const kind = this.byName.get(name);
    return (kind && (kind.ink || kind.fill)) || '#777777';
  }
  hatched(/** @type {string} */ name) {
    return Boolean(this.byName.get(name)?.hatched);
  }
  /** Whether a text on it is dark. */
  isLight(/** @type {string} */ name) {
    const hex = this.fill(name).replace(/^#(.)(.)(.)$/, '#$1$1$2$2$3$3');
    const [r, g, b] = [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) || 0);
    return 0.3 * r + 0.59 * g + 0.11 * b > 110;
  }
  /** Class and style of what has that kind. */
  look(/** @type {string} */ name) {
    const shade = this.fill(name).length > 7 ? ' faint' : this.isLight(name) ? ' light' : ' dark';
    return { class: (this.hatched(name) ? ' hatched' : '') + shade, style: { '--fill': this.fill(name), '--ink': this.ink(name) } };
  }
}

/** @typedef {{ box: boolean, size: number[], at: number[], colour: string, blinks: boolean }} Solid */

/** @type {Map<string, Solid[]>} */
const knownLooks = new Map();
/** The solids of "box 0.35 0.7 0.86 0 0 0 #ccced4; cylinder ..." (scenarios/scene.h). */
export function solidsOf(/** @type {string} */ look) {
  let solids = knownLooks.get(look);
  if (solids) return solids;
  solids = [];
  for (const part of look.split(';')) {
    const words = part.trim().split(/\s+/);
    const numbers = words.slice(1, 7).map(Number);
    if (words.length < 8 || numbers.some(Number.isNaN) || !/^#[0-9a-f]{6}$/i.test(words[7])) continue;
    solids.push({ box: words[0] === 'box', size: numbers.slice(0, 3), at: numbers.slice(3), colour: words[7], blinks: words[8] === 'blinks' });
  }
  knownLooks.set(look, solids);
  return solids;
}

/** Whether lamps that blink shine. */
export const shines = (/** @type {number} */ t) => (t % 0.5) < 0.25;
export const DARK_LAMP = '#202020';

/** What the solids look like from the side. */
export function sideView(/** @type {string} */ look, height = 26) {
  const solids = solidsOf(look);
  if (!solids.length) return '';
  const half = Math.max(...solids.map((s) => Math.abs(s.at[1]) + s.size[1] / 2));
  const top = Math.max(...solids.map((s) => s.at[2] + s.size[2]));
  const scale = height / top;
  const picture = el('svg', { class: 'side', width: Math.ceil(2 * half * scale + 2), height: height + 2, 'aria-hidden': 'true' });
  for (const s of solids)
    picture.append(el('rect', { x: 1 + (half + s.at[1] - s.size[1] / 2) * scale, y: 1 + height - (s.at[2] + s.size[2]) * scale,
      width: s.size[1] * scale, height: s.size[2] * scale, fill: s.colour, stroke: '#8a8a8a', 'stroke-width': 0.6 }));
  return picture;
}

/** A time that jumps there. */
export function timeButton(/** @type {import('./time.js').Clock} */ clock, /** @type {number|null} */ t) {
  if (t === null) return '';
  return el('button', { class: 'time', type: 'button', onclick: () => clock.seek(t) }, timeText(t));
}

class Tip {
  constructor() {
    this.box = el('div', { id: 'tip', role: 'status', hidden: true });
  }
  show(/** @type {{clientX: number, clientY: number}} */ at, /** @type {string[]} */ lines) {
    if (!this.box.parentNode) document.body.append(this.box);
    this.box.replaceChildren(...lines.filter(Boolean).map((line, i) => el(i ? 'div' : 'b', {}, line)));
    this.box.hidden = false;
    const { offsetWidth: width, offsetHeight: height } = this.box;
    this.box.style.left = Math.max(4, Math.min(at.clientX + 14, innerWidth - width - 8)) + 'px';
    this.box.style.top = (at.clientY + 18 + height > innerHeight ? Math.max(4, at.clientY - height - 10) : at.clientY + 18) + 'px';
  }
  hide() {
    this.box.hidden = true;
  }
}
export const tip = new Tip();
