// Force and depth of each hand over time, and the latencies' histograms.
import uPlot from 'uplot';

import {colour, timeChart, toolColour, toolDash} from './chart.js';

const element = (tag, text = '', name = '') => {
  const made = document.createElement(tag);
  made.textContent = text;
  if (name) made.className = name;
  return made;
};

/// Two curves with times of their own over one axis: [times, a, b], null where one has no point.
function merged(a, b) {
  const table = uPlot.join([[a.times, a.values], [b.times, b.values]]);
  return table;
}

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

/// What lies under a hand's curves: its contacts, the pauses; and over them the limit and events.
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
    draw: (u) => {
      u.ctx.save();
      u.ctx.beginPath();
      u.ctx.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height);
      u.ctx.clip();
      const y = u.valToPos(data.limit, 'y', true);
      line(u, u.bbox.left, y, u.bbox.left + u.bbox.width, y, colour('bad'), [6, 4]);
      for (const event of data.events) {
        const x = u.valToPos(event.time, 'x', true);
        const style = colour(['muted', 'warn', 'bad'][event.severity] ?? 'muted');
        line(u, x, u.bbox.top, x, u.bbox.top + u.bbox.height, style, [2, 3]);
      }
      u.ctx.restore();
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
  key('force', 'height:0;border-top:2px solid var(--text)');
  key('depth', 'height:0;border-top:2px dotted var(--muted)');
  key(`limit ${data.limit} N`, 'height:0;border-top:2px dashed var(--bad)');
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
  const highest = Math.max(data.limit, ...data.hands.flatMap((hand) => hand.force.values));
  data.hands.forEach((hand, tool) => {
    const place = element('div');
    into.append(place);
    const hooks = backdrop(data, tool);
    const number = (digits) => (u, value) => value == null ? '\u2013' : value.toFixed(digits);
    charts.push(timeChart(
        place, {
          title: hand.name,
          unit: 'N',
          height: 210,
          series: [
            {label: 'force N', colour: () => toolColour(tool), dash: toolDash(tool)},
            {label: 'depth mm', colour: () => colour('muted'), dash: [2, 3], width: 1.2},
          ],
          options: {
            scales: {
              x: {time: false, range: (u, min, max) => [min ?? 0, max ?? data.duration]},
              y: {range: [0, highest * 1.08 || 1]},
              mm: {range: (u, min, max) => [0, (max || 1) * 1.08]},
            },
            axes: withDepthAxis(),
            series: [
              {label: 's', value: number(2)},
              {label: 'force N', stroke: () => toolColour(tool), dash: toolDash(tool), width: 1.5,
               spanGaps: true, points: {show: false}, value: number(2)},
              {label: 'depth mm', scale: 'mm', stroke: () => colour('muted'), dash: [2, 3], width: 1.2,
               spanGaps: true, points: {show: false}, value: number(1)},
            ],
            cursor: {sync: {key: 'report'}},
            hooks: {drawAxes: [hooks.drawAxes], draw: [hooks.draw],
                    setScale: [(u, scale) => scale === 'x' && follow(u)]},
          },
        },
        merged(hand.force, hand.depth_mm)));
  });
  into.append(element('p', 'Drag to look closer, double-click for all. Peaks are kept at every size.',
                      'note help'));
}

function withDepthAxis() {
  const font = '12px system-ui, sans-serif';
  const axis = {
    stroke: () => colour('text'),
    grid: {stroke: () => colour('line'), width: 1},
    ticks: {stroke: () => colour('line'), width: 1},
    font, labelFont: font, labelSize: 18,
  };
  return [
    {...axis, label: 's', size: 32, labelGap: -2},
    {...axis, label: 'force, N', size: 46},
    {...axis, label: 'depth, mm', size: 46, side: 1, scale: 'mm', stroke: () => colour('muted'),
     grid: {show: false}},
  ];
}

const readable = (us) => us < 1000 ? `${+us.toPrecision(2)} \u00b5s` :
    us < 1e6 ? `${+(us / 1e3).toPrecision(2)} ms` : `${+(us / 1e6).toPrecision(2)} s`;

const svgElement = (tag, attributes) => {
  const made = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
};

/// Counts over durations, both on logarithmic axes: the rare and long ones are what matters.
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
  const step = Math.max(1, Math.ceil((high - low) / 5));
  for (let power = Math.ceil(low); power <= high; power += step) {
    const at = x(10 ** power);
    svg.append(svgElement('line', {x1: at, x2: at, y1: height - foot, y2: height - foot + 4,
                                   stroke: 'var(--muted)'}));
    const label = svgElement('text', {x: Math.min(Math.max(at, 16), width - 16), y: height - 3,
                                      'text-anchor': 'middle', 'font-size': 11, fill: 'var(--muted)'});
    label.textContent = readable(10 ** power);
    svg.append(label);
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
    into.before(element('p', 'How often each duration came, both axes logarithmic.', 'note'));
  }
}
