/* The controls beside the picture, the keyboard, and the dialogs. */
import { grainColourings, contactColourings } from './colouring.js';
import { plainNumber } from './units.js';

export function byId(name) {
  return document.getElementById(name);
}

function text(name, value) {
  byId(name).textContent = value;
}

function fillSelect(select, list, chosen) {
  select.replaceChildren(...list.map(({ key, name, title }) => new Option(name || title, key, false, key === chosen)));
  if (!list.some(({ key }) => key === chosen)) select.selectedIndex = 0;
}

/* Range controls: id, and the setting that each changes. */
const ranges = ['size', 'width', 'amplitude', 'speed', 'cut'];

export class Panel {
  constructor(app) {
    this.app = app;
    for (const view of ['packing', 'mode', 'wave']) byId(`view-${view}`).onclick = () => app.setView(view);
    byId('packings').onchange = (event) => app.openPacking(Number(event.target.value));
    byId('si').onchange = (event) => app.setUnits(event.target.checked);
    byId('modes').onchange = (event) => app.setMode(Number(event.target.value));
    byId('time').oninput = (event) => app.setTime(Number(event.target.value) * app.longest());
    byId('play').onclick = () => app.setPlaying(!app.playing);
    byId('colour').onchange = (event) => this.set('colour', event.target.value);
    byId('contact').onchange = (event) => this.set('contact', event.target.value);
    for (const name of ['chains', 'rattlers'])
      byId(name).onchange = (event) => this.set(name, event.target.checked);
    for (const name of ranges) byId(name).oninput = (event) => this.set(name, Number(event.target.value));
    byId('reset').onclick = () => { app.stage.resetCamera(); app.request(); };
    byId('save').onclick = () => app.savePicture();
    byId('link').onclick = () => { location.hash = app.address(); };
    for (const name of ['help', 'about']) {
      byId(`open-${name}`).onclick = () => byId(name).showModal();
      byId(`close-${name}`).onclick = () => byId(name).close();
    }
    document.addEventListener('keydown', (event) => this.key(event));
    this.watchPicture();
  }

  set(name, value) {
    this.app.settings[name] = value;
    if (name !== 'size' && name !== 'speed' && name !== 'amplitude') this.app.showContacts();
    this.app.refresh();
    this.showWords();
  }

  /* A click that is no drag chooses a grain. */
  watchPicture() {
    let down = [0, 0];
    const picture = byId('picture');
    picture.addEventListener('pointerdown', (event) => { down = [event.clientX, event.clientY]; });
    picture.addEventListener('pointerup', (event) => {
      if (Math.hypot(event.clientX - down[0], event.clientY - down[1]) > 4) return;
      this.app.chosen = this.app.stage.pick(event.clientX, event.clientY);
      this.showGrain();
      this.app.refresh();
    });
  }

  /* ---- keyboard -------------------------------------------------------------------------------------------------- */

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || /^(SELECT|TEXTAREA)$/.test(event.target.tagName)) return;
    const { app } = this;
    const views = { 1: 'packing', 2: 'mode', 3: 'wave' };
    const step = app.view === 'wave' ? app.longest() / 200 : 1 / 48;
    const actions = { ' ': () => app.view !== 'packing' && app.setPlaying(!app.playing),
      ArrowRight: () => app.setTime(app.time + step), ArrowLeft: () => app.setTime(app.time - step),
      ArrowDown: () => app.view === 'mode' && app.setMode(app.mode + 1),
      ArrowUp: () => app.view === 'mode' && app.setMode(app.mode - 1),
      c: () => this.nextColour(), f: () => this.flip('chains'), r: () => this.flip('rattlers'),
      Home: () => byId('reset').click(), 0: () => byId('reset').click(), s: () => app.savePicture(),
      t: () => this.turn(), '?': () => byId('help').showModal() };
    if (event.key in views) app.setView(views[event.key]);
    else if (event.key in actions && !(event.target.type === 'range' && event.key.startsWith('Arrow')))
      actions[event.key]();
    else return;
    event.preventDefault();
  }

  nextColour() {
    const list = grainColourings(this.app).map(({ key }) => key);
    this.set('colour', list[(list.indexOf(this.app.settings.colour) + 1) % list.length]);
    byId('colour').value = this.app.settings.colour;
  }

  flip(name) {
    byId(name).checked = !byId(name).checked;
    this.set(name, byId(name).checked);
  }

  /* Lays a packing in the plane on its side. */
  turn() {
    const { stage } = this.app;
    if (this.app.packing.dimension !== 2) return;
    stage.turned = !stage.turned;
    stage.resetCamera();
  }

  /* ---- what the controls show ------------------------------------------------------------------------------------ */

  rebuild() {
    const { app } = this;
    const { packing, settings } = app;
    this.describe();
    for (const view of ['packing', 'mode', 'wave']) {
      const part = { packing: true, mode: packing.modes, wave: packing.wave }[view];
      byId(`view-${view}`).hidden = !part;
      byId(`view-${view}`).setAttribute('aria-pressed', view === app.view);
    }
    document.body.dataset.dimension = packing.dimension;
    fillSelect(byId('colour'), grainColourings(app), settings.colour);
    fillSelect(byId('contact'), contactColourings(packing), settings.contact);
    for (const name of ['chains', 'rattlers']) byId(name).checked = settings[name];
    for (const name of ranges) byId(name).value = settings[name];
    byId('si').checked = app.si;
    byId('si').parentElement.hidden = !packing.material;
    byId('rattlers').parentElement.hidden = packing.rattlers === 0;
    this.listModes();
    this.showReason();
    this.showMode();
    this.showGrain();
    this.showWords();
  }

  describe() {
    const { packing, units, packings, number } = this.app;
    byId('packings').replaceChildren(...packings.map(({ name }, k) => new Option(name, k, false, k === number)));
    byId('packings').hidden = packings.length < 2;
    byId('name').hidden = packings.length > 1;
    text('name', packing.name);
    const share = packing.rattlers / packing.grains;
    const words = [`${packing.grains} grains in ${packing.dimension}D`,
      `height ${units.text(packing.box[packing.dimension - 1], 'length')}`];
    const { box, cell, tilt = [0, 0, 0] } = packing;
    if (packing.dimension > 1 && cell !== 'ring') words.push(`width ${units.text(box[0], 'length')}`);
    if (cell === 'periodic') words.push('periodic along all axes');
    if (cell === 'box') words.push('walls on all sides');
    if (cell === 'ring') words.push(`between rings of ${[box[0] / 2 - box[1], box[0] / 2].map((r) => units.text(r, 'length')).join(' and ')}`);
    if (tilt.some((step) => step !== 0)) {
      const steps = packing.dimension === 2 ? tilt.slice(0, 1) : tilt;
      words.push(`tilted by ${steps.map((step) => units.text(step, 'length')).join(', ')}`);
    }
    words.push(`pressure ${units.text(packing.pressure, 'pressure')}`,
      packing.friction > 0 ? `friction ${plainNumber(packing.friction)}` : 'no friction',
      packing.rattlers > 0 ? `${packing.rattlers} rattlers (${plainNumber(100 * share, 2)}%)` : 'no rattlers');
    text('description', words.join(' · '));
    text('hash', packing.hash);
    text('scene', packing.scene || 'The packing carries no scene: it was imported.');
    text('precision', this.precision());
  }

  precision() {
    const { wave } = this.app.packing;
    const words = ['Positions, forces and modes are floats of 32 bits (relative error 6×10⁻⁸).'];
    if (wave && wave.u) {
      const step = this.app.units.text(wave.until / (wave.t.length - 1), 'time');
      words.push(`The wave has ${wave.t.length} frames, ${step} apart, rounded to 16 bits of the largest displacement ` +
        'of each. Between them the page interpolates: motion that is faster than two frames is not seen. The curve of ' +
        'the signal is not affected.');
    }
    return words.join(' ');
  }

  listModes() {
    const { packing, units, mode } = this.app;
    const rows = packing.modes && packing.modes.rows ? packing.modes.rows : [];
    byId('modes').replaceChildren(...rows.map((row, k) => {
      const label = `${packing.modes.first + k}: ω = ${units.text(row.omega, 'frequency', 4)}`;
      return new Option(label, k, false, k === mode);
    }));
  }

  /* Why there is no wave or no modes, or no signal beside the wave. */
  showReason() {
    const { packing, view } = this.app;
    const part = { packing: null, mode: packing.modes, wave: packing.wave }[view];
    const missing = part && part.reason;
    const silent = part && part.signal && part.signal.reason;
    byId('reason').hidden = !missing && !silent;
    if (missing) text('reason', `There ${view === 'mode' ? 'are no modes' : 'is no wave'}: ${missing}.`);
    else if (silent) text('reason', `There is no signal: ${silent}.`);
    document.body.dataset.missing = missing ? 'yes' : 'no';
  }

  showMode() {
    const { packing, mode, view, units } = this.app;
    if (view !== 'mode' || !this.app.has('mode')) return;
    const row = packing.modes.rows[mode];
    byId('modes').value = mode;
    const words = [`Mode ${row.number} of all (${packing.modes.zero_modes} of them are zero modes).`,
      `Period ${units.text(2 * Math.PI / row.omega, 'time')}.`,
      `Participation ${plainNumber(row.participation, 2)}: 1 if all grains take part alike.`];
    if (row.vector_error > 0.05)
      words.push('Other modes have nearly the same frequency: its shape is one of several that would be as good.');
    text('mode-words', words.join(' '));
  }

  showWords() {
    const { app } = this;
    if (app.view === 'mode' && app.has('mode'))
      text('amplitude-words', `largest displacement drawn: ${app.units.text(app.amplitude(), 'length', 2)}`);
    else if (app.view === 'wave' && app.has('wave'))
      text('amplitude-words', `displacements drawn ${plainNumber(app.factor(), 2)} times as large, ` +
        `for a pulse of unit strength (${app.packing.wave.source})`);
  }

  showTime() {
    const { app } = this;
    if (app.view === 'packing' || !app.has(app.view)) return;
    byId('time').value = app.time / app.longest();
    if (app.view === 'mode') text('time-words', `${plainNumber(app.time, 2)} of a period`);
    else {
      text('time-words', `t = ${app.units.text(app.time, 'time')}${this.force()}`);
    }
    if (app.chosen >= 0) this.showGrain();
  }

  /* The force of the signal, or what its error leaves of it. */
  force() {
    const { plot, time, units } = this.app;
    if (!plot.signal) return '';
    const [force, error] = [plot.at(time), plot.signal.error];
    return Math.abs(force) > error ? `, F = ${units.text(force, 'force')}` : `, |F| < ${units.text(2 * error, 'force')}`;
  }

  showPlaying(on) {
    text('play', on ? 'Pause' : 'Play');
  }

  showGrain() {
    const { packing, units, chosen, motion, view } = this.app;
    byId('grain').hidden = chosen < 0;
    if (chosen < 0) return;
    const dim = packing.dimension;
    const at = Array.from(packing.x.subarray(chosen * dim, (chosen + 1) * dim));
    const words = [`Grain ${chosen}${packing.rattler[chosen] ? ', a rattler' : ''}`,
      `at (${at.map((x) => units.text(x, 'length', 4)).join(', ')})`,
      `radius ${units.text(packing.r[chosen], 'length', 4)}`, `${packing.coordination[chosen]} contacts that carry force`,
      `pressure ${units.text(packing.grain_pressure[chosen], 'pressure')}`];
    if (view === 'wave') {
      const shift = Array.from(motion.shift.subarray(3 * chosen, 3 * chosen + dim));
      words.push(`displacement (${shift.map((x) => units.text(x, 'length')).join(', ')})`);
    }
    text('grain', words.join('; '));
  }
}
