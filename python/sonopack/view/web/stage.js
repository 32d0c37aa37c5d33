/* The picture: grains, contacts, box and camera, drawn by three.js. */
import { colourTable, palettes, rgb, isDark } from './colours.js';
import { grainVertex, grainFragment, contactVertex, contactFragment } from './shaders.js';

const COLUMNS = 1024; // texels in a row

function floatTexture(width, height, data) {
  const texture = new THREE.DataTexture(data, width, height, THREE.RGBAFormat, THREE.FloatType);
  texture.magFilter = THREE.NearestFilter;
  texture.minFilter = THREE.NearestFilter;
  texture.needsUpdate = true;
  return texture;
}

/* Whether a processor stands in for the graphics card: smooth edges then cost too much. */
function drawsBySoftware() {
  const gl = document.createElement('canvas').getContext('webgl2');
  const names = gl && gl.getExtension('WEBGL_debug_renderer_info');
  const renderer = names ? gl.getParameter(names.UNMASKED_RENDERER_WEBGL) : '';
  if (gl && gl.getExtension('WEBGL_lose_context')) gl.getExtension('WEBGL_lose_context').loseContext();
  return /swiftshader|llvmpipe|software/i.test(renderer);
}

/* A texture with room for so many texels. */
function numberTexture(texels) {
  const rows = Math.max(1, Math.ceil(texels / COLUMNS));
  return floatTexture(COLUMNS, rows, new Float32Array(4 * COLUMNS * rows));
}

/* Corners 4 k .. 4 k + 3 are those of square k; the shaders place them. */
function squares(count) {
  const geometry = new THREE.BufferGeometry();
  const index = new Uint32Array(6 * count);
  for (let k = 0; k < count; k++) index.set([0, 1, 2, 0, 2, 3].map((corner) => 4 * k + corner), 6 * k);
  geometry.setIndex(new THREE.BufferAttribute(index, 1));
  return geometry;
}

/* The vectors along the three edges of the box; 0 along axes that the packing does not have. */
export function edgesOf({ box, cell, tilt = [0, 0, 0] }) {
  if (cell === 'ring') return [[box[0], 0, 0], [0, box[0], 0], [0, 0, 0]];
  const [xy, xz, yz] = tilt;
  return [[box[0], 0, 0], [xy, box[1] || 0, 0], [xz, yz, box[2] || 0]];
}

/* Contacts as they are drawn: one that passes through the side of the box is drawn as two halves. */
export function layOutContacts(packing) {
  const { contact, image, fn, carrying, wall_point: points, dimension: dim } = packing;
  const edges = edgesOf(packing);
  const drawn = { of: [], links: [] }; // the contact that each belongs to; two texels each
  const add = (c, i, j, shift, share) => {
    drawn.of.push(c);
    drawn.links.push(i, j, share, carrying[c], shift[0] || 0, shift[1] || 0, shift[2] || 0, 0);
  };
  let wall = 0;
  for (let c = 0; c < fn.length; c++) {
    const [i, j] = [contact[2 * c], contact[2 * c + 1]];
    if (j < 0) {
      add(c, i, -1, points.subarray(wall * dim, (wall + 1) * dim), 1);
      wall++;
      continue;
    }
    const shift = [0, 1, 2].map((axis) => edges.slice(0, dim)
      .reduce((sum, edge, a) => sum + edge[axis] * image[c * dim + a], 0));
    if (shift.every((x) => x === 0)) add(c, i, j, shift, 1);
    else {
      add(c, i, j, shift, 0.5);
      add(c, j, i, shift.map((x) => -x), 0.5);
    }
  }
  return drawn;
}

export class Stage {
  constructor(canvas, onChange) {
    this.canvas = canvas;
    this.onChange = onChange;
    this.hard = drawsBySoftware();
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: !this.hard, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    this.scene = new THREE.Scene();
    this.camera = new THREE.OrthographicCamera(-1, 1, 1, -1, 0.1, 10);
    this.parts = [];
    this.turned = false;
    this.size = [1, 1];
    this.margin = 0;
  }

  /* Shows another packing. */
  open(packing) {
    for (const part of this.parts) {
      this.scene.remove(part);
      part.geometry.dispose();
      part.material.dispose();
    }
    this.packing = packing;
    this.dim = packing.dimension;
    this.edges = edgesOf(packing);
    this.low = [0, 1, 2].map((axis) => this.edges.reduce((sum, edge) => sum + Math.min(0, edge[axis]), 0));
    this.extent = [0, 1, 2].map((axis) => this.edges.reduce((sum, edge) => sum + Math.abs(edge[axis]), 0));
    this.makeTextures(packing.grains);
    this.makeGrains(packing.grains);
    this.makeContacts(packing);
    this.makeBox();
    this.parts = [this.contacts, this.grains, this.box];
    this.parts.forEach((part) => this.scene.add(part));
    this.applyPalette();
    this.turned = this.dim === 2 && this.extent[1] > 2 * this.extent[0] && this.size[0] > this.size[1];
    this.resetCamera();
  }

  makeTextures(n) {
    if (this.textures) for (const texture of Object.values(this.textures)) texture.dispose();
    this.textures = { place: numberTexture(n), look: numberTexture(n) };
    this.place = this.textures.place.image.data;
    this.look = this.textures.look.image.data;
    this.grainScale = floatTexture(256, 1, colourTable('sequence'));
    this.contactScale = floatTexture(256, 1, colourTable('forceLight'));
  }

  common() {
    return { place: { value: this.textures.place }, look: { value: this.textures.look }, columns: { value: COLUMNS },
      depths: { value: [0, 1] }, ground: { value: [1, 1, 1] } };
  }

  defines() {
    return this.dim < 3 ? {} : this.hard ? { SOLID: 1, HARD: 1 } : { SOLID: 1 };
  }

  makeGrains(n) {
    const material = new THREE.RawShaderMaterial({ glslVersion: THREE.GLSL3, vertexShader: grainVertex,
      fragmentShader: grainFragment, defines: this.defines(), transparent: this.dim < 3, alphaToCoverage: this.dim === 3,
      uniforms: { ...this.common(), scale: { value: this.grainScale }, size: { value: 1 }, marks: { value: 0 },
        plain: { value: [0, 0, 0] }, rattler: { value: [0, 0, 0] }, edge: { value: [0, 0, 0] },
        chosen: { value: [0, 0, 0] } } });
    this.grains = new THREE.Mesh(squares(n), material);
    this.grains.frustumCulled = false; // it has no places of its own
    this.grains.renderOrder = 0;
  }

  makeContacts(packing) {
    this.drawn = layOutContacts(packing);
    const count = this.drawn.of.length;
    this.textures.links = numberTexture(2 * count);
    this.textures.links.image.data.set(this.drawn.links);
    this.textures.shapes = numberTexture(count);
    const material = new THREE.RawShaderMaterial({ glslVersion: THREE.GLSL3, vertexShader: contactVertex,
      fragmentShader: contactFragment, defines: this.defines(), side: THREE.DoubleSide, transparent: this.dim < 3,
      uniforms: { ...this.common(), links: { value: this.textures.links }, shapes: { value: this.textures.shapes },
        scale: { value: this.contactScale }, width: { value: 1 }, least: { value: 0.01 },
        raised: { value: this.dim === 3 ? 0 : 1.5 }, weak: { value: [0, 0, 0] } } });
    this.contacts = new THREE.Mesh(squares(count), material);
    this.contacts.frustumCulled = false;
    this.contacts.renderOrder = 1;
  }

  /* Edges of the box; a chain has a line at each wall, a ring two circles. */
  makeBox() {
    const [x] = this.extent;
    const points = [];
    const corner = (...steps) => [0, 1, 2].map((axis) =>
      this.edges.reduce((sum, edge, a) => sum + (steps[a] || 0) * edge[axis], 0));
    const line = (from, to) => points.push(...corner(...from), ...corner(...to));
    if (this.dim === 1) points.push(0, -1, 0, 0, 1, 0, x, -1, 0, x, 1, 0);
    const { box, cell } = this.packing;
    for (const r of cell === 'ring' ? [box[0] / 2, box[0] / 2 - box[1]] : []) {
      const at = (k) => [box[0] / 2 + r * Math.cos(k * Math.PI / 180), box[0] / 2 + r * Math.sin(k * Math.PI / 180), 0];
      for (let k = 0; k < 360; k++) points.push(...at(k), ...at(k + 1));
    }
    for (const a of this.dim === 1 || cell === 'ring' ? [] : [0, 1]) {
      for (const b of this.dim === 2 ? [0] : [0, 1]) {
        line([0, a, b], [1, a, b]);
        line([a, 0, b], [a, 1, b]);
        if (this.dim === 3) line([a, b, 0], [a, b, 1]);
      }
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(points), 3));
    this.box = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: 0x808080 }));
    this.box.renderOrder = 2;
  }

  /* ---- camera ---------------------------------------------------------------------------------------------------- */

  /* Half the height of the view that shows everything. */
  halfHeight() {
    const [x, y, z] = this.extent;
    const ratio = (this.size[0] - this.margin) / this.size[1];
    const margin = 1.06;
    if (this.dim === 3) return margin * 0.5 * Math.hypot(x, y, z) * Math.max(1, 1 / ratio) * 0.95;
    const [across, up] = this.turned ? [y, x] : [x, Math.max(y, 2)];
    return margin * 0.5 * Math.max(up, across / ratio);
  }

  resetCamera(azimuth = -60, elevation = 18) {
    const [x, y, z] = this.extent.map((length, axis) => this.low[axis] + length / 2);
    const reach = 2 * Math.hypot(...this.extent) + 10;
    const [a, e] = [azimuth, elevation].map((angle) => angle * Math.PI / 180);
    const away = this.dim === 3 ? [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)] : [0, 0, 1];
    this.camera.up.set(...(this.dim === 3 ? [0, 0, 1] : this.turned ? [-1, 0, 0] : [0, 1, 0]));
    this.camera.position.set(x + reach * away[0], y + reach * away[1], z + reach * away[2]);
    this.camera.near = 0.1;
    this.camera.far = 2 * reach;
    this.camera.zoom = 1;
    if (this.controls) this.controls.dispose();
    this.controls = new THREE.OrbitControls(this.camera, this.canvas);
    this.controls.target.set(x, y, z);
    this.controls.enableRotate = this.dim === 3;
    this.controls.zoomToCursor = true;
    if (this.dim < 3) {
      this.controls.mouseButtons.LEFT = THREE.MOUSE.PAN;
      this.controls.touches.ONE = THREE.TOUCH.PAN;
    }
    this.controls.update();
    this.controls.addEventListener('change', this.onChange);
    const half = 0.5 * Math.hypot(...this.extent);
    for (const part of [this.grains, this.contacts]) part.material.uniforms.depths.value = [reach - half, reach + half];
    this.resize(...this.size, this.margin);
  }

  /* margin: pixels at the left that the legend covers; the packing stands beside them. */
  resize(width, height, margin = 0) {
    this.size = [Math.max(1, width), Math.max(1, height)];
    this.margin = margin;
    this.renderer.setSize(...this.size, false);
    if (!this.packing) return;
    const half = this.halfHeight();
    const pixel = 2 * half / this.size[1];
    const right = 0.5 * pixel * (this.size[0] - this.margin);
    Object.assign(this.camera, { left: -right - pixel * this.margin, right, top: half, bottom: -half });
    this.camera.updateProjectionMatrix();
    this.onChange();
  }

  /* Length of a pixel of the page [d]. */
  pixel() {
    return (this.camera.top - this.camera.bottom) / this.camera.zoom / this.size[1];
  }

  /* ---- looks ----------------------------------------------------------------------------------------------------- */

  applyPalette() {
    const palette = palettes[isDark() ? 'dark' : 'light'];
    this.renderer.setClearColor(palette.ground);
    if (!this.packing) return;
    for (const name of ['plain', 'rattler', 'edge', 'chosen', 'ground'])
      this.grains.material.uniforms[name].value = rgb(palette[name === 'plain' ? 'grain' : name]);
    this.contacts.material.uniforms.weak.value = rgb(palette.weak);
    this.contacts.material.uniforms.ground.value = rgb(palette.ground);
    this.box.material.color.set(palette.line);
  }

  setGrainScale(scale) {
    this.grainScale.image.data.set(colourTable(scale));
    this.grainScale.needsUpdate = true;
  }

  /* width and value of contact c of the packing: functions of c. */
  setContacts(scale, widthOf, valueOf) {
    const { shapes } = this.textures;
    this.drawn.of.forEach((c, k) => {
      shapes.image.data[4 * k] = widthOf(c);
      shapes.image.data[4 * k + 1] = valueOf(c);
    });
    shapes.needsUpdate = true;
    this.contactScale.image.data.set(colourTable(scale));
    this.contactScale.needsUpdate = true;
  }

  /* After `place' and `look' have been filled. */
  upload() {
    this.textures.place.needsUpdate = true;
    this.textures.look.needsUpdate = true;
  }

  draw() {
    this.contacts.material.uniforms.least.value = 0.6 * this.pixel();
    this.renderer.render(this.scene, this.camera);
  }

  /* The grain under a point of the page, or -1. */
  pick(x, y) {
    const frame = this.canvas.getBoundingClientRect();
    const size = this.grains.material.uniforms.size.value;
    const ndc = [(x - frame.left) / frame.width * 2 - 1, 1 - (y - frame.top) / frame.height * 2];
    this.camera.updateMatrixWorld();
    const at = new THREE.Vector3();
    let [best, nearest] = [-1, Infinity];
    const [wide, high] = this.size.map((pixels) => 0.5 * pixels * this.pixel());
    for (let i = 0; i < this.packing.grains; i++) {
      if (this.look[4 * i + 1] < -0.5) continue;
      at.set(this.place[4 * i], this.place[4 * i + 1], this.place[4 * i + 2]).project(this.camera);
      const [dx, dy] = [(at.x - ndc[0]) * wide, (at.y - ndc[1]) * high];
      if (Math.hypot(dx, dy) > this.place[4 * i + 3] * size || at.z >= nearest) continue;
      [best, nearest] = [i, at.z];
    }
    return best;
  }
}
