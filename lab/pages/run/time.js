// The time that the page shows, and the part of the run that the time axis shows.

/** 312.4 -> "5:12.4" */
export function timeText(/** @type {number} */ t, digits = 1) {
  const whole = Math.round(t * 10 ** digits) / 10 ** digits;
  const seconds = (whole % 60).toFixed(digits);
  return Math.floor(whole / 60) + ':' + (whole % 60 < 10 && Number(seconds) < 10 ? '0' : '') + seconds;
}

/** "5:12.4" or "312.4" -> 312.4; NaN if it is neither. */
export function readTime(/** @type {string} */ text) {
  const parts = text.trim().split(':');
  if (!parts.length || parts.length > 3 || parts.some((p) => !/^\d+(\.\d*)?$/.test(p))) return NaN;
  return parts.reduce((sum, part) => sum * 60 + Number(part), 0);
}

/** Calls all who listen, whoever changed something. */
class Signal {
  constructor() {
    /** @type {(() => void)[]} */
    this.listeners = [];
  }
  /** Returns what ends it. */
  listen(/** @type {() => void} */ call) {
    this.listeners.push(call);
    call();
    return () => { this.listeners = this.listeners.filter((one) => one !== call); };
  }
  emit() {
    for (const call of this.listeners) call();
  }
}

export class Clock extends Signal {
  constructor(/** @type {number} */ end) {
    super();
    this.end = end;
    this.t = 0;
    this.speed = 10;
    this.playing = false;
    this.last = 0;
  }
  /** The run has gone on. */
  grow(/** @type {number} */ end) {
    this.end = end;
    this.emit();
  }
  seek(/** @type {number} */ t) {
    this.t = Math.min(this.end, Math.max(0, t));
    this.emit();
  }
  play(on = !this.playing) {
    if (on && this.t >= this.end) this.t = 0;
    const begins = on && !this.playing;
    this.playing = on;
    if (begins) {
      this.last = performance.now();
      requestAnimationFrame((now) => this.frame(now));
    }
    this.emit();
  }
  frame(/** @type {number} */ now) {
    if (!this.playing) return;
    this.t = Math.min(this.end, this.t + (Math.max(0, now - this.last) / 1000) * this.speed);
    this.last = now;
    if (this.t >= this.end) this.playing = false;
    this.emit();
    requestAnimationFrame((next) => this.frame(next));
  }
}

/** From when to when the time axis shows the run. */
export class Span extends Signal {
  constructor(/** @type {Clock} */ clock) {
    super();
    this.clock = clock;
    this.from = 0;
    this.to = clock.end;
    clock.listen(() => this.follow());
  }
  get length() {
    return this.to - this.from;
  }
  show(/** @type {number} */ from, /** @type {number} */ length) {
    length = Math.min(this.clock.end, Math.max(Math.min(2, this.clock.end), length));
    this.from = Math.min(this.clock.end - length, Math.max(0, from));
    this.to = this.from + length;
    this.emit();
  }
  /** Shows `factor` times as much; what is at `around` stays where it is. */
  zoom(/** @type {number} */ factor, around = this.clock.t) {
    const share = Math.min(1, Math.max(0, (around - this.from) / this.length));
    const length = Math.min(this.clock.end, Math.max(Math.min(2, this.clock.end), this.length * factor));
    this.show(around - share * length, length);
  }
  /** The run has gone on: what showed the whole run shows the whole run. */
  grow(/** @type {number} */ end) {
    const all = this.from === 0 && this.to === this.clock.end;
    this.clock.grow(end);
    if (all) this.show(0, end);
  }
  /** A page further when the time leaves it. */
  follow() {
    const { t } = this.clock;
    if (t < this.from || t > this.to) this.show(t - this.length * (t < this.from ? 0.9 : 0.1), this.length);
  }
}

/** What is chosen: the name of a lane or entity, or a task. */
export class Choice extends Signal {
  constructor() {
    super();
    this.name = '';
    /** @type {import('./data.js').Task|null} */
    this.task = null;
  }
  chooseName(/** @type {string} */ name) {
    this.name = name;
    this.task = null;
    this.emit();
  }
  chooseTask(/** @type {import('./data.js').Task|null} */ task) {
    this.name = '';
    this.task = task;
    this.emit();
  }
}
