/* The force on the top wall against time, below the picture, with the time that is shown. */
import { plainNumber } from './units.js';
import { palettes, isDark } from './colours.js';

function niceStep(span, most) {
  const raw = span / most;
  const power = 10 ** Math.floor(Math.log10(raw));
  return [1, 2, 5, 10].map((x) => x * power).find((step) => step >= raw);
}

export class SignalPlot {
  constructor(canvas, onTime) {
    this.canvas = canvas;
    const move = (event) => {
      if (!this.signal || event.buttons === 0) return;
      const x = event.offsetX - this.left;
      onTime(Math.min(1, Math.max(0, x / this.width)) * this.signal.until);
    };
    canvas.addEventListener('pointerdown', (event) => { canvas.setPointerCapture(event.pointerId); move(event); });
    canvas.addEventListener('pointermove', move);
  }

  open(signal, units) {
    this.signal = signal && signal.F ? signal : null;
    this.units = units;
    if (!this.signal) return;
    this.largest = this.signal.F.reduce((most, f) => Math.max(most, Math.abs(f)), 0) || 1;
    this.force = units.scale('force', this.largest);
    this.time = units.scale('time', this.signal.until);
  }

  /* The force at a time [E* d^2]. */
  at(time) {
    const { F, until } = this.signal;
    const place = Math.min(1, Math.max(0, time / until)) * (F.length - 1);
    const below = Math.min(F.length - 2, Math.floor(place));
    return F[below] + (F[below + 1] - F[below]) * (place - below);
  }

  draw(now) {
    const { canvas } = this;
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    const [wide, high] = [canvas.clientWidth, canvas.clientHeight];
    if (!this.signal || wide === 0) return;
    canvas.width = wide * ratio;
    canvas.height = high * ratio;
    const context = canvas.getContext('2d');
    context.scale(ratio, ratio);
    context.font = '13px system-ui, sans-serif';
    this.palette = palettes[isDark() ? 'dark' : 'light'];
    Object.assign(this, { left: 90, top: 22, width: wide - 106, height: high - 62 });
    this.drawAxes(context);
    this.drawCurve(context);
    this.drawMarks(context);
    this.drawCursor(context, now);
  }

  x(time) { return this.left + time / this.signal.until * this.width; }

  y(force) { return this.top + (1 - force / this.largest) * this.height / 2; }

  drawAxes(context) {
    const { palette, signal, time, force } = this;
    context.fillStyle = palette.text;
    context.strokeStyle = palette.weak;
    context.lineWidth = 1;
    const step = niceStep(signal.until * time.factor, Math.max(2, this.width / 90)) / time.factor;
    context.textAlign = 'center';
    for (let t = 0; t <= signal.until * 1.0001; t += step) {
      context.fillText(plainNumber(t * time.factor), this.x(t), this.top + this.height + 17);
      context.strokeRect(this.x(t), this.top + this.height, 0, 4);
    }
    context.fillText(`time after the pulse [${time.unit}]`, this.left + this.width / 2, this.top + this.height + 34);
    context.textAlign = 'right';
    for (const f of [-this.largest, 0, this.largest])
      context.fillText(plainNumber(f * force.factor), this.left - 6, this.y(f) + 4);
    context.textAlign = 'left';
    context.fillText(`force on the top wall, F [${force.unit}]`, 8, 14);
    context.strokeRect(this.left, this.top, this.width, this.height);
    context.beginPath();
    context.moveTo(this.left, this.y(0));
    context.lineTo(this.left + this.width, this.y(0));
    context.stroke();
  }

  drawCurve(context) {
    const { F, until } = this.signal;
    context.strokeStyle = isDark() ? '#6cb6ff' : '#0b61a4';
    context.lineWidth = 1.5;
    context.beginPath();
    F.forEach((f, k) => context.lineTo(this.x(until * k / (F.length - 1)), this.y(f)));
    context.stroke();
  }

  /* The first front: arrival at a tenth of the peak, and the peak. */
  drawMarks(context) {
    const { front } = this.signal;
    if (!front) return;
    const label = (text, time, side) => {
      context.textAlign = side;
      context.fillText(text, this.x(time) + (side === 'right' ? -8 : 8), this.y(this.at(time)) - 8);
    };
    context.fillStyle = isDark() ? '#ffb454' : '#b3541e';
    context.beginPath();
    const [x, y] = [this.x(front.t10), this.y(this.at(front.t10))];
    context.moveTo(x, y - 6);
    context.lineTo(x - 5, y + 4);
    context.lineTo(x + 5, y + 4);
    context.fill();
    label('arrival', front.t10, 'right');
    context.beginPath();
    context.arc(this.x(front.t_peak), this.y(front.amplitude), 4, 0, 7);
    context.fill();
    label('peak', front.t_peak, 'left');
  }

  drawCursor(context, now) {
    context.strokeStyle = this.palette.chosen;
    context.lineWidth = 1.5;
    context.beginPath();
    context.moveTo(this.x(now), this.top - 4);
    context.lineTo(this.x(now), this.top + this.height);
    context.stroke();
    context.fillStyle = this.palette.chosen;
    context.beginPath();
    context.arc(this.x(now), this.y(this.at(now)), 4, 0, 7);
    context.fill();
  }
}
