// scene.bin (docs/reference/run-folder.md, The scene): where everything is at any time.

const MAGIC = 'CXSCENE1';
const CHUNK_HEAD = 12; // length and checksum
const PERIOD = 0.1; // s between frames
const X = 1, Y = 2, YAW = 4, REST = 8, STATE = 16, CARRIER = 32, WAY = 64, MORE = 128;

/**
 * @typedef {number[]} Pose  x, y, z in mm, rotation as axis times angle in mrad
 * @typedef {{ t: number, pose: Pose, way: {t: number, pose: Pose}[]|null, cut: boolean }} Key
 * @typedef {{ position: number[], turn: number[] }} Place  in m; a quaternion x, y, z, w
 * @typedef {{ track: Track, state: string, look: string, carrier: number, place: string, at: Place }} Seen
 */

class Reader {
  constructor(/** @type {Uint8Array} */ bytes, at = 0) {
    this.bytes = bytes;
    this.at = at;
  }
  byte() {
    return this.bytes[this.at++];
  }
  varint() {
    let value = 0, factor = 1;
    for (;;) {
      const next = this.bytes[this.at++];
      value += (next & 127) * factor;
      if (next < 128 || next === undefined) return value;
      factor *= 128;
    }
  }
  zigzag() {
    const value = this.varint();
    return value % 2 ? -(value + 1) / 2 : value / 2;
  }
  pose(/** @type {number} */ fields, /** @type {Pose} */ before) {
    const pose = before.slice();
    if (fields & X) pose[0] += this.zigzag();
    if (fields & Y) pose[1] += this.zigzag();
    if (fields & YAW) pose[5] += this.zigzag();
    if (fields & REST) for (let i = 2; i < 5; ++i) pose[i] += this.zigzag();
    return pose;
  }
}

/** Values from times on, in order. */
class Series {
  constructor() {
    /** @type {number[]} */
    this.times = [];
    /** @type {any[]} */
    this.values = [];
  }
  put(/** @type {number} */ t, /** @type {any} */ value) {
    if (this.values.length && this.values[this.values.length - 1] === value) return;
    this.times.push(t);
    this.values.push(value);
  }
  at(/** @type {number} */ t) {
    const i = lastNotAfter(this.times, t);
    return i < 0 ? undefined : this.values[i];
  }
}

/** The index of the last that is not after `t`; -1 if there is none. */
export function lastNotAfter(/** @type {number[]} */ times, /** @type {number} */ t) {
  let low = 0, high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

export class Track {
  constructor(/** @type {number} */ id, /** @type {string} */ kind, /** @type {string} */ name) {
    this.id = id;
    this.kind = kind;
    this.name = name;
    this.there = new Series();
    this.state = new Series();
    this.look = new Series();
    this.carrier = new Series();
    this.place = new Series();
    /** @type {number[]} */
    this.times = [];
    /** @type {Key[]} */
    this.keys = [];
  }
  put(/** @type {Key} */ key) {
    const last = this.keys[this.keys.length - 1];
    if (last && !last.way && !key.way && !key.cut && last.pose.every((value, i) => value === key.pose[i])) return;
    this.times.push(key.t);
    this.keys.push(key);
  }
  /** Seen from the carrier. */
  placeAt(/** @type {number} */ t) {
    const i = lastNotAfter(this.times, t);
    const key = this.keys[Math.max(0, i)], next = this.keys[i + 1];
    if (key.way) {
      const j = key.way.findIndex((point) => point.t > t);
      if (j < 0) return placeOf(key.way[key.way.length - 1].pose);
      if (j === 0) return placeOf(key.way[0].pose);
      const a = key.way[j - 1], b = key.way[j];
      return between(a.pose, b.pose, (t - a.t) / (b.t - a.t));
    }
    // Frames show what had changed since the frame before.
    if (!next || next.cut || next.way || i < 0) return placeOf(key.pose);
    const from = Math.max(key.t, next.t - PERIOD);
    return t <= from ? placeOf(key.pose) : between(key.pose, next.pose, (t - from) / (next.t - from));
  }
  /** Whether it moves by itself at some time. */
  get moves() {
    return this.keys.length > 2 || this.keys.some((key) => key.way);
  }
}

/** @returns {Place} */
function placeOf(/** @type {Pose} */ pose) {
  const [rx, ry, rz] = [pose[3] / 1000, pose[4] / 1000, pose[5] / 1000];
  const angle = Math.hypot(rx, ry, rz), s = angle > 1e-9 ? Math.sin(angle / 2) / angle : 0.5;
  return { position: [pose[0] / 1000, pose[1] / 1000, pose[2] / 1000], turn: [rx * s, ry * s, rz * s, Math.cos(angle / 2)] };
}

function between(/** @type {Pose} */ a, /** @type {Pose} */ b, /** @type {number} */ share) {
  const from = placeOf(a), to = placeOf(b);
  const sign = from.turn.reduce((sum, value, i) => sum + value * to.turn[i], 0) < 0 ? -1 : 1;
  const turn = from.turn.map((value, i) => value * (1 - share) + sign * to.turn[i] * share);
  const length = Math.hypot(...turn) || 1;
  return {
    position: from.position.map((value, i) => value * (1 - share) + to.position[i] * share),
    turn: turn.map((value) => value / length),
  };
}

export function rotated(/** @type {number[]} */ q, /** @type {number[]} */ v) {
  const [x, y, z, w] = q;
  const tx = 2 * (y * v[2] - z * v[1]), ty = 2 * (z * v[0] - x * v[2]), tz = 2 * (x * v[1] - y * v[0]);
  return [v[0] + w * tx + y * tz - z * ty, v[1] + w * ty + z * tx - x * tz, v[2] + w * tz + x * ty - y * tx];
}

/** `inner` seen from where `outer` is seen from. */
function composed(/** @type {Place} */ outer, /** @type {Place} */ inner) {
  const moved = rotated(outer.turn, inner.position);
  const [ax, ay, az, aw] = outer.turn, [bx, by, bz, bw] = inner.turn;
  return {
    position: moved.map((value, i) => value + outer.position[i]),
    turn: [aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx, aw * bz + ax * by - ay * bx + az * bw,
      aw * bw - ax * bx - ay * by - az * bz],
  };
}

export function yawOf(/** @type {number[]} */ q) {
  const [x, y, z, w] = q;
  return Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
}

export class Scene {
  constructor(/** @type {Uint8Array|null} */ bytes) {
    /** @type {Map<number, Track>} */
    this.tracks = new Map();
    this.until = 0;
    this.size = 0; // bytes that have been read
    if (bytes) this.read(bytes);
  }
  get empty() {
    return this.tracks.size === 0;
  }

  /** The file from byte `size` on, as far as its chunks are whole. */
  read(/** @type {Uint8Array} */ bytes) {
    let at = 0;
    if (!this.size) {
      if (new TextDecoder().decode(bytes.subarray(0, MAGIC.length)) !== MAGIC) throw new Error('the scene is none');
      at = MAGIC.length;
    }
    const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    while (at + CHUNK_HEAD <= bytes.length) {
      const end = at + CHUNK_HEAD + view.getUint32(at, true);
      if (end > bytes.length) break;
      this.readChunk(new Reader(bytes.subarray(0, end), at + CHUNK_HEAD));
      at = end;
    }
    this.size += at;
  }

  readChunk(/** @type {Reader} */ input) {
    /** @type {string[]} */
    const texts = [''];
    const decoder = new TextDecoder();
    const text = () => {
      const number = input.varint();
      if (number === texts.length) {
        const size = input.varint();
        texts.push(decoder.decode(input.bytes.subarray(input.at, input.at + size)));
        input.at += size;
      }
      return texts[number];
    };
    let ns = input.varint();
    this.until = (ns + input.varint()) / 1e9;
    /** @type {Map<number, Pose>} */
    const poses = new Map();
    for (let first = true; input.at < input.bytes.length; first = false) {
      ns += input.varint();
      const t = ns / 1e9;
      for (let id = input.varint(); id; id = input.varint()) this.readChange(input, t, id, poses, text);
      if (first)
        for (const track of this.tracks.values()) if (!poses.has(track.id)) track.there.put(t, false);
    }
  }

  readChange(/** @type {Reader} */ input, /** @type {number} */ t, /** @type {number} */ id, /** @type {Map<number, Pose>} */ poses,
    /** @type {() => string} */ text) {
    const fields = input.byte();
    let track = this.tracks.get(id);
    let cut = false, isNew = false;
    if (fields & MORE) {
      const more = input.byte();
      if (more === 0) {
        if (track) track.there.put(t, false);
        poses.delete(id);
        return;
      }
      isNew = more === 1;
      if (isNew) {
        const kind = text(), name = text();
        if (!track) this.tracks.set(id, (track = new Track(id, kind, name)));
        cut = !track.there.at(t);
        track.there.put(t, true);
        poses.set(id, [0, 0, 0, 0, 0, 0]);
      }
      /** @type {Track} */ (track).look.put(t, text());
    }
    const known = /** @type {Track} */ (track);
    const pose = input.pose(fields, poses.get(id) || [0, 0, 0, 0, 0, 0]);
    poses.set(id, pose);
    if (fields & STATE) known.state.put(t, text());
    else if (isNew) known.state.put(t, '');
    if (fields & CARRIER || isNew) {
      const carrier = fields & CARRIER ? input.varint() : 0, place = fields & CARRIER ? text() : '';
      cut = cut || known.carrier.at(t) !== carrier;
      known.carrier.put(t, carrier);
      known.place.put(t, place);
    }
    let way = null;
    if (fields & WAY) {
      way = [];
      let point = { t: 0, pose: [0, 0, 0, 0, 0, 0] };
      for (let left = input.varint(); left > 0; --left) {
        const later = input.varint() / 1000;
        point = { t: point.t + later, pose: input.pose(input.byte(), point.pose) };
        way.push(point);
      }
      if (!way.length) way = null;
    }
    // A state alone changes nothing of where it is, nor of its way.
    const moved = fields & (X | Y | YAW | REST | CARRIER | WAY);
    if (isNew || moved) known.put({ t, pose, way, cut });
  }

  /**
   * The place in the world.
   * @param {Track} track
   * @param {number} t
   * @returns {Place}
   */
  placeOf(track, t, depth = 0) {
    const own = track.placeAt(t), carrier = this.tracks.get(track.carrier.at(t) || 0);
    return carrier && depth < 8 ? composed(this.placeOf(carrier, t, depth + 1), own) : own;
  }

  /** All that there is at that time. @returns {Seen[]} */
  at(/** @type {number} */ t) {
    const out = [];
    for (const track of this.tracks.values())
      if (track.there.at(t))
        out.push({ track, state: track.state.at(t) || '', look: track.look.at(t) || '', carrier: track.carrier.at(t) || 0,
          place: track.place.at(t) || '', at: this.placeOf(track, t) });
    return out;
  }
  find(/** @type {string} */ name) {
    for (const track of this.tracks.values()) if (track.name === name) return track;
    return undefined;
  }
}
