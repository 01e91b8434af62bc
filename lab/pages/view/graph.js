// A graph of boxes: what led to something stands to the right of it. A row of a box leads to other boxes, which appear
// when the row is opened; each box stands there once.

import { el, tip } from '../run/draw.js';

/**
 * @typedef {{ text: string, below?: string, kind?: string, more?: string, act?: () => void, open?: () => Node[]|Promise<Node[]>, to?: string[], atOnce?: boolean }} Row
 *   `open` gives the boxes that it leads to, `atOnce` without a click; `to`: their keys, once it is open
 * @typedef {{ key: string, kind: string, title: string, lines: string[], rows: Row[], act?: () => void, column?: number, x?: number, y?: number }} Node
 */

const WIDTH = 300, GAP = 56, TITLE = 26, LINE = 18, ROW = 24, BETWEEN = 14, EDGE = 8;
const rowHeight = (/** @type {Row} */ row) => ROW + (row.below ? LINE : 0);
const rowTop = (/** @type {Node} */ node, /** @type {number} */ i) => node.rows.slice(0, i).reduce((sum, row) => sum + rowHeight(row), TITLE + LINE * node.lines.length);
const heightOf = (/** @type {Node} */ node) => rowTop(node, node.rows.length) + 4;

export class Graph {
  constructor() {
    /** @type {Map<string, Node>} */
    this.nodes = new Map();
    this.chosen = '';
    this.svg = el('svg', { role: 'group' });
    this.box = el('div', { class: 'graph scroll', tabindex: -1 }, this.svg);
    this.problem = el('p', { class: 'bad', role: 'alert' });
  }

  start(/** @type {Node} */ root) {
    this.nodes = new Map([[root.key, Object.assign(root, { column: 0 })]]);
    this.chosen = '';
    this.draw();
  }
  clear() {
    this.nodes = new Map();
    this.draw();
  }

  /**
   * Shows what a row leads to.
   * @returns {Promise<Node[]>} those that were not there
   */
  async open(/** @type {Node} */ node, /** @type {Row} */ row) {
    if (!row.open || row.to) return [];
    const found = await row.open();
    const fresh = found.filter((one) => !this.nodes.has(one.key));
    for (const one of fresh) this.nodes.set(one.key, Object.assign(one, { column: (node.column || 0) + 1 }));
    row.to = found.map((one) => one.key);
    this.draw();
    return fresh;
  }
  async openByHand(/** @type {Node} */ node, /** @type {Row} */ row) {
    this.problem.textContent = '';
    try {
      const fresh = await this.open(node, row);
      const first = this.find((fresh[0] || this.nodes.get((row.to || [])[0] || '') || node).key);
      first?.scrollIntoView({ block: 'nearest', inline: 'nearest' });
      first?.focus({ preventScroll: true });
    } catch (error) {
      this.problem.textContent = /** @type {Error} */ (error).message;
    }
  }
  find(/** @type {string} */ key) {
    return /** @type {HTMLElement|undefined} */ ([...this.svg.querySelectorAll('.node')].find((one) => /** @type {HTMLElement} */ (one).dataset.key === key));
  }

  /** Columns from left to right; a box stands beside the row that leads to it, or below what stands there already. */
  place() {
    /** @type {any[]} */
    const columns = [];
    for (const node of this.nodes.values()) (columns[node.column || 0] = columns[node.column || 0] || []).push(node);
    let bottom = 0;
    columns.forEach((nodes, column) => {
      const wanted = new Map(nodes.map((/** @type {Node} */ node) => [node, EDGE]));
      for (const from of columns[column - 1] || [])
        from.rows.forEach((/** @type {Row} */ row, /** @type {number} */ i) => {
          for (const key of row.to || []) {
            const to = this.nodes.get(key);
            if (to && wanted.get(to) === EDGE) wanted.set(to, Math.max(EDGE, from.y + rowTop(from, i) - rowTop(to, 0)));
          }
        });
      let free = EDGE;
      for (const node of [...nodes].sort((a, b) => (wanted.get(a) || 0) - (wanted.get(b) || 0))) {
        node.x = EDGE + column * (WIDTH + GAP);
        node.y = Math.max(free, wanted.get(node) || 0);
        free = node.y + heightOf(node) + BETWEEN;
      }
      bottom = Math.max(bottom, free);
    });
    return { width: columns.length * (WIDTH + GAP), height: bottom };
  }

  draw() {
    tip.hide();
    const { width, height } = this.place();
    /** @type {any[]} */
    const edges = [];
    for (const from of this.nodes.values())
      from.rows.forEach((row, i) => {
        for (const key of row.to || []) {
          const to = this.nodes.get(key);
          if (!to) continue;
          const x1 = (from.x || 0) + WIDTH, y1 = (from.y || 0) + rowTop(from, i) + ROW / 2, x2 = to.x || 0, y2 = (to.y || 0) + TITLE / 2;
          const bend = Math.max(GAP / 2, Math.abs(x2 - x1) / 2);
          edges.push(el('path', { class: 'edge', d: `M${x1} ${y1}C${x1 + bend} ${y1} ${x2 - bend} ${y2} ${x2} ${y2}` }), el('circle', { class: 'end', cx: x1, cy: y1, r: 3 }));
        }
      });
    this.svg.setAttribute('width', String(width));
    this.svg.setAttribute('height', String(height));
    this.svg.replaceChildren(...edges, ...[...this.nodes.values()].map((node) =>
      el('foreignObject', { x: node.x, y: node.y, width: WIDTH, height: heightOf(node) }, this.boxOf(node))));
  }

  boxOf(/** @type {Node} */ node) {
    const act = () => {
      this.chosen = node.key;
      for (const one of this.svg.querySelectorAll('.node')) one.classList.toggle('chosen', /** @type {HTMLElement} */ (one).dataset.key === node.key);
      node.act?.();
    };
    const told = (/** @type {string[]} */ lines) => ({
      onpointerenter: (/** @type {PointerEvent} */ event) => tip.show(event, lines),
      onpointerleave: () => tip.hide(),
    });
    return el('div', { class: 'node ' + node.kind + (node.key === this.chosen ? ' chosen' : ''), 'data-key': node.key, tabindex: 0, role: 'button', 'aria-label': [node.title, ...node.lines].join(', '),
      onclick: act, onkeydown: (/** @type {KeyboardEvent} */ event) => {
        if (event.target !== event.currentTarget || (event.key !== 'Enter' && event.key !== ' ')) return;
        event.preventDefault();
        act();
      } },
      el('div', { class: 'title', ...told([node.title]) }, node.title),
      ...node.lines.map((line) => el('div', { class: 'line', ...told([line]) }, line)),
      ...node.rows.map((row) => this.rowOf(node, row, told)));
  }
  rowOf(/** @type {Node} */ node, /** @type {Row} */ row, /** @type {(lines: string[]) => any} */ told) {
    const more = !row.open || row.to ? '' : el('button', { type: 'button', class: 'open', 'aria-label': 'what led to ' + row.text, title: 'what led to it',
      onclick: (/** @type {Event} */ event) => { event.stopPropagation(); this.openByHand(node, row); } }, '+');
    const text = row.act ? el('button', { type: 'button', class: 'text', onclick: (/** @type {Event} */ event) => { event.stopPropagation(); row.act?.(); } }, row.text) : el('span', { class: 'text' }, row.text);
    return el('div', { class: 'of ' + (row.kind || ''), ...told([row.text, row.below || '', row.more || '']) }, el('div', { class: 'row-head' }, text, more), row.below ? el('div', { class: 'below' }, row.below) : '');
  }
}
