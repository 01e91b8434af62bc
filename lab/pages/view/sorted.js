// Tables that a click on a head orders: numbers from the greatest, texts from the first letter; a second one the other way
// round.

import { el } from '../run/draw.js';

/** @typedef {{ cells: any[], keys: (string|number|null)[], class?: string }} SortedRow  keys order the rows; what has none comes last */

export function sortedTable(/** @type {string[]} */ heads, /** @type {SortedRow[]} */ rows, /** @type {{column: number, down: boolean}|null} */ order = null,
  /** @type {(order: {column: number, down: boolean}) => void} */ ordered = () => {}) {
  const isText = (/** @type {number} */ i) => rows.some((row) => typeof row.keys[i] === 'string');
  const lines = rows.map((row) => ({ row, element: el('tr', { class: row.class || '' }, ...row.cells.map((cell, i) => el('td', { class: isText(i) ? '' : 'number' }, cell))) }));
  const body = el('tbody', {});
  let now = order;
  const show = () => {
    if (now) orderBy(lines, (one) => one.row.keys[/** @type {any} */ (now).column], now.down);
    [...head.children].forEach((cell, i) => {
      if (i === now?.column) cell.setAttribute('aria-sort', now.down ? 'descending' : 'ascending');
      else cell.removeAttribute('aria-sort');
    });
    body.replaceChildren(...lines.map((one) => one.element));
  };
  const head = el('tr', {}, ...heads.map((text, i) => el('th', { scope: 'col', class: isText(i) ? '' : 'number' }, text && el('button', { type: 'button', class: 'plain', title: 'order by it', onclick: () => {
    now = { column: i, down: now?.column === i ? !now.down : !isText(i) };
    show();
    ordered(now);
  } }, text))));
  show();
  return el('table', { class: 'sorted' }, el('thead', {}, head), body);
}

function orderBy(/** @type {any[]} */ list, /** @type {(one: any) => any} */ keyOf, /** @type {boolean} */ downwards) {
  list.sort((a, b) => {
    const x = keyOf(a) ?? null, y = keyOf(b) ?? null;
    if (x === null || y === null) return (x === null ? 1 : 0) - (y === null ? 1 : 0);
    return (downwards ? -1 : 1) * (typeof x === 'number' && typeof y === 'number' ? x - y : String(x).localeCompare(String(y), 'en', { numeric: true }));
  });
}
