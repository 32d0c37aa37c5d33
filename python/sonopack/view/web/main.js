/* The page: what is shown, and what changes it. */
import { readData, quantile } from './data.js';
import { Units, plainNumber } from './units.js';
import { Motion } from './motion.js';
import { Stage } from './stage.js';
import { SignalPlot } from './signal.js';
import { drawLegend } from './legend.js';
import { grainColourings, contactColourings } from './colouring.js';
import { readAddress, numberOf, writeAddress } from './address.js';
import { composePicture } from './picture.js';
import { Panel, byId } from './panel.js';

const VIEWS = ['packing', 'mode', 'wave'];
const SWING = 2.4; // seconds that a period of a mode takes on the screen
const PASSAGE = 24; // seconds that the whole wave takes

class App {
  constructor() {
    const data = readData(byId('sonopack-data'));
    this.packings = data.packings;
    this.si = data.units === 'si';
    this.stage = new Stage(byId('picture'), () => this.request());
    this.plot = new SignalPlot(byId('signal'), (time) => this.setTime(time));
    this.playing = false;
    this.view = 'packing';
    this.panel = new Panel(this);
    this.resize();
    this.openPacking(0);
    this.follow(readAddress(location.hash));
    new ResizeObserver(() => this.resize()).observe(byId('view'));
    window.addEventListener('hashchange', () => this.follow(readAddress(location.hash)));
    const dark = window.matchMedia('(prefers-color-scheme: dark)');
    dark.addEventListener('change', () => { this.stage.applyPalette(); this.showContacts(); this.refresh(); });
  }

  openPacking(number) {
    this.number = number;
    this.packing = this.packings[number];
    this.units = new Units(this.si ? this.packing.material : null);
    this.motion = new Motion(this.packing);
    this.mode = 0;
    this.time = 0;
    this.chosen = -1;
    const solid = this.packing.dimension === 3;
    const still = { colour: 'none', chains: true, size: solid ? 0.4 : 1, rattlers: true };
    const moving = { colour: 'vertical', chains: false, size: solid ? 0.9 : 1, rattlers: true };
    this.all = { packing: still, mode: { ...moving, colour: 'displacement' }, wave: moving };
    for (const view of VIEWS) Object.assign(this.all[view], { width: 1, amplitude: 1, speed: 1, cut: 0, contact: 'force' });
    this.stage.open(this.packing);
    this.plot.open(this.packing.wave && this.packing.wave.signal, this.units);
    this.setView(this.has(this.view) ? this.view : 'packing');
  }

  /* SI units need a material. */
  setUnits(si) {
    this.si = si;
    this.units = new Units(si ? this.packing.material : null);
    this.plot.open(this.packing.wave && this.packing.wave.signal, this.units);
    this.panel.rebuild();
    this.refresh();
  }

  /* Whether the packing has what a view shows. */
  has(view) {
    const { modes, wave } = this.packing;
    return view === 'packing' || Boolean(view === 'mode' ? modes && modes.u : wave && wave.u);
  }

  setView(view) {
    this.view = view;
    this.settings = this.all[view];
    this.time = 0;
    document.body.dataset.view = view;
    document.body.dataset.signal = view === 'wave' && this.has('wave') && this.plot.signal ? 'shown' : 'none';
    this.setPlaying(view !== 'packing' && this.has(view) && !window.matchMedia('(prefers-reduced-motion)').matches);
    this.showContacts();
    this.panel.rebuild();
    this.resize();
    this.refresh();
  }

  /* ---- what is shown --------------------------------------------------------------------------------------------- */

  grainColouring() {
    if (!this.colourings) this.colourings = grainColourings(this);
    return this.colourings.find((c) => c.key === this.settings.colour) || this.colourings[0];
  }

  contactColouring() {
    const list = contactColourings(this.packing);
    return list.find((c) => c.key === this.settings.contact) || list[0];
  }

  /* Of modes: the largest displacement [d]. Of waves: the factor of displacements. */
  amplitude() {
    return 0.4 * this.settings.amplitude;
  }

  factor() {
    if (this.view !== 'wave' || !this.has('wave')) return 1;
    return this.amplitude() / (quantile(Array.from(this.packing.wave.length).slice(1), 0.5) || 1);
  }

  /* Width of the line of a contact [d]: proportional to the force. */
  lineWidth(force) {
    const { mean } = this.contacts;
    const usual = this.packing.dimension === 3 ? 0.09 : 0.14;
    return Math.min(0.9, usual * this.settings.width * force / (mean || 1));
  }

  showContacts() {
    const { packing, settings } = this;
    this.contacts = this.contactColouring();
    const { low, high, value, scale } = this.contacts;
    this.stage.contacts.visible = settings.chains;
    if (!settings.chains) return;
    const hidden = (c) => !settings.chains || (!packing.carrying[c] && !settings.rattlers);
    this.stage.setContacts(scale, (c) => (hidden(c) ? -1 : this.lineWidth(packing.fn[c])),
      (c) => Math.min(1, (value(c) - low) / (high - low)));
  }

  move() {
    if (this.view === 'mode' && this.has('mode')) this.motion.setMode(this.mode, this.time, this.amplitude());
    else if (this.view === 'wave' && this.has('wave')) this.motion.setWave(this.time);
    else this.motion.clear();
  }

  /* Fills the textures of the stage. */
  paint() {
    const { packing, stage, motion, settings } = this;
    const { x, r, rattler, dimension: dim } = packing;
    const { place, look } = stage;
    const colour = this.grainColouring();
    const factor = this.factor();
    const below = dim === 3 ? stage.low[1] + settings.cut * stage.extent[1] : 0;
    for (let i = 0; i < packing.grains; i++) {
      for (let a = 0; a < 3; a++) place[4 * i + a] = (a < dim ? x[i * dim + a] : 0) + factor * motion.shift[3 * i + a];
      place[4 * i + 3] = r[i];
      const hidden = (rattler[i] && !settings.rattlers) || (dim === 3 && x[i * dim + 1] < below);
      const value = colour.value && !rattler[i] ? (colour.value(i) - colour.low) / (colour.high - colour.low) : -1;
      look[4 * i] = colour.value && !rattler[i] ? Math.min(1, Math.max(0, value)) : -1;
      look[4 * i + 1] = hidden ? -1 : i === this.chosen ? 2 : rattler[i];
      look[4 * i + 2] = Math.PI / 2 + factor * motion.turn[3 * i + 2];
    }
    stage.upload();
  }

  /* Everything again, after a change of settings. */
  refresh() {
    this.colourings = null;
    const colour = this.grainColouring();
    const uniforms = this.stage.grains.material.uniforms;
    if (colour.scale) this.stage.setGrainScale(colour.scale);
    uniforms.size.value = this.settings.size;
    uniforms.marks.value = this.packing.dimension === 2 && this.motion.turns > 0 && this.view !== 'packing' ? 1 : 0;
    this.changed = true;
    this.request();
  }

  request() {
    if (this.requested) return;
    this.requested = true;
    requestAnimationFrame((now) => this.frame(now));
  }

  frame(now) {
    this.requested = false;
    if (this.playing) this.advance(Math.min(0.1, (now - (this.before || now)) / 1000));
    this.before = this.playing ? now : 0;
    this.drawNow();
    if (this.playing) this.request();
  }

  drawNow() {
    if (this.changed) {
      this.move();
      this.paint();
      this.changed = false;
      this.panel.showTime();
      if (this.view === 'wave') this.plot.draw(this.time);
    }
    this.stage.draw();
    this.showLegend();
  }

  showLegend() {
    const key = JSON.stringify([this.number, this.view, this.mode, this.settings, this.si, this.stage.turned, this.stage.pixel().toPrecision(3),
      this.contacts.scale]);
    if (key === this.legend) return;
    this.legend = key;
    const before = byId('legend').offsetWidth;
    drawLegend(byId('legend'), this);
    if (byId('legend').offsetWidth !== before) this.resize();
  }

  /* ---- time ------------------------------------------------------------------------------------------------------ */

  /* In periods of a mode; of a wave [d/sqrt(E* / rho)]. */
  longest() {
    return this.view === 'wave' && this.has('wave') ? this.packing.wave.until : 1;
  }

  advance(seconds) {
    const span = this.view === 'wave' ? PASSAGE : SWING;
    this.time += seconds * this.settings.speed * this.longest() / span;
    if (this.time > this.longest()) this.time %= this.longest();
    this.changed = true;
  }

  setTime(time) {
    this.time = Math.min(this.longest(), Math.max(0, time));
    this.setPlaying(false);
    this.changed = true;
    this.request();
  }

  setPlaying(on) {
    this.playing = on;
    this.panel.showPlaying(on);
    this.request();
  }

  setMode(k) {
    const { modes } = this.packing;
    if (!this.has('mode')) return;
    this.mode = Math.min(modes.rows.length - 1, Math.max(0, k));
    this.panel.showMode();
    this.refresh();
  }

  /* ---- address, size, picture ------------------------------------------------------------------------------------ */

  follow(address) {
    const number = numberOf(address, 'packing', this.number + 1) - 1;
    if (number !== this.number && this.packings[number]) this.openPacking(number);
    if ('mode' in address && this.packing.modes) this.setView('mode');
    else if ('wave' in address && this.packing.wave) this.setView('wave');
    else if ('packing' in address) this.setView('packing');
    if ('mode' in address && this.has('mode')) this.setMode(numberOf(address, 'mode', 0) - this.packing.modes.first);
    const { settings } = this;
    if (address.colour) settings.colour = address.colour;
    if (address.contact) settings.contact = address.contact;
    settings.chains = numberOf(address, 'chains', settings.chains ? 1 : 0) !== 0;
    settings.rattlers = numberOf(address, 'rattlers', settings.rattlers ? 1 : 0) !== 0;
    for (const name of ['size', 'width', 'amplitude', 'speed', 'cut'])
      settings[name] = numberOf(address, name, settings[name]);
    if (address.units) this.setUnits(address.units === 'si');
    if (address.turn) this.stage.resetCamera(...address.turn.split(',').map(Number));
    if ('t' in address) this.setTime(numberOf(address, 't', 0));
    this.showContacts();
    this.panel.rebuild();
    this.refresh();
    this.drawNow();
    if ('measure' in address) this.measure(numberOf(address, 'measure', 30));
  }

  address() {
    return writeAddress(this);
  }

  resize() {
    const [view, legend] = [byId('view'), byId('legend')];
    const beside = getComputedStyle(legend).position === 'absolute' && view.clientWidth > 2 * legend.offsetWidth;
    this.legend = '';
    this.stage.resize(view.clientWidth, view.clientHeight, beside ? legend.offsetWidth + 16 : 0);
    this.changed = true;
  }

  /* What is shown now, with its legend, as a canvas. */
  picture() {
    this.drawNow();
    return composePicture(byId('frame'), byId('picture'), byId('signal'));
  }

  savePicture() {
    this.picture().toBlob((blob) => {
      const link = document.createElement('a');
      link.href = URL.createObjectURL(blob);
      link.download = `${this.packing.name.replace(/\.[^.]*$/, '')}-${this.view}.png`;
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    });
  }

  /* Frames a second, each with new places of all grains and waiting until it is drawn. */
  measure(frames) {
    const gl = this.stage.renderer.getContext();
    const pixel = new Uint8Array(4);
    const begin = performance.now();
    for (let k = 0; k < frames; k++) {
      this.time = this.longest() * k / frames;
      this.changed = true;
      this.drawNow();
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    }
    const rate = 1000 * frames / (performance.now() - begin);
    document.documentElement.dataset.framesPerSecond = plainNumber(rate);
    return rate;
  }
}

function start() {
  try {
    window.sonopack = new App();
    document.documentElement.dataset.state = 'ready';
  } catch (error) {
    document.documentElement.dataset.state = 'failed';
    byId('failure').hidden = false;
    const canDraw = document.createElement('canvas').getContext('webgl2');
    if (canDraw) byId('failure').textContent = `The page has failed: ${error.message}`; // not for want of WebGL
    throw error;
  }
}

start();
