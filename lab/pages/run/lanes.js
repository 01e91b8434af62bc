// Who did what when.

import { el } from './draw.js';

/** The rows of a part with lanes. Of each lane that has bars, what it shows at a time, for the list of what is so now. */
export function addLanes(/** @type {import('./axis.js').Axis} */ axis, /** @type {import('./data.js').Part} */ part,
  /** @type {import('./time.js').Choice} */ choice, /** @type {(id: string|undefined) => import('./data.js').Task|null} */ taskOf) {
  const key = (part.key || []).map((one) => {
    const look = axis.kinds.look(one.kind);
    return one.kind ? el('span', { class: 'chip' + look.class, style: look.style }, one.text) : el('span', {}, '▼ ' + one.text);
  });
  axis.title(part.title, ...key);
  for (const lane of part.lanes || []) {
    const name = el('button', { type: 'button', class: 'name', onclick: () => choice.chooseName(choice.name === lane.name ? '' : lane.name) }, lane.name);
    const { row, track } = axis.row(name, 'lane');
    for (const bar of lane.bars) {
      const task = taskOf(bar.task);
      const lines = [bar.text + (bar.remark || ''), task ? task.name : ''];
      const text = bar.shape === 'strip' ? '' : bar.text;
      track.append(axis.bar(bar, bar.shape, lines, text, () => {
        if (task) choice.chooseTask(task);
        else choice.chooseName(lane.name);
        axis.clock.seek(bar.begin);
      }));
    }
    for (const mark of lane.marks) track.append(axis.mark(mark, [mark.text]));
    axis.listen(choice, () => row.classList.toggle('chosen', choice.name === lane.name));
  }
}

/** The bar that a lane shows at a time: the last that lies over it, but for strips. */
export function barAt(/** @type {import('./data.js').Lane} */ lane, /** @type {number} */ t) {
  let found = null;
  for (const bar of lane.bars)
    if (bar.shape !== 'strip' && bar.begin <= t && (t < bar.end || bar.begin === bar.end)) found = bar;
  return found;
}
