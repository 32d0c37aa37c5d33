/* The part of the address behind #: what the page shows, so that a link or a test leads there. */

/* "mode=3&t=0.5&colour=rotation" as an object; a name without a value counts as "". */
export function readAddress(hash) {
  return Object.fromEntries(new URLSearchParams(hash.replace(/^#/, '')));
}

export function numberOf(address, name, usual) {
  const value = Number(address[name]);
  return address[name] !== undefined && address[name] !== '' && Number.isFinite(value) ? value : usual;
}

/* The state of the page as an address. */
export function writeAddress(app) {
  const { settings } = app;
  const parts = new URLSearchParams();
  if (app.packings.length > 1) parts.set('packing', app.number + 1);
  if (app.view === 'mode') parts.set('mode', app.packing.modes.first + app.mode);
  else if (app.view === 'wave') parts.set('wave', '');
  else parts.set('packing', app.number + 1);
  if (app.view !== 'packing') parts.set('t', Number(app.time.toPrecision(4)));
  if (app.si && app.packing.material) parts.set('units', 'si');
  parts.set('colour', settings.colour);
  parts.set('chains', settings.chains ? 1 : 0);
  parts.set('size', settings.size);
  return `#${parts}`;
}
