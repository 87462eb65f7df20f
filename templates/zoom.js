/* Puts a plot that can be zoomed in place of a still one: drag to zoom, double click or the button to see all.
   The still one stays for paper and for readers without script. Numbers are formatted here, not by the browser's locale. */
"use strict";
(() => {
  const minus = (text) => text.replace("-", "\u2212");
  const tick = (_plot, splits, _axis, _space, step) => {
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    return splits.map((value) => (value === null ? "" : minus(value.toFixed(Math.min(digits, 12)))));
  };
  const shown = (_plot, value) => (value === null || value === undefined ? "\u2013" : minus(String(Number(value.toPrecision(6)))));
  const line = (label, stroke, width, dash) => ({ label, stroke, width, dash, value: shown, points: { show: false } });

  const looks = { measured: ["#8b939c", 2], before: ["#d9822b", 1.2], after: ["#0b4f8a", 1.2, [4, 2]], limit: ["#1b1f24", 1, [2, 3]] };

  function columns(panel) {
    if ("curves" in panel) {
      return {
        data: uPlot.join(panel.curves.map((curve) => [curve.x, curve.y])),
        series: [{}, ...panel.curves.map((curve) => ({ ...line(curve.name, ...looks[curve.role]), spanGaps: true }))],
        bands: [],
      };
    }
    if ("error" in panel) {
      return {
        data: [panel.time, panel.error, panel.twice_u_val, panel.twice_u_val.map((u) => (u === null ? null : -u))],
        series: [{}, line("E", "#0b4f8a", 1), line("+2 u_val", "#1b1f24", 1, [5, 3]), line("\u22122 u_val", "#1b1f24", 1, [5, 3])],
        bands: [],
      };
    }
    const closed = panel.closed.length === panel.time.length;
    const data = [panel.time, panel.high, panel.low, panel.measured, panel.simulated];
    const series = [{}, line("band, high", "#c6d9ec", 1), line("band, low", "#c6d9ec", 1), line("measured", "#8b939c", 2), line("simulated", "#0b4f8a", 1.2)];
    if (closed) {
      data.push(panel.closed);
      series.push(line("own inputs re-estimated", "#d9822b", 1.2, [4, 3]));
    }
    return { data, series, bands: [{ series: [1, 2], fill: "#c6d9ec" }] };
  }

  function phases(list) {
    return {
      hooks: {
        drawClear: (plot) => {
          list.forEach(([, start, stop], index) => {
            if (index % 2 === 0) return;
            const from = Math.max(plot.valToPos(start, "x", true), plot.bbox.left);
            const to = Math.min(plot.valToPos(stop, "x", true), plot.bbox.left + plot.bbox.width);
            plot.ctx.fillStyle = "#f0f1f3";
            if (to > from) plot.ctx.fillRect(from, plot.bbox.top, to - from, plot.bbox.height);
          });
        },
      },
    };
  }

  function draw(figure, spec, name) {
    const holder = document.createElement("div");
    holder.className = "zoom";
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = "Show all";
    holder.append(button);
    figure.prepend(holder);
    const plots = [];
    let busy = false;
    const follow = (plot, key) => {
      if (key !== "x" || busy) return;
      busy = true;
      const { min, max } = plot.scales.x;
      plots.forEach((other) => other !== plot && other.setScale("x", { min, max }));
      busy = false;
    };
    spec.panels.forEach((panel) => {
      const { data, series, bands } = columns(panel);
      series[0] = { label: "time / s", value: shown };
      const axis = { values: tick, font: "12px Report, sans-serif", grid: { stroke: "#e4e8ec", width: 1 }, stroke: "#1b1f24" };
      plots.push(new uPlot({
        width: figure.clientWidth, height: "error" in panel || "curves" in panel ? 150 : 220, series, bands,
        cursor: { sync: { key: name }, drag: { x: true, y: false } },
        scales: { x: { time: false } },
        axes: [{ ...axis, label: undefined }, { ...axis, label: panel.title, labelFont: "12px Report, sans-serif", size: 64 }],
        hooks: { setScale: [follow] },
        plugins: [phases(spec.phases)],
      }, data, holder));
    });
    const all = () => plots.forEach((plot) => plot.setScale("x", { min: plot.data[0][0], max: plot.data[0].at(-1) }));
    button.addEventListener("click", all);
    figure.classList.add("live");
    const size = () => plots.forEach((plot) => plot.setSize({ width: figure.clientWidth, height: plot.height }));
    new ResizeObserver(size).observe(figure);
  }

  document.querySelectorAll("script[data-series]").forEach((source, index) => {
    draw(source.closest("figure"), JSON.parse(source.textContent), `run-${index}`);
  });
})();
