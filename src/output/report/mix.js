// The sum of all shares at other lamp levels and another contrast: the formula of `eyebox mix` (docs/mix.md).
const mixture = { gains: {}, contrast: null };

function asRendered() {
  mixture.gains = Object.fromEntries(frame.groups.map((group) => [group, 1]));
  mixture.contrast = null;
}

/** "inf" and numbers of 1 or more; null for anything else. */
function contrastOf(text) {
  const value = /^\s*(inf|infinity|∞)\s*$/i.test(text) ? Infinity : Number(text);
  return String(text).trim() !== "" && value >= 1 ? value : null;
}

const renderedContrast = frame.contrast === null ? null : contrastOf(String(frame.contrast));

/** content·u + open·v + cross·uv + cross2·u²v + cross3·u³v, times the gain, added to `sum`. */
function addSplit(sum, split, channel, gain, contrast) {
  const [u, v] = [1 - 1 / contrast, 1 / contrast];
  const [open, content] = [channels(split.open)[channel], channels(split.content)[channel]];
  const cross = split.cross.map((planes) => (planes ? channels(planes)[channel] : null));
  for (let at = 0; at < pixels; at++) {
    let crossings = 0;
    for (let order = 2; order >= 0; order--) crossings = crossings * u + (cross[order] ? cross[order][at] : 0);
    sum[at] += gain * (content[at] * u + open[at] * v + crossings * u * v);
  }
}

/** The three channels of the mixed picture, in the frame's colour space. */
function recombine() {
  const contrast = mixture.contrast === renderedContrast ? null : mixture.contrast;
  const sums = [];
  for (let channel = 0; channel < 3; channel++) {
    // Grey frames hold each channel once.
    const same = channel > 0 && frame.shares.every((share) => isGrey(share));
    if (same) {
      sums.push(sums[0]);
      continue;
    }
    const sum = new Float64Array(pixels);
    for (const share of frame.shares) {
      const gain = mixture.gains[share.group];
      if (gain === 0) continue;
      if (share.split && contrast !== null) {
        addSplit(sum, share.split, channel, gain, contrast);
      } else {
        const picture = channels(share.picture)[channel];
        for (let at = 0; at < pixels; at++) sum[at] += gain * picture[at];
      }
    }
    sums.push(sum);
  }
  return sums;
}

function isGrey(share) {
  const all = [share.picture];
  if (share.split) all.push(share.split.open, share.split.content, ...share.split.cross.filter(Boolean));
  return all.every(([r, g, b]) => r === g && g === b);
}

/** The command that writes this mixture. */
function command() {
  const quoted = (text) => (/^[\w./=:@%+-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`);
  const words = ["eyebox", "mix", quoted(frame.file)];
  for (const group of frame.groups) {
    if (mixture.gains[group] !== 1) words.push("--gain", quoted(`${group}=${mixture.gains[group]}`));
  }
  if (mixture.contrast !== null && mixture.contrast !== renderedContrast) {
    words.push("--contrast", mixture.contrast === Infinity ? "inf" : String(mixture.contrast));
  }
  return [...words, "-o", "mixed.exr"].join(" ");
}
