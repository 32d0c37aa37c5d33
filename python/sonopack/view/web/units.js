/* Numbers with their units: those of the packing (d, E*, rho), or SI units if it carries a material. */

const names = { length: 'd', time: 'd/√(E*/ρ)', frequency: '√(E*/ρ)/d', force: 'E* d²', pressure: 'E*', angle: 'rad',
  number: '' };
const siNames = { length: 'm', time: 's', frequency: 'rad/s', force: 'N', pressure: 'Pa', angle: 'rad', number: '' };
const prefixes = [[1e9, 'G'], [1e6, 'M'], [1e3, 'k'], [1, ''], [1e-3, 'm'], [1e-6, 'µ'], [1e-9, 'n']];
const raised = { '-': '⁻', 0: '⁰', 1: '¹', 2: '²', 3: '³', 4: '⁴', 5: '⁵', 6: '⁶', 7: '⁷', 8: '⁸', 9: '⁹' };

/* Three digits, as a decimal number or with a power of ten. */
export function plainNumber(value, digits = 3) {
  if (!Number.isFinite(value)) return '–';
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1e-3 && size < 1e5) return String(Number(value.toPrecision(digits))).replace('-', '−');
  const [mantissa, power] = value.toExponential(digits - 1).split('e');
  const base = String(Number(mantissa)).replace('-', '−');
  const exponent = [...String(Number(power))].map((letter) => raised[letter]).join('');
  return base === '1' ? `10${exponent}` : `${base}×10${exponent}`;
}

/* Converts and names quantities of one packing. material: {E, nu, rho, d} in SI units, or null. */
export class Units {
  constructor(material) {
    this.si = material !== null && material !== undefined;
    if (!this.si) return;
    const modulus = material.E / (1 - material.nu ** 2);
    const time = material.d / Math.sqrt(modulus / material.rho);
    this.factor = { length: material.d, time, frequency: 1 / time, force: modulus * material.d ** 2,
      pressure: modulus, angle: 1, number: 1 };
  }

  /* Factor and unit name for values as large as `largest`. */
  scale(kind, largest) {
    if (!this.si) return { factor: 1, unit: names[kind] };
    const value = Math.abs(largest) * this.factor[kind];
    const prefixed = kind !== 'angle' && kind !== 'number' && kind !== 'frequency' && value > 0;
    const [size, prefix] = (prefixed && prefixes.find(([least]) => value >= least)) || prefixes[prefixed ? 6 : 3];
    return { factor: this.factor[kind] / size, unit: prefix + siNames[kind] };
  }

  /* "12.3 d" */
  text(value, kind, digits = 3) {
    const { factor, unit } = this.scale(kind, value);
    return `${plainNumber(value * factor, digits)}${unit ? ` ${unit}` : ''}`;
  }
}
