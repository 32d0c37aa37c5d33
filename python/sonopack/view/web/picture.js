/* The picture as it is saved: with its legend, and with the signal if this is shown. */

function paintDisc(context, style, box) {
  context.strokeStyle = style.borderTopColor;
  context.beginPath();
  context.arc(box.x + box.width / 2, box.y + box.height / 2, box.width / 2 - 0.5, 0, 7);
  context.fill();
  context.stroke();
}

function paintBox(context, node, box) {
  const style = getComputedStyle(node);
  context.fillStyle = style.backgroundColor;
  if (style.borderTopLeftRadius === '50%') {
    paintDisc(context, style, box);
    return;
  }
  context.fillRect(box.x, box.y, box.width, box.height);
  for (const side of ['Top', 'Right', 'Bottom', 'Left']) {
    const width = parseFloat(style[`border${side}Width`]);
    if (!width) continue;
    const [right, low] = [box.x + box.width - width, box.y + box.height - width];
    context.fillStyle = style[`border${side}Color`];
    if (side === 'Top' || side === 'Bottom') context.fillRect(box.x, side === 'Top' ? box.y : low, box.width, width);
    else context.fillRect(side === 'Left' ? box.x : right, box.y, width, box.height);
  }
}

/* The colours of a strip are evenly spaced (cssGradient). */
function paintStrip(context, node, box) {
  const colours = node.style.background.match(/rgba?\([^)]*\)|#[0-9a-f]{6}/g) || [];
  const gradient = context.createLinearGradient(box.x, 0, box.x + box.width, 0);
  colours.forEach((colour, k) => gradient.addColorStop(k / (colours.length - 1), colour));
  context.fillStyle = gradient;
  context.fillRect(box.x, box.y, box.width, box.height);
}

function paintWords(context, node, origin) {
  const range = document.createRange();
  range.selectNodeContents(node);
  const style = getComputedStyle(node.parentElement);
  const box = range.getBoundingClientRect();
  context.font = `${style.fontSize} ${style.fontFamily}`;
  context.fillStyle = style.color;
  context.textBaseline = 'middle';
  context.fillText(node.data, box.x - origin.x, box.y - origin.y + box.height / 2);
}

/* Draws an element and all in it: boxes, colour strips and words are all that a legend has. */
function paintTree(context, node, origin) {
  if (node.nodeType === Node.TEXT_NODE) {
    if (node.data.trim()) paintWords(context, node, origin);
    return;
  }
  const box = node.getBoundingClientRect();
  const at = { x: box.x - origin.x, y: box.y - origin.y, width: box.width, height: box.height };
  if (node.className === 'strip') paintStrip(context, node, at);
  else paintBox(context, node, at);
  for (const child of node.childNodes) paintTree(context, child, origin);
}

/* frame: the element that holds picture and legend. Returns a canvas. */
export function composePicture(frame, picture, signal) {
  const ratio = picture.width / picture.clientWidth;
  const origin = frame.getBoundingClientRect();
  const below = signal.clientHeight;
  const canvas = document.createElement('canvas');
  canvas.width = origin.width * ratio;
  canvas.height = (origin.height + below) * ratio;
  const context = canvas.getContext('2d');
  context.scale(ratio, ratio);
  context.fillStyle = getComputedStyle(document.body).backgroundColor;
  context.fillRect(0, 0, origin.width, origin.height + below);
  context.drawImage(picture, 0, 0, picture.clientWidth, picture.clientHeight);
  paintTree(context, frame.querySelector('#legend'), origin);
  if (below > 0) context.drawImage(signal, 0, origin.height, origin.width, below);
  return canvas;
}
