/* What the colours of grains and contacts stand for. */
import { quantile } from './data.js';
import { Motion } from './motion.js';
import { isDark } from './colours.js';

const signed = () => (isDark() ? 'signedDark' : 'signedLight');

/* A colouring: {key, title, kind (of the unit), scale, low, high, note, value(i)}; value gives NaN where there is none. */
function ofArray(key, title, kind, array, shown) {
  const high = quantile(Array.from(array).filter((value, i) => shown(i)), 0.99);
  return { key, title, kind, scale: 'sequence', low: 0, high: high || 1, clipped: array.some((x) => x > high * 1.0001),
    value: (i) => array[i] };
}

function radii(packing) {
  const { r } = packing;
  let [low, high] = [Infinity, 0];
  for (const x of r) [low, high] = [Math.min(low, x), Math.max(high, x)];
  if (high - low < 1e-6) low = 0;
  return { key: 'radius', title: 'Radius', kind: 'length', scale: 'sequence', low, high, value: (i) => r[i] };
}

/* The size that 98% of the grains stay below: of a mode its own, of a wave that of the middle one of some frames; early
 * frames, near the source, are far larger. Lengths, and turns times `lever'. */
function usualSizes(motion, count, set, lever) {
  const lengths = [];
  const turns = [];
  const size = (array, i) => Math.hypot(array[3 * i], array[3 * i + 1], array[3 * i + 2]);
  const grains = Array.from(motion.packing.grain);
  for (let k = 0; k < count; k++) {
    set(k);
    lengths.push(quantile(grains.map((i) => size(motion.shift, i)), 0.98));
    turns.push(quantile(grains.map((i) => size(motion.turn, i) * lever(i)), 0.98));
  }
  return { length: quantile(lengths, 0.5) || 1, turn: quantile(turns, 0.5) || 1 };
}

/* The same for what is shown now, found once: in a motion of its own, lest that on the screen jump. */
function sizesOf(app) {
  const { packing, mode } = app;
  const part = app.view === 'mode' ? packing.modes : packing.wave;
  const key = app.view === 'mode' ? mode : 0;
  part.sizes = part.sizes || [];
  if (part.sizes[key]) return part.sizes[key];
  const motion = new Motion(packing);
  const frames = 12;
  if (app.view === 'mode') part.sizes[key] = usualSizes(motion, 1, () => motion.setMode(mode, 0, 1), (i) => packing.r[i]);
  else
    part.sizes[key] = usualSizes(motion, frames, (k) => motion.setWave(part.until * (k + 1) / frames), () => 1);
  return part.sizes[key];
}

/* Modes have no amplitude of their own: their displacements are shown over the largest one. */
function moving(app) {
  const { motion, packing } = app;
  const up = packing.dimension - 1;
  const mode = app.view === 'mode';
  const inPlane = motion.turns === 1;
  const sizes = sizesOf(app);
  const over = mode ? app.amplitude() || 1 : 1;
  const relative = mode ? ', over the largest' : '';
  const length = (array, i) => Math.hypot(array[3 * i], array[3 * i + 1], array[3 * i + 2]);
  const range = (kind, high, isSigned) => ({ kind: mode ? 'number' : kind, scale: isSigned ? signed() : 'sequence',
    low: isSigned ? -high : 0, high, clipped: true });
  const upwards = packing.dimension > 1 ? 'Displacement upwards' : 'Displacement along the chain';
  const list = [{ key: 'vertical', name: upwards, title: upwards + relative, ...range('length', sizes.length, true),
    value: (i) => motion.shift[3 * i + up] / over },
  { key: 'displacement', name: 'Displacement', title: `Displacement${relative}`, ...range('length', sizes.length, false),
    value: (i) => length(motion.shift, i) / over }];
  if (motion.turns === 0) return list;
  const lever = (i) => (mode ? packing.r[i] / over : 1);
  list.push({ key: 'rotation', name: 'Rotation', title: mode ? 'Rotation × radius, over the largest displacement' : 'Rotation',
    ...range('angle', sizes.turn, inPlane),
    value: (i) => (inPlane ? motion.turn[3 * i + 2] : length(motion.turn, i)) * lever(i) });
  return list;
}

export function grainColourings(app) {
  const { packing } = app;
  const holds = (i) => !packing.rattler[i];
  const list = [{ key: 'none', title: 'One colour' },
    ofArray('pressure', 'Pressure on the grain', 'pressure', packing.grain_pressure, holds),
    ofArray('coordination', 'Contacts that carry force', 'number', packing.coordination, holds), radii(packing)];
  return app.view !== 'packing' && app.has(app.view) ? [...moving(app), ...list] : list;
}

/* Largest force with a colour of its own: few contacts are above it. */
function topForce(packing) {
  const carrying = Array.from(packing.fn).filter((f, c) => packing.carrying[c]);
  return { high: quantile(carrying, 0.99) || 1, largest: quantile(carrying, 1),
    mean: carrying.reduce((sum, f) => sum + f, 0) / (carrying.length || 1) };
}

export function contactColourings(packing) {
  const force = topForce(packing);
  const list = [{ key: 'force', title: 'Normal force', kind: 'force', scale: isDark() ? 'forceDark' : 'forceLight',
    low: 0, high: force.high, clipped: force.largest > force.high * 1.0001, mean: force.mean,
    value: (c) => packing.fn[c] }];
  if (packing.friction > 0)
    list.push({ key: 'mobilised', title: 'Friction used, |Fₜ|/(µ Fₙ)', kind: 'number', scale: 'sequence', low: 0,
      high: 1, mean: force.mean, value: (c) => packing.ft[c] / (packing.friction * packing.fn[c] || 1) });
  return list;
}
