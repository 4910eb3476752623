// Traces that people zoom and read off. Without this, and on paper, the drawn figures stand in their place.
(() => {
  "use strict";
  const COLOURS = ["#D55E00", "#0072B2", "#009E73", "#E69F00", "#56B4E9", "#CC79A7"];
  const GREY = "#8A8F98";
  const shown = (value) => (value == null ? "–" : Number(value.toPrecision(5)).toString());
  const button = (text, act) => {
    const made = document.createElement("button");
    made.type = "button";
    made.textContent = text;
    made.addEventListener("click", act);
    return made;
  };
  const lineOf = (line, colour) => ({
    label: line.name,
    stroke: line.is_reference ? GREY : colour,
    width: 1.5,
    dash: line.is_reference ? [5, 4] : line.is_sensed ? [2, 3] : undefined,
    points: { show: false },
  });
  // As wide as its longest tick, beside its label.
  const axisSize = (plot, values, index, cycle) => {
    const axis = plot.axes[index];
    if (cycle > 1) return axis._size;
    const longest = (values ?? []).reduce((one, other) => (other.length > one.length ? other : one), "");
    plot.ctx.font = axis.font[0];
    return Math.max(60, Math.ceil(plot.ctx.measureText(longest).width / devicePixelRatio) + 40);
  };
  const mark = (told, panel) => (plot) => {
    const { ctx, bbox } = plot;
    const at = (time) => plot.valToPos(time, "x", true);
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.fillStyle = "#F4E3C180";
    ctx.fillRect(at(told.start), bbox.top, Math.max(at(told.end) - at(told.start), 1), bbox.height);
    if (panel.lines.some((line) => line.column === told.column)) {
      ctx.strokeStyle = "#D55E00";
      ctx.setLineDash([8, 6]);
      for (const level of told.levels) {
        const y = plot.valToPos(level, "y", true);
        ctx.beginPath();
        ctx.moveTo(at(told.start), y);
        ctx.lineTo(at(told.end), y);
        ctx.stroke();
      }
    }
    ctx.restore();
  };
  const build = (box) => {
    if (box.childElementCount) return;
    const told = JSON.parse(box.dataset.trace);
    const time = told.columns.time_s;
    const plots = [];
    const zoom = (min, max) => {
      for (const plot of plots) if (plot.scales.x.min !== min || plot.scales.x.max !== max) plot.setScale("x", { min, max });
    };
    const whole = () => zoom(time[0], time[time.length - 1]);
    const moment = () => zoom(told.start - 0.1 * (told.end - told.start), told.end + 0.1 * (told.end - told.start));
    const closer = (factor) => {
      const { min, max } = plots[0].scales.x;
      zoom(0.5 * (min + max - factor * (max - min)), 0.5 * (min + max + factor * (max - min)));
    };
    const tools = document.createElement("p");
    tools.className = "small tools";
    tools.append(button("Whole run", whole), button("What decides", moment), button("Closer", () => closer(0.5)), button("Wider", () => closer(2)));
    tools.append(" Drag to zoom, double-click for the whole run.");
    box.append(tools);
    const key = `trace-${document.querySelectorAll("[data-built]").length}`;
    box.dataset.built = "yes";
    for (const panel of told.panels) {
      const readout = document.createElement("output");
      readout.className = "small readout";
      const place = document.createElement("div");
      box.append(readout, place);
      const read = (plot) => {
        const row = plot.cursor.idx;
        const values = panel.lines.map((line) => `${line.name} ${shown(row == null ? null : told.columns[line.column][row])}`);
        readout.textContent = `${row == null ? "" : `${Number(time[row].toPrecision(7))} s: `}${values.join(", ")}`;
      };
      const colours = panel.lines.filter((line) => !line.is_reference && !line.is_sensed).length === 1 ? [COLOURS[1], COLOURS[0]] : [...COLOURS];
      plots.push(
        new uPlot(
          {
            width: Math.max(box.clientWidth - 2, 200),
            height: 150,
            legend: { show: false },
            cursor: { sync: { key }, drag: { x: true, y: false } },
            scales: { x: { time: false } },
            axes: [{ size: 30, values: (_, ticks) => ticks.map((tick) => Number(tick.toPrecision(7))) }, { label: panel.label, size: axisSize, labelSize: 22 }],
            series: [{}, ...panel.lines.map((line) => lineOf(line, line.is_reference ? GREY : colours.shift() ?? COLOURS[5]))],
            hooks: {
              drawAxes: [mark(told, panel)],
              setCursor: [read],
              setScale: [(plot, scale) => scale === "x" && zoom(plot.scales.x.min, plot.scales.x.max)],
            },
          },
          [time, ...panel.lines.map((line) => told.columns[line.column])],
          place,
        ),
      );
      read(plots[plots.length - 1]);
    }
    box.parentElement.classList.add("traced");
    if (told.column) moment();
  };
  const look = (place) => {
    for (const box of place.querySelectorAll(".trace")) if (box.clientWidth) build(box);
  };
  look(document);
  for (const folded of document.querySelectorAll("details")) folded.addEventListener("toggle", () => folded.open && look(folded));
})();
