/* Colour scales that are readable in grey and to colour-blind eyes. */

const stops = {
  sequence: ['#440154', '#46327e', '#365c8d', '#277f8e', '#1fa187', '#4ac16d', '#a0da39', '#fde725'], // viridis
  signedLight: ['#0b4f9e', '#3f8fc9', '#9dc6dd', '#d9dde0', '#f2b18d', '#d6574a', '#a00d28'], // quiet grains are grey
  signedDark: ['#9ed3ff', '#3f8fd6', '#2a557d', '#39424b', '#8a4436', '#de6a4c', '#ffc3a6'],
  forceLight: ['#efc9a4', '#e88b4d', '#cf4a27', '#8f1520', '#3a0510'], // darker is larger on a light ground
  forceDark: ['#57304f', '#9c3a4c', '#dc6236', '#f7a83f', '#fff0b0'], // brighter is larger on a dark one
};

export const palettes = {
  light: { ground: '#ffffff', grain: '#c6d0da', rattler: '#e9ecef', edge: '#5b6875', line: '#66727e', text: '#1d252d',
    chosen: '#e6007a', weak: '#9aa5b0' },
  dark: { ground: '#11161b', grain: '#46525f', rattler: '#232b33', edge: '#0b0f13', line: '#7d8995', text: '#e8edf2',
    chosen: '#ff5cb0', weak: '#5d6975' },
};

export function rgb(hex) {
  return [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16) / 255);
}

/* The colour of a scale at x in 0..1. */
export function colourAt(scale, x) {
  const list = stops[scale];
  const place = Math.min(1, Math.max(0, x)) * (list.length - 1);
  const below = Math.min(list.length - 2, Math.floor(place));
  const [a, b] = [rgb(list[below]), rgb(list[below + 1])];
  return a.map((value, k) => value + (b[k] - value) * (place - below));
}

/* 256 colours for a texture. */
export function colourTable(scale) {
  const table = new Float32Array(256 * 4);
  for (let k = 0; k < 256; k++) table.set([...colourAt(scale, k / 255), 1], 4 * k);
  return table;
}

export function cssGradient(scale) {
  return `linear-gradient(to right, ${stops[scale].join(', ')})`;
}

export function isDark() {
  return window.matchMedia('(prefers-color-scheme: dark)').matches;
}
