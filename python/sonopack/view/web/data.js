/* Decodes the data of the page: arrays in base64 become typed arrays. */

const kinds = { uint8: Uint8Array, int8: Int8Array, int16: Int16Array, uint16: Uint16Array, int32: Int32Array,
  float32: Float32Array };

/* {type, shape, data} to a typed array, with its shape as a property. */
export function decodeArray(packed) {
  const text = atob(packed.data);
  const bytes = new Uint8Array(text.length);
  for (let k = 0; k < text.length; k++) bytes[k] = text.charCodeAt(k);
  const array = new kinds[packed.type](bytes.buffer); // little-endian, as every browser's machine is
  array.shape = packed.shape;
  return array;
}

/* Replaces all packed arrays below an object. */
export function decodeAll(object) {
  for (const [key, value] of Object.entries(object)) {
    if (value === null || typeof value !== 'object') continue;
    if (typeof value.data === 'string' && value.type in kinds) object[key] = decodeArray(value);
    else decodeAll(value);
  }
  return object;
}

export function readData(element) {
  return decodeAll(JSON.parse(element.textContent));
}

/* The value below which the given fraction of the numbers lies. */
export function quantile(values, fraction) {
  if (values.length === 0) return 0;
  const sorted = Float64Array.from(values).sort();
  return sorted[Math.min(sorted.length - 1, Math.floor(fraction * sorted.length))];
}
