// Force and depth of each hand over the last seconds.
import {timeChart, toolColour, toolDash} from './chart.js';

const rowsPerSecond = 30, window_s = 20;

/// Converts rows of an update to uPlot's columns: s, then the `pick`ed values of each hand. A gap of
/// over half a second becomes a hole.
export function columns(rows, tools, pick) {
  const data = [[], ...Array.from({length: tools}, () => [])];
  let before = null;
  for (const row of rows) {
    if (before !== null && row[0] - before > rowsPerSecond / 2) {
      data[0].push((before + 1) / rowsPerSecond);
      for (let i = 0; i < tools; ++i) data[i + 1].push(null);
    }
    before = row[0];
    data[0].push(row[0] / rowsPerSecond);
    for (let i = 0; i < tools; ++i) data[i + 1].push(pick(row, i) ?? null);
  }
  return data;
}

export class Charts {
  constructor(force, depth) {
    this.elements = {force, depth};
    this.tools = 0;
    this.shown = null;
  }

  make(tools) {
    this.tools = tools;
    const series = Array.from({length: tools}, (_, i) => (
        {label: `hand ${i + 1}`, colour: () => toolColour(i), dash: toolDash(i), width: 2}));
    // The axis covers at least a light touch, so that noise does not fill the chart.
    const make = (element, least) => {
      element.replaceChildren();
      return timeChart(element, {
        series, height: 150,
        options: {
          cursor: {show: false},
          scales: {
            x: {time: false, range: (_, low, high) => [low ?? 0, Math.max(high ?? 0, (low ?? 0) + 5)]},
            y: {range: (_, low, high) => [0, Math.max(least, 1.1 * (high ?? 0))]},
          },
        },
      }, columns([], tools, () => null));
    };
    this.force = make(this.elements.force, 1);
    this.depth = make(this.elements.depth, 5);
  }

  show({rows}) {
    const last = rows.at(-1);
    if (last === this.shown) return;
    this.shown = last;
    const tools = last ? (last.length - 1) / 3 : 0;
    if (tools > 0 && tools !== this.tools) this.make(tools);
    if (this.tools === 0) return;
    const seen = last ? rows.filter((row) => row[0] > last[0] - window_s * rowsPerSecond) : [];
    this.force.setData(columns(seen, this.tools, (row, i) => row[1 + 3 * i]));
    this.depth.setData(columns(seen, this.tools, (row, i) => 1000 * row[2 + 3 * i]));
  }
}
