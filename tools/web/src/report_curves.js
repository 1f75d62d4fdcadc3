// Force and depth of each hand over time, and the latencies' histograms.
import uPlot from 'uplot';

import {colour, timeChart, toolColour, toolDash} from './chart.js';

const element = (tag, text = '', name = '') => {
  const made = document.createElement(tag);
  made.textContent = text;
  if (name) made.className = name;
  return made;
};

function fill(u, from, to, style, top = 0, height = 1) {
  const {left, width} = u.bbox;
  const x0 = Math.max(u.valToPos(from, 'x', true), left);
  const x1 = Math.min(u.valToPos(to, 'x', true), left + width);
  if (x1 <= x0) return;
  u.ctx.fillStyle = style;
  u.ctx.fillRect(x0, u.bbox.top + top * u.bbox.height, Math.max(x1 - x0, 1), height * u.bbox.height);
}

function line(u, x0, y0, x1, y1, style, dash) {
  u.ctx.beginPath();
  u.ctx.strokeStyle = style;
  u.ctx.lineWidth = devicePixelRatio;
  u.ctx.setLineDash(dash.map((d) => d * devicePixelRatio));
  u.ctx.moveTo(x0, y0);
  u.ctx.lineTo(x1, y1);
  u.ctx.stroke();
  u.ctx.setLineDash([]);
}

/// Draws contacts and pauses under a hand's curves, and the limit and events over them.
function backdrop(data, tool) {
  return {
    drawAxes: (u) => {
      u.ctx.save();
      for (const [from, to] of data.pauses) {
        u.ctx.globalAlpha = 0.25;
        fill(u, from, to, colour('muted'));
      }
      u.ctx.globalAlpha = 0.16;
      for (const [from, to] of data.hands[tool].contacts) fill(u, from, to, toolColour(tool));
      u.ctx.restore();
    },
    drawLimit: (u, limit) => {
      const y = u.valToPos(limit, 'y', true);
      line(u, u.bbox.left, y, u.bbox.left + u.bbox.width, y, colour('bad'), [6, 4]);
    },
    drawEvents: (u) => {
      for (const event of data.events) {
        const x = u.valToPos(event.time, 'x', true);
        if (x < u.bbox.left || x > u.bbox.left + u.bbox.width) continue;
        const style = colour(['muted', 'warn', 'bad'][event.severity] ?? 'muted');
        line(u, x, u.bbox.top, x, u.bbox.top + u.bbox.height, style, [2, 3]);
      }
    },
  };
}

export function drawCurves(into, data) {
  const legend = element('div', '', 'legend');
  const key = (text, css) => {
    const entry = element('span');
    const sample = element('i');
    sample.style.cssText = css;
    entry.append(sample, text);
    legend.append(entry);
  };
  key(`limit ${data.limit} N, ${data.depth_limit_mm} mm`, 'height:0;border-top:2px dashed var(--bad)');
  key('contact', 'background:color-mix(in srgb, var(--hand-0) 22%, transparent)');
  if (data.pauses.length > 0) key('pause', 'background:var(--muted);opacity:0.4');
  key('event', 'width:0;height:1rem;border-left:2px dotted var(--muted)');
  into.append(legend);

  const charts = [];
  let busy = false;
  const follow = (from) => {  // all hands show the same time
    if (busy) return;
    busy = true;
    const {min, max} = from.scales.x;
    for (const chart of charts) if (chart !== from) chart.setScale('x', {min, max});
    busy = false;
  };
  // Math.max(...values) would fail: a session may have more values than a call takes arguments.
  const largest = (values) => values.reduce((a, b) => Math.max(a, b), 0);
  const highest = largest(data.hands.map((hand) => largest(hand.force.values)));
  const deepest = largest(data.hands.map((hand) => largest(hand.depth_mm.values)));
  const number = (u, value) => value == null ? '\u2013' : value.toFixed(2);
  data.hands.forEach((hand, tool) => {
    const hooks = backdrop(data, tool);
    const add = (title, unit, height, most, limit, curve) => {
      const place = element('div');
      into.append(place);
      const shown = {stroke: () => toolColour(tool), dash: toolDash(tool), width: 1.5,
                     points: {show: false}};
      charts.push(timeChart(
          place, {
            title, unit, height, series: [],
            options: {
              scales: {
                x: {time: false, range: (u, min, max) => [min ?? data.start, max ?? data.start + data.duration]},
                y: {range: [0, Math.max(most, limit) * 1.08]},
              },
              series: [{label: 's', value: number}, {...shown, label: `${hand.name}, ${unit}`,
                                                     value: number}],
              cursor: {sync: {key: 'report'}},
              hooks: {drawAxes: [hooks.drawAxes],
                      draw: [(u) => { hooks.drawEvents(u); hooks.drawLimit(u, limit); }],
                      setScale: [(u, scale) => scale === 'x' && follow(u)]},
            },
          },
          [curve.times, curve.values]));
    };
    add(`${hand.name}: force`, 'N', 190, highest, data.limit, hand.force);
    add(`${hand.name}: depth`, 'mm', 130, deepest, data.depth_limit_mm, hand.depth_mm);
  });
  into.append(element('p', 'Drag to zoom in, double-click to show all. Peaks are kept at every zoom.',
                      'note help'));
}

const readable = (us) => us < 1000 ? `${+us.toPrecision(2)} \u00b5s` :
    us < 1e6 ? `${+(us / 1e3).toPrecision(2)} ms` : `${+(us / 1e6).toPrecision(2)} s`;

const svgElement = (tag, attributes) => {
  const made = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
};

/// Draws counts over durations, both on logarithmic axes, so that rare long durations are visible.
function histogram(bins) {
  const width = 300, height = 110, foot = 18;
  const svg = svgElement('svg', {viewBox: `0 0 ${width} ${height}`, role: 'img', width: '100%'});
  const low = Math.log10(Math.max(bins[0][0], 0.1)) - 0.05;
  const high = Math.log10(Math.max(bins.at(-1)[0], 0.2)) + 0.05;
  const x = (us) => width * (Math.log10(Math.max(us, 0.1)) - low) / Math.max(high - low, 0.1);
  const tallest = Math.log10(Math.max(...bins.map(([, count]) => count)) + 1);
  for (const [us, count] of bins) {
    const tall = (height - foot) * Math.log10(count + 1) / tallest;
    svg.append(svgElement('rect', {
      x: (x(us * 0.97)).toFixed(1), width: Math.max(x(us) - x(us * 0.97), 1.2).toFixed(1),
      y: (height - foot - tall).toFixed(1), height: tall.toFixed(1), fill: 'var(--accent)',
    }));
  }
  const mark = (us, anchor) => {
    const at = Math.min(Math.max(x(us), 0), width);
    svg.append(svgElement('line', {x1: at, x2: at, y1: height - foot, y2: height - foot + 4,
                                   stroke: 'var(--muted)'}));
    const label = svgElement('text', {x: at, y: height - 3, 'text-anchor': anchor, 'font-size': 11,
                                      fill: 'var(--muted)'});
    label.textContent = readable(us);
    svg.append(label);
  };
  // Labels the ends and, where there is room, the powers of ten between them.
  const room = 60, from = x(bins[0][0]), to = x(bins.at(-1)[0]);
  mark(bins[0][0], from > width - room ? 'end' : 'start');
  if (to - from > 1.6 * room) mark(bins.at(-1)[0], 'end');
  let last = from + 0.6 * room;
  for (let power = Math.ceil(low); power <= high; ++power) {
    const at = x(10 ** power);
    if (at < last + room / 2 || at > to - 1.1 * room) continue;
    mark(10 ** power, 'middle');
    last = at + room / 2;
  }
  return svg;
}

export function drawHistograms(into, data) {
  for (const {name, bins} of data.latencies) {
    if (bins.length === 0) continue;
    const box = element('figure');
    box.append(element('figcaption', name.replace('.', ': ').replaceAll('_', ' ')), histogram(bins));
    into.append(box);
  }
  if (into.children.length > 0) {
    into.before(element('p', 'Counts over duration; both axes are logarithmic.', 'note'));
  }
}
