/* The displacement of every grain in a mode or a wave, at any time. */

/* Displacements of all grains; rattlers stay where they are. shift: [n][3], turn: [n][3] (2D: only the last). */
export class Motion {
  constructor(packing) {
    this.packing = packing;
    this.dim = packing.dimension;
    this.dof = packing.dof || 0;
    this.turns = Math.max(0, this.dof - this.dim); // 1 in 2D with friction, 3 in 3D
    this.shift = new Float32Array(3 * packing.grains);
    this.turn = new Float32Array(3 * packing.grains);
  }

  clear() {
    this.shift.fill(0);
    this.turn.fill(0);
  }

  /* Adds factor times a field of the network that begins at u[begin]; lengths and turns have factors of their own. */
  add(u, begin, length, turn) {
    const { dim, dof, turns } = this;
    this.packing.grain.forEach((grain, k) => {
      const from = begin + k * dof;
      for (let a = 0; a < dim; a++) this.shift[3 * grain + a] += length * u[from + a];
      for (let a = 0; a < turns; a++) this.turn[3 * grain + (turns === 1 ? 2 : a)] += turn * u[from + dim + a];
    });
  }

  /* Mode k, at a phase in periods; the largest displacement has the given amplitude. */
  setMode(k, phase, amplitude) {
    const u = this.packing.modes.u;
    const size = u.shape[1] * u.shape[2];
    const factor = amplitude / this.largestOfMode(k) * Math.cos(2 * Math.PI * phase);
    this.clear();
    this.add(u, k * size, factor, factor);
  }

  /* The largest displacement of a mode: of a centre, or of a surface by rotation. */
  largestOfMode(k) {
    const { modes, grain, r } = this.packing;
    if (!modes.largest) modes.largest = [];
    if (modes.largest[k]) return modes.largest[k];
    const { dim, dof } = this;
    const begin = k * grain.length * dof;
    let largest = 0;
    for (let i = 0; i < grain.length; i++) {
      let moved = 0;
      let turned = 0;
      for (let a = 0; a < dof; a++) {
        const square = modes.u[begin + i * dof + a] ** 2;
        if (a < dim) moved += square;
        else turned += square;
      }
      largest = Math.max(largest, Math.sqrt(moved), Math.sqrt(turned) * r[grain[i]]);
    }
    modes.largest[k] = largest || 1;
    return modes.largest[k];
  }

  /* The wave at a time, between two frames linearly. */
  setWave(time) {
    const { t, u, length, turn, levels } = this.packing.wave;
    const last = t.length - 1;
    const place = Math.min(last, Math.max(0, time / t[last] * last)); // frames are equally spaced
    const below = Math.min(last - 1, Math.floor(place));
    const size = u.shape[1] * u.shape[2];
    this.clear();
    for (const [frame, weight] of [[below, 1 - (place - below)], [below + 1, place - below]])
      if (weight > 0)
        this.add(u, frame * size, weight * length[frame] / levels, weight * turn[frame] / levels);
  }
}
