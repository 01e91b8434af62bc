// The field: from above on a canvas, or in 3D.

import { DARK_LAMP, el, shines, solidsOf, tip } from './draw.js';
import { yawOf } from './scene.js';

const TRAIL = 30; // s of the path behind and before what moves
const STEP = 0.5; // s between points of a path
const CLICK = 4; // px that the pointer may move in a click

/** What is shown of the scene, whoever draws it. */
export class Field {
  constructor(/** @type {import('./scene.js').Scene} */ scene, /** @type {import('./time.js').Clock} */ clock,
    /** @type {import('./time.js').Choice} */ choice, /** @type {(canvas: HTMLCanvasElement) => Promise<any>} */ make3d) {
    this.scene = scene;
    this.clock = clock;
    this.choice = choice;
    this.make3d = make3d;
    this.flat = el('canvas', { class: 'flat', role: 'img', 'aria-label': 'the field from above' });
    this.solid = el('canvas', { class: 'solid', role: 'img', 'aria-label': 'the field in 3D', tabindex: 0, hidden: true });
    /** @type {any} */
    this.view3d = null;
    this.wants3d = true;
    this.note = el('span', { class: 'note' });
    this.showPaths = el('input', { type: 'checkbox', checked: true, onchange: () => this.draw() });
    this.is3d = el('button', { type: 'button', 'aria-pressed': 'false', title: 'in 3D or from above (v)', onclick: () => this.toggle() }, '3D');
    this.box = el('section', { class: 'field' },
      el('div', { class: 'canvas' }, this.flat, this.solid),
      el('div', { class: 'controls' }, this.is3d, el('label', {}, this.showPaths, ' paths'), this.note));
    this.area = this.findArea();
    for (const canvas of [this.flat, this.solid]) {
      let pressed = [0, 0]; // where a click began; a drag that turns the view chooses nothing
      canvas.addEventListener('pointerdown', (/** @type {PointerEvent} */ event) => { pressed = [event.clientX, event.clientY]; });
      canvas.addEventListener('pointermove', (/** @type {PointerEvent} */ event) => (event.buttons ? tip.hide() : this.point(event)));
      canvas.addEventListener('pointerleave', () => tip.hide());
      canvas.addEventListener('click', (/** @type {MouseEvent} */ event) => {
        const seen = Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]) < CLICK ? this.under(event) : undefined;
        if (seen) choice.chooseName(seen.track.name);
      });
    }
    new ResizeObserver(() => this.draw()).observe(this.box);
    clock.listen(() => this.draw());
    choice.listen(() => this.draw());
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.draw());
  }

  /** From where to where everything is, ever. */
  findArea() {
    const area = { minX: Infinity, minY: Infinity, maxX: -Infinity, maxY: -Infinity };
    const add = (/** @type {number} */ x, /** @type {number} */ y, /** @type {number} */ half) => {
      area.minX = Math.min(area.minX, x - half);
      area.maxX = Math.max(area.maxX, x + half);
      area.minY = Math.min(area.minY, y - half);
      area.maxY = Math.max(area.maxY, y + half);
    };
    for (const track of this.scene.tracks.values()) {
      if (track.carrier.values.some(Boolean)) continue;
      const flat = solidsOf(track.look.values[0] || '').filter((s) => s.size[0] > 2 && s.size[1] > 2);
      for (const key of track.keys)
        for (const { pose } of key.way || [key]) {
          add(pose[0] / 1000, pose[1] / 1000, flat.length ? 0 : 0.2);
          for (const s of flat) {
            add(pose[0] / 1000 - s.size[0] / 2, pose[1] / 1000 - s.size[1] / 2, 0);
            add(pose[0] / 1000 + s.size[0] / 2, pose[1] / 1000 + s.size[1] / 2, 0);
          }
        }
    }
    if (area.minX > area.maxX) return { minX: -1, minY: -1, maxX: 1, maxY: 1 };
    const margin = 0.02 * Math.max(area.maxX - area.minX, area.maxY - area.minY) + 0.1;
    return { minX: area.minX - margin, minY: area.minY - margin, maxX: area.maxX + margin, maxY: area.maxY + margin };
  }

  /** Paths of what moves by itself: points of the world from before to after the time. */
  paths(/** @type {number} */ t) {
    const out = [];
    for (const track of this.scene.tracks.values()) {
      if (!track.moves || !track.there.at(t) || track.carrier.values.some(Boolean)) continue;
      const points = [];
      for (let at = Math.max(0, t - TRAIL); at <= Math.min(this.clock.end, t + TRAIL); at += STEP)
        if (track.there.at(at)) points.push({ t: at, position: this.scene.placeOf(track, at).position });
      out.push({ track, points });
    }
    return out;
  }

  async toggle(on = this.solid.hidden) {
    this.wants3d = on;
    if (on && !this.view3d) {
      try {
        this.view3d = await this.make3d(this.solid);
      } catch (error) {
        this.note.textContent = 'This browser has no WebGL: the field is shown from above.';
        this.is3d.disabled = true;
        this.wants3d = false;
        return;
      }
    }
    this.solid.hidden = !this.wants3d;
    this.flat.hidden = this.wants3d;
    this.is3d.setAttribute('aria-pressed', String(this.wants3d));
    this.draw();
  }

  scale() {
    const { minX, maxX, minY, maxY } = this.area;
    const width = this.flat.clientWidth, height = this.flat.clientHeight;
    const scale = Math.min(width / (maxX - minX), height / (maxY - minY));
    return { scale, x: width / 2 - (scale * (minX + maxX)) / 2, y: height / 2 + (scale * (minY + maxY)) / 2 };
  }

  draw() {
    const { t } = this.clock;
    this.seen = this.scene.at(Math.min(t, this.scene.until));
    const paths = this.showPaths.checked ? this.paths(t) : [];
    if (!this.solid.hidden) {
      this.view3d.draw(this.seen, paths, t, this.choice.name);
      return;
    }
    const canvas = this.flat, ratio = devicePixelRatio || 1;
    const width = canvas.clientWidth, height = canvas.clientHeight;
    if (!width || !height) return;
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    const context = canvas.getContext('2d');
    const { scale, x, y } = this.scale();
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    /** @type {{z: number, draw: () => void}[]} */
    const solids = [];
    for (const seen of this.seen) {
      const yaw = yawOf(seen.at.turn), [px, py, pz] = seen.at.position;
      for (const solid of solidsOf(seen.look))
        solids.push({ z: pz + solid.at[2] + solid.size[2], draw: () => drawFlat(context, solid, x + px * scale, y - py * scale, yaw, scale, t) });
    }
    solids.sort((a, b) => a.z - b.z);
    const ground = solids.findIndex((solid) => solid.z > 0.02);
    for (let i = 0; i < solids.length; ++i) {
      if (i === ground) this.drawPaths(context, paths, scale, x, y);
      solids[i].draw();
    }
    if (ground < 0) this.drawPaths(context, paths, scale, x, y);
    const ink = getComputedStyle(canvas).color;
    context.font = '600 11px system-ui, sans-serif';
    context.textAlign = 'center';
    for (const seen of this.seen) {
      const chosen = seen.track.name === this.choice.name;
      if (!seen.state && !chosen) continue;
      if (seen.carrier && !chosen) continue;
      const [px, py] = seen.at.position, half = this.radius(seen) * scale;
      if (chosen) {
        context.lineWidth = 2.5;
        context.strokeStyle = ink;
        context.beginPath();
        context.arc(x + px * scale, y - py * scale, half + 4, 0, 2 * Math.PI);
        context.stroke();
      }
      if (!seen.track.moves && scale < 40 && !chosen) continue;
      context.lineWidth = 3;
      context.strokeStyle = 'rgba(255, 255, 255, 0.85)';
      context.fillStyle = '#111';
      context.strokeText(seen.track.name, x + px * scale, y - py * scale - half - 5);
      context.fillText(seen.track.name, x + px * scale, y - py * scale - half - 5);
    }
  }

  drawPaths(/** @type {CanvasRenderingContext2D} */ context, /** @type {any[]} */ paths, /** @type {number} */ scale, /** @type {number} */ x, /** @type {number} */ y) {
    const { t } = this.clock;
    for (const { track, points } of paths)
      for (const after of [false, true]) {
        const part = points.filter((/** @type {{t: number}} */ point) => (after ? point.t >= t - STEP : point.t <= t + STEP));
        context.beginPath();
        for (const point of part) context.lineTo(x + point.position[0] * scale, y - point.position[1] * scale);
        context.strokeStyle = pathColour(track);
        context.globalAlpha = after ? 0.9 : 0.5;
        context.lineWidth = after ? 1.5 : 2.5;
        context.setLineDash(after ? [4, 4] : []);
        context.stroke();
      }
    context.setLineDash([]);
    context.globalAlpha = 1;
  }

  /** Of the circle around it, seen from above; m. */
  radius(/** @type {import('./scene.js').Seen} */ seen) {
    return Math.max(0.02, ...solidsOf(seen.look).map((s) => Math.max(Math.abs(s.at[0]) + s.size[0] / 2, Math.abs(s.at[1]) + s.size[1] / 2)));
  }

  /** What is there, the nearest or the smallest first; not the ground. */
  under(/** @type {PointerEvent|MouseEvent} */ event) {
    const things = (this.seen || []).filter((seen) => seen.track.kind && this.radius(seen) < 1);
    if (!this.solid.hidden) return this.view3d.under(event, things);
    const { scale, x, y } = this.scale();
    const mx = (event.offsetX - x) / scale, my = (y - event.offsetY) / scale;
    const reach = 4 / scale;
    return things.filter((seen) => Math.hypot(seen.at.position[0] - mx, seen.at.position[1] - my) < Math.max(this.radius(seen), reach)).sort((a, b) => this.radius(a) - this.radius(b))[0];
  }

  point(/** @type {PointerEvent} */ event) {
    const seen = this.under(event);
    if (!seen) return tip.hide();
    const carrier = this.scene.tracks.get(seen.carrier);
    tip.show(event, [seen.track.name, seen.state, carrier ? 'carried by ' + carrier.name + (seen.place ? ' (' + seen.place + ')' : '') : '']);
  }
}

/** A colour of what moves: the brightest of its solids, else what all have. */
export function pathColour(/** @type {import('./scene.js').Track} */ track) {
  let best = '#d55e00', most = 0;
  for (const solid of solidsOf(track.look.values[0] || '')) {
    const [r, g, b] = [1, 3, 5].map((i) => parseInt(solid.colour.slice(i, i + 2), 16));
    const vivid = Math.max(r, g, b) - Math.min(r, g, b);
    if (vivid > most) [best, most] = [solid.colour, vivid];
  }
  return best;
}

function drawFlat(/** @type {CanvasRenderingContext2D} */ context, /** @type {import('./draw.js').Solid} */ solid, /** @type {number} */ x,
  /** @type {number} */ y, /** @type {number} */ yaw, /** @type {number} */ scale, /** @type {number} */ t) {
  context.save();
  context.translate(x, y);
  context.rotate(-yaw);
  context.scale(scale, -scale);
  context.fillStyle = solid.blinks && !shines(t) ? DARK_LAMP : solid.colour;
  context.beginPath();
  // What is thinner than a pixel can still be seen.
  const width = Math.max(solid.size[0], 1 / scale), depth = Math.max(solid.size[1], 1 / scale);
  if (solid.box) context.rect(solid.at[0] - width / 2, solid.at[1] - depth / 2, width, depth);
  else context.ellipse(solid.at[0], solid.at[1], width / 2, depth / 2, 0, 0, 2 * Math.PI);
  context.fill();
  if (width * scale > 5 && depth * scale > 5 && width < 2) {
    context.lineWidth = 0.6 / scale;
    context.strokeStyle = 'rgba(0, 0, 0, 0.35)';
    context.stroke();
  }
  context.restore();
}
