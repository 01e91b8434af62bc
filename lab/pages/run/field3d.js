// The field in 3D, by three.js.

import { DARK_LAMP, el, shines, solidsOf } from './draw.js';
import { pathColour } from './field.js';

const SLOW = 36; // ms from frame to frame: above it, what moves is drawn with fewer pixels
const STILL = 250; // ms after the last frame until it is drawn with all of them
const COARSEST = 0.4; // of the pixels along each side

/** Runs three.js, which then is `window.THREE`. Throws where the browser has no WebGL. */
export async function make3d(/** @type {HTMLCanvasElement} */ canvas, /** @type {import('./data.js').Source} */ source,
  /** @type {{minX: number, minY: number, maxX: number, maxY: number}} */ area, /** @type {() => void} */ redraw) {
  const tried = document.createElement('canvas').getContext('webgl');
  if (!tried) throw new Error('no WebGL');
  const names = tried.getExtension('WEBGL_debug_renderer_info');
  const renderer = names ? tried.getParameter(names.UNMASKED_RENDERER_WEBGL) : '';
  tried.getExtension('WEBGL_lose_context')?.loseContext();
  const global = /** @type {any} */ (window);
  if (!global.THREE) await source.three();
  return new View3d(global.THREE, canvas, area, redraw, /swiftshader|llvmpipe|software/i.test(renderer));
}

class View3d {
  constructor(/** @type {any} */ three, /** @type {HTMLCanvasElement} */ canvas, /** @type {any} */ area, /** @type {() => void} */ redraw, /** @type {boolean} */ inSoftware) {
    this.three = three;
    this.canvas = canvas;
    this.redraw = redraw;
    this.renderer = new three.WebGLRenderer({ canvas, alpha: true, antialias: !inSoftware });
    this.world = new three.Scene();
    this.world.add(new three.HemisphereLight(0xffffff, 0x777788, 0.75));
    const sun = new three.DirectionalLight(0xffffff, 0.45);
    sun.position.set(3, -5, 9);
    this.world.add(sun);
    this.camera = new three.PerspectiveCamera(38, 1, 0.1, 500);
    this.camera.up.set(0, 0, 1);
    this.middle = [(area.minX + area.maxX) / 2, (area.minY + area.maxY) / 2, 0];
    this.width = area.maxX - area.minX;
    this.depth = area.maxY - area.minY;
    this.turn = 0;
    this.tilt = 1.08;
    this.distance = 0; // until it is known how wide the canvas is
    /** @type {Map<number, any>} */
    this.groups = new Map();
    /** @type {Map<string, any>} */
    this.meshes = new Map();
    this.material = new three.MeshLambertMaterial({ vertexColors: three.VertexColors });
    this.ring = new three.Mesh(new three.RingBufferGeometry(0.9, 1, 40), new three.MeshBasicMaterial({ color: 0x1060ff, side: three.DoubleSide }));
    this.world.add(this.ring);
    /** @type {any[]} */
    this.lines = [];
    this.sharp = inSoftware ? 0.8 : Math.min(devicePixelRatio || 1, 2); // fewer pixels where the processor draws them
    this.share = 1; // of `sharp`, while the picture moves
    this.moves = false;
    this.drawn = 0; // ms
    this.pause = 0; // ms from frame to frame, on average
    this.timer = 0;
    this.listen();
  }

  /** Drag to turn, with shift or the right button to move, wheel to come nearer. */
  listen() {
    const canvas = this.canvas;
    /** @type {{x: number, y: number, moves: boolean}|null} */
    let last = null;
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
    canvas.addEventListener('pointerdown', (event) => {
      canvas.setPointerCapture(event.pointerId);
      last = { x: event.clientX, y: event.clientY, moves: event.shiftKey || event.button === 2 };
    });
    canvas.addEventListener('pointermove', (event) => {
      if (!last) return;
      const dx = event.clientX - last.x, dy = event.clientY - last.y;
      if (last.moves) {
        const step = this.distance / canvas.clientHeight, c = Math.cos(this.turn), s = Math.sin(this.turn);
        this.middle[0] -= step * (dx * c + dy * s);
        this.middle[1] -= step * (dx * s - dy * c);
      } else {
        this.turn -= dx * 0.006;
        this.tilt = Math.min(1.55, Math.max(0.1, this.tilt + dy * 0.006));
      }
      last = { ...last, x: event.clientX, y: event.clientY };
      this.redraw();
    });
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, () => (last = null));
    canvas.addEventListener('wheel', (event) => {
      event.preventDefault();
      this.distance = Math.min(100, Math.max(0.8, this.distance * Math.exp(event.deltaY * 0.001)));
      this.redraw();
    }, { passive: false });
  }

  /** The solids as one mesh, and one more for each lamp that blinks. */
  meshOf(/** @type {string} */ look) {
    let known = this.meshes.get(look);
    if (known) return known;
    const three = this.three;
    /** @type {{positions: number[], normals: number[], colours: number[], index: number[]}} */
    const steady = { positions: [], normals: [], colours: [], index: [] };
    const lamps = [];
    for (const solid of solidsOf(look)) {
      const [w, d, h] = solid.size;
      const geometry = solid.box ? new three.BoxBufferGeometry(w, d, h) : new three.CylinderBufferGeometry(w / 2, w / 2, h, 20);
      if (!solid.box) {
        geometry.rotateX(Math.PI / 2);
        geometry.scale(1, d / w, 1);
      }
      geometry.translate(solid.at[0], solid.at[1], solid.at[2] + h / 2);
      if (solid.blinks) {
        lamps.push({ geometry, lit: new three.MeshBasicMaterial({ color: solid.colour }) });
        continue;
      }
      const colour = new three.Color(solid.colour), start = steady.positions.length / 3;
      steady.positions.push(...geometry.attributes.position.array);
      steady.normals.push(...geometry.attributes.normal.array);
      for (let i = 0; i < geometry.attributes.position.count; ++i) steady.colours.push(colour.r, colour.g, colour.b);
      for (const i of geometry.index.array) steady.index.push(start + i);
    }
    const geometry = new three.BufferGeometry();
    geometry.setAttribute('position', new three.Float32BufferAttribute(steady.positions, 3));
    geometry.setAttribute('normal', new three.Float32BufferAttribute(steady.normals, 3));
    geometry.setAttribute('color', new three.Float32BufferAttribute(steady.colours, 3));
    geometry.setIndex(steady.index);
    known = { geometry, lamps };
    this.meshes.set(look, known);
    return known;
  }

  groupOf(/** @type {import('./scene.js').Seen} */ seen) {
    let group = this.groups.get(seen.track.id);
    if (!group) {
      group = { object: new this.three.Group(), look: null, lamps: [] };
      if (seen.track.moves && seen.state && !seen.carrier) group.object.add(this.label(seen));
      this.groups.set(seen.track.id, group);
      this.world.add(group.object);
    }
    if (group.look !== seen.look) {
      for (const old of [...group.object.children]) if (old.isMesh) group.object.remove(old);
      const { geometry, lamps } = this.meshOf(seen.look);
      if (geometry.index.count) group.object.add(new this.three.Mesh(geometry, this.material));
      group.lamps = lamps.map((/** @type {any} */ lamp) => {
        const mesh = new this.three.Mesh(lamp.geometry, lamp.lit);
        group.object.add(mesh);
        return { mesh, lit: lamp.lit };
      });
      group.look = seen.look;
    }
    return group;
  }

  label(/** @type {import('./scene.js').Seen} */ seen) {
    const canvas = el('canvas', { width: 256, height: 64 }), context = canvas.getContext('2d');
    context.font = '600 40px system-ui, sans-serif';
    context.textAlign = 'center';
    context.lineWidth = 8;
    context.strokeStyle = 'rgba(255, 255, 255, 0.9)';
    context.fillStyle = '#111';
    context.strokeText(seen.track.name, 128, 46);
    context.fillText(seen.track.name, 128, 46);
    const texture = new this.three.CanvasTexture(canvas);
    const sprite = new this.three.Sprite(new this.three.SpriteMaterial({ map: texture, depthTest: false }));
    const top = Math.max(...solidsOf(seen.look).map((s) => s.at[2] + s.size[2]), 0.1);
    const size = Math.max(this.width, this.depth) / 14;
    sprite.scale.set(size * 1.6, size * 0.4, 1);
    sprite.position.set(0, 0, top + size * 0.2);
    sprite.renderOrder = 2;
    return sprite;
  }

  draw(/** @type {import('./scene.js').Seen[]} */ seen, /** @type {any[]} */ paths, /** @type {number} */ t, /** @type {string} */ chosen) {
    const there = new Set();
    this.ring.visible = false;
    for (const one of seen) {
      const group = this.groupOf(one);
      there.add(one.track.id);
      group.object.position.set(...one.at.position);
      group.object.quaternion.set(...one.at.turn);
      for (const lamp of group.lamps) lamp.mesh.material = shines(t) ? lamp.lit : this.dark();
      if (one.track.name === chosen) {
        const radius = 1.25 * Math.max(0.05, ...solidsOf(one.look).map((s) => Math.max(s.size[0], s.size[1]) / 2));
        this.ring.visible = true;
        this.ring.position.set(one.at.position[0], one.at.position[1], one.at.position[2] + 0.02);
        this.ring.scale.set(radius, radius, 1);
      }
    }
    for (const [id, group] of this.groups) group.object.visible = there.has(id);
    this.drawPaths(paths, t);
    this.pace();
    this.resize();
    this.renderer.render(this.world, this.camera);
  }

  /** Which of them is seen there; a name, where nothing lies before it. */
  under(/** @type {MouseEvent} */ event, /** @type {import('./scene.js').Seen[]} */ things) {
    const ray = new this.three.Raycaster();
    ray.setFromCamera({ x: (2 * event.offsetX) / this.canvas.clientWidth - 1, y: 1 - (2 * event.offsetY) / this.canvas.clientHeight }, this.camera);
    const objects = new Map(things.map((one) => [this.groups.get(one.track.id)?.object, one]));
    const parts = [...objects.keys()].flatMap((object) => object?.children || []);
    const first = (/** @type {boolean} */ solid) => ray.intersectObjects(parts.filter((part) => Boolean(part.isMesh) === solid))[0];
    return objects.get((first(true) || first(false))?.object.parent);
  }

  /** While the picture moves it has as many pixels as can be drawn in time; then all of them. */
  pace() {
    const now = performance.now(), pause = now - this.drawn;
    this.drawn = now;
    this.moves = pause < STILL;
    this.pause = this.moves ? 0.8 * this.pause + 0.2 * pause : 0;
    if (this.pause > SLOW) {
      this.share = Math.max(COARSEST, 0.8 * this.share);
      this.pause = 0.7 * SLOW;
    }
    clearTimeout(this.timer);
    this.timer = setTimeout(() => { if (this.moves && this.share < 1) this.redraw(); }, STILL);
  }

  dark() {
    return (this.darkMaterial = this.darkMaterial || new this.three.MeshBasicMaterial({ color: DARK_LAMP }));
  }

  drawPaths(/** @type {any[]} */ paths, /** @type {number} */ t) {
    const three = this.three;
    for (const line of this.lines) line.visible = false;
    let used = 0;
    for (const { track, points } of paths)
      for (const after of [false, true]) {
        const part = points.filter((/** @type {any} */ point) => (after ? point.t >= t - 0.5 : point.t <= t + 0.5));
        if (part.length < 2) continue;
        const line = (this.lines[used] = this.lines[used] || this.addLine(points.length + 130));
        ++used;
        const positions = line.geometry.attributes.position;
        const count = Math.min(part.length, positions.count);
        for (let i = 0; i < count; ++i) positions.setXYZ(i, part[i].position[0], part[i].position[1], part[i].position[2] + 0.015);
        positions.needsUpdate = true;
        line.geometry.setDrawRange(0, count);
        line.material.color.set(new three.Color(pathColour(track)));
        line.material.opacity = after ? 0.45 : 0.9;
        line.visible = true;
      }
  }

  addLine(/** @type {number} */ count) {
    const three = this.three, geometry = new three.BufferGeometry();
    geometry.setAttribute('position', new three.BufferAttribute(new Float32Array(3 * count), 3));
    const line = new three.Line(geometry, new three.LineBasicMaterial({ transparent: true }));
    line.frustumCulled = false;
    this.world.add(line);
    return line;
  }

  resize() {
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    const ratio = this.sharp * (this.moves ? this.share : 1);
    if (this.canvas.width !== Math.floor(width * ratio) || this.canvas.height !== Math.floor(height * ratio)) {
      this.renderer.setPixelRatio(ratio);
      this.renderer.setSize(width, height, false);
    }
    this.camera.aspect = width / Math.max(1, height);
    const half = Math.tan((this.camera.fov * Math.PI) / 360);
    // The whole field fills the picture.
    if (!this.distance) this.distance = Math.max((this.width / 2 / half / this.camera.aspect) * 1.02, (this.depth / 2 / half) * 1.05) + this.depth * 0.16;
    const flat = this.distance * Math.cos(this.tilt);
    this.camera.position.set(this.middle[0] + flat * Math.sin(this.turn), this.middle[1] - flat * Math.cos(this.turn), this.distance * Math.sin(this.tilt));
    this.camera.lookAt(...this.middle);
    this.camera.updateProjectionMatrix();
  }
}
