// The runs of a folder: a table that can be ordered and filtered, in which two are chosen to be compared.

import { el } from '../run/draw.js';
import { themeButton } from '../run/theme.js';
import { timeText } from '../run/time.js';
import { request } from './served.js';
import { sortedTable } from './sorted.js';

/**
 * @typedef {{ id: string|null, name: string, scenario: string, seed: number, status: string, tier: string, sim_time_s: number, metrics: Object<string, number>,
 *   warnings: number, errors: number, strategy?: string, parameters?: Object<string, any>, live?: boolean, problem?: string, command?: string }} ListedRun
 * @typedef {{ name: string, unit?: string, more_is_better?: boolean }} Metric
 */

const GOOD = ['completed', 'stopped'];
const shortNumber = (/** @type {number|null|undefined} */ value) => (value === null || value === undefined ? '' : Number.isInteger(value) ? String(value) : value.toPrecision(4).replace(/\.?0+$/, ''));

function nameOf(/** @type {ListedRun} */ run) {
  if (run.id === null) return el('span', { title: run.command ? 'plays it again: ' + run.command : undefined }, run.name);
  return el('a', { href: '/run/' + encodeURIComponent(run.id) + '/' }, run.name);
}

class RunsTable {
  constructor(/** @type {{folder: string, runs: ListedRun[], metrics: Metric[]}} */ listed) {
    // A run that cannot be read has a name and says why; a row of a sweep may have no folder, and then no id.
    this.runs = listed.runs.map((run) => ({ ...{ scenario: '', tier: '', metrics: {}, warnings: 0, errors: 0 }, ...run }));
    this.metrics = listed.metrics;
    /** @type {string[]} */
    this.chosen = [];
    /** @type {{column: number, down: boolean}|null} */
    this.order = null;
    const choices = (/** @type {string} */ label, /** @type {(run: ListedRun) => string} */ of) => {
      const values = [...new Set(this.runs.map(of))].filter(Boolean).sort();
      const select = el('select', { 'aria-label': label, onchange: () => this.show() }, el('option', { value: '' }, label), ...values.map((one) => el('option', { value: one }, one)));
      select.hidden = values.length < 2;
      return { select, of };
    };
    this.filters = [choices('any scenario', (run) => run.scenario), choices('any strategy', (run) => run.strategy || ''), choices('any status', (run) => run.status), choices('any tier', (run) => run.tier)];
    this.text = el('input', { type: 'search', placeholder: 'text', 'aria-label': 'text of runs', oninput: () => this.show() });
    this.troubled = el('input', { type: 'checkbox', onchange: () => this.show() });
    this.count = el('span', { class: 'note' });
    this.compare = el('button', { type: 'button', class: 'compare', onclick: () => location.assign('/two?a=' + encodeURIComponent(this.chosen[0]) + '&b=' + encodeURIComponent(this.chosen[1])) });
    this.list = el('div', { class: 'scroll', tabindex: 0 });
    this.box = el('section', { class: 'runs' }, el('div', { class: 'filters' }, ...this.filters.map((one) => one.select), this.text,
      el('label', {}, this.troubled, ' with warnings or errors'), this.count, this.compare, themeButton(() => {})), this.list);
    this.show();
  }

  show() {
    /** @type {string[]} */
    const words = this.text.value.toLowerCase().split(/\s+/).filter(Boolean);
    const found = this.runs.filter((run) => this.filters.every(({ select, of }) => !select.value || of(run) === select.value) && (!this.troubled.checked || run.warnings + run.errors > 0 || !GOOD.includes(run.status)) &&
      words.every((word) => [run.name, run.scenario, run.strategy, run.status, run.tier, 'seed ' + run.seed, JSON.stringify(run.parameters || {})].join(' ').toLowerCase().includes(word)));
    this.count.textContent = found.length + ' of ' + this.runs.length + ' runs';
    const has = (/** @type {(run: ListedRun) => any} */ of) => this.runs.some((run) => of(run));
    /** @type {{head: string, cell: (run: ListedRun) => any, key: (run: ListedRun) => string|number|null}[]} */
    const columns = [
      { head: '', cell: (run) => (run.id === null ? '' : this.choice(run)), key: () => null },
      { head: 'run', cell: nameOf, key: (run) => run.name },
      { head: 'scenario', cell: (run) => run.scenario, key: (run) => run.scenario || null },
      ...(has((run) => run.strategy) ? [{ head: 'strategy', cell: (/** @type {ListedRun} */ run) => run.strategy || '', key: (/** @type {ListedRun} */ run) => run.strategy || null }] : []),
      { head: 'seed', cell: (run) => run.seed ?? '', key: (run) => run.seed ?? null },
      { head: 'tier', cell: (run) => run.tier, key: (run) => run.tier || null },
      { head: 'status', cell: (run) => el('span', { class: GOOD.includes(run.status) ? '' : 'bad', title: run.problem || undefined }, run.live ? 'live' : run.status), key: (run) => run.status },
      { head: 'time', cell: (run) => (run.sim_time_s ? timeText(run.sim_time_s, 0) : ''), key: (run) => run.sim_time_s ?? null },
      { head: 'warnings', cell: (run) => run.warnings || '', key: (run) => run.warnings },
      { head: 'errors', cell: (run) => (run.errors ? el('b', { class: 'bad' }, run.errors) : ''), key: (run) => run.errors },
      ...this.metrics.map((metric) => ({ head: metric.name + (metric.unit ? ' (' + metric.unit + ')' : ''),
        cell: (/** @type {ListedRun} */ run) => shortNumber(run.metrics[metric.name]), key: (/** @type {ListedRun} */ run) => run.metrics[metric.name] ?? null })),
    ];
    this.list.replaceChildren(found.length ? sortedTable(columns.map((one) => one.head), found.map((run) => ({ cells: columns.map((one) => one.cell(run)), keys: columns.map((one) => one.key(run)), class: '' })),
      this.order, (order) => { this.order = order; }) : el('p', {}, this.runs.length ? 'No run fits.' : 'There is no run in this folder.'));
    this.showChosen();
  }
  choice(/** @type {ListedRun} */ run) {
    const box = el('input', { type: 'checkbox', 'data-id': run.id, 'aria-label': 'compare ' + run.name, onchange: () => {
      const id = run.id || '';
      this.chosen = this.chosen.filter((one) => one !== id);
      if (box.checked) this.chosen = [...this.chosen.slice(-1), id];
      this.showChosen();
    } });
    return box;
  }
  showChosen() {
    for (const box of this.list.querySelectorAll('input[data-id]')) {
      const input = /** @type {HTMLInputElement} */ (box);
      input.checked = this.chosen.includes(input.dataset.id || '');
      input.closest('tr')?.classList.toggle('chosen', input.checked);
    }
    const names = this.chosen.map((id) => this.runs.find((run) => run.id === id)?.name);
    this.compare.disabled = this.chosen.length < 2;
    this.compare.textContent = this.chosen.length < 2 ? 'choose two to compare' : 'compare ' + names.join(' with ');
  }
}

async function showRuns() {
  const listed = await request('/api/runs');
  const table = new RunsTable(listed);
  /** @type {HTMLElement} */ (document.getElementById('folder')).textContent = listed.folder;
  document.title = 'Runs of ' + listed.folder;
  /** @type {HTMLElement} */ (document.getElementById('app')).replaceChildren(table.box);
  Object.assign(window, { cxlab: table });
  document.documentElement.dataset.ready = 'true';
}

showRuns().catch((error) => {
  /** @type {HTMLElement} */ (document.getElementById('app')).replaceChildren(el('p', { class: 'bad', role: 'alert' }, 'The runs cannot be shown: ' + error.message));
  throw error;
});
