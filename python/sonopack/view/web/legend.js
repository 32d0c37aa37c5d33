/* The legend in the corner of the picture: colour bars with numbers and units, widths of lines, and a scale bar. */
import { cssGradient } from './colours.js';
import { plainNumber } from './units.js';

function element(name, properties = {}, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}

function bar(colouring, units) {
  const { factor, unit } = units.scale(colouring.kind, colouring.high);
  const number = (x) => plainNumber(x * factor);
  const top = `${colouring.clipped ? '≥ ' : ''}${number(colouring.high)}`;
  const bottom = `${colouring.clipped && colouring.low < 0 ? '≤ ' : ''}${number(colouring.low)}`;
  const middle = number((colouring.low + colouring.high) / 2);
  const strip = element('div', { className: 'strip' });
  strip.style.background = cssGradient(colouring.scale);
  return element('div', { className: 'bar' }, element('div', {}, colouring.title + (unit ? ` [${unit}]` : '')), strip,
    element('div', { className: 'numbers' }, element('span', {}, bottom), element('span', {}, middle),
      element('span', {}, top)));
}

/* A line as wide as that of a contact with the force. */
function line(pixels, text) {
  const sample = element('span', { className: 'line' });
  sample.style.height = `${Math.max(1, pixels)}px`;
  return element('span', { className: 'sample' }, sample, text);
}

function widths(app, units) {
  const { mean } = app.contactColouring();
  const pixels = (force) => app.lineWidth(force) / app.stage.pixel();
  return element('div', { className: 'widths' }, line(pixels(mean), `Fₙ = ${units.text(mean, 'force')} (mean)`),
    line(pixels(3 * mean), '3 × mean'));
}

/* Between 60 and 150 pixels long; a picture in perspective of a turned box has none. */
function scaleBar(app, units) {
  const most = 150 * app.stage.pixel();
  const { factor, unit } = units.scale('length', most);
  const power = 10 ** Math.floor(Math.log10(most * factor));
  const length = [5, 2, 1].map((x) => x * power).find((x) => x <= most * factor);
  const ruler = element('div', { className: 'ruler' });
  ruler.style.width = `${length / factor / app.stage.pixel()}px`;
  return element('div', {}, ruler, `${plainNumber(length)} ${unit}`);
}

export function drawLegend(place, app) {
  const { units } = app;
  const parts = [];
  const grains = app.grainColouring();
  if (grains.value) parts.push(bar(grains, units));
  if (app.settings.chains) parts.push(bar(app.contactColouring(), units), widths(app, units));
  if (app.packing.rattlers > 0 && app.settings.rattlers) {
    const dot = element('span', { className: 'dot' });
    parts.push(element('div', {}, dot, `rattlers: ${app.packing.rattlers}, which carry no force`));
  }
  if (app.stage.turned || app.packing.dimension === 1) {
    const words = app.packing.cell === 'periodic' ? 'up is to the right' : 'the bottom wall is at the left';
    parts.push(element('div', {}, words));
  }
  parts.push(scaleBar(app, units));
  place.replaceChildren(...parts);
}
