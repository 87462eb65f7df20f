/* Puts a plot that can be zoomed in place of a still one, or beneath it: drag to zoom, double click to see all, or keys.
   All readings are in it, up to a limit that it tells; where several fall on one column of pixels, their smallest and
   largest are drawn. Beside a value stands its standard uncertainty where it is known; where a plot has two models, buttons choose.
   The still one stays for paper and for readers without script. Numbers are formatted here, not by the browser. */
"use strict";
(() => {
  /* In the language of the page, where that is not English; `.` is its decimal sign. */
  const words = JSON.parse(document.getElementById("words")?.textContent ?? "{}");
  const said = (message, values = {}) => Object.entries(values).reduce((all, [name, value]) => all.replace(`{${name}}`, value), words[message] ?? message);
  const minus = (text) => text.replace("-", "\u2212").replace(".", words["."] ?? ".");
  const missing = (value) => value === null || value === undefined;
  const text = (value) => minus(String(Number(value.toPrecision(6))));
  const tick = (_plot, splits, _axis, _space, step) => {
    /* As many as the step has: one of 0.0025 must not be written as 0.003. */
    let digits = 0;
    while (digits < 12 && Math.abs(step * 10 ** digits - Math.round(step * 10 ** digits)) > 1e-6 * step * 10 ** digits) digits += 1;
    return splits.map((value) => (missing(value) ? "" : minus(value.toFixed(digits))));
  };
  const looks = { measured: ["#8b939c", 2], before: ["#d9822b", 1.2], after: ["#0b4f8a", 1.2, [4, 2]], mode: ["#0b4f8a", 1.2], residual: ["#0b4f8a", 1], limit: ["#1b1f24", 1, [2, 3]] };

  const STATED = said("model as stated"), EXTENDED = said("extended model");

  /* Numbers come as base64 of 32-bit floats; NaN is a gap. */
  function numbers(value) {
    if (typeof value !== "string") return value;
    const bytes = Uint8Array.from(atob(value), (letter) => letter.charCodeAt(0));
    return Array.from(new Float32Array(bytes.buffer), (number) => (Number.isNaN(number) ? null : number));
  }

  /* A panel without times of its own stands on those of the one above it. */
  function unpack(panels) {
    let above;
    return panels.map((panel) => {
      const whole = Object.fromEntries(Object.entries(panel).map(([key, value]) => [key, typeof value === "string" && key !== "title" && key !== "name" ? numbers(value) : value]));
      if ("curves" in panel) whole.curves = panel.curves.map((curve) => ({ ...curve, y: numbers(curve.y) }));
      above = whole.time ??= above;
      return whole;
    });
  }

  function held(panels) {
    const short = panels.filter((panel) => !panel.count || panel.time.length < panel.count);
    if (!short.length) return said("All readings are here.");
    if (!short[0].count) return said("A record that is longer than that was thinned for the report, smallest and largest kept; the readings files have all.");
    const counts = [...new Set(short.map((panel) => said("{part} of {whole}", { part: panel.time.length, whole: panel.count })))].join(", ");
    return said("{counts} readings are here, smallest and largest kept; the readings files have all.", { counts });
  }

  /* +2 u_val, its index set. */
  const limit = (sign) => element("span", {}, `${sign}2\u00a0`, element("i", { textContent: "u" }), element("sub", { textContent: "val" }));

  /* A value with its standard uncertainty, two digits of it. */
  function estimate(value, u) {
    if (missing(u) || !(u > 0)) return text(value);
    const digits = Math.min(Math.max(1 - Math.floor(Math.log10(u)), 0), 12);
    return `${minus(value.toFixed(digits))} \u00b1 ${minus(u.toFixed(digits))}`;
  }

  function columns(panel) {
    const unit = panel.title.split(" / ")[1] ?? "";
    /* `u`: of all values, or of each. A series of one of two models has its name as `model`. */
    const line = (label, stroke, width, dash, { u, model } = {}) => ({
      label, stroke, width, dash, model, points: { show: false },
      value: (_plot, value, _series, at) => (missing(value) ? "\u2013" : `${estimate(value, Array.isArray(u) ? u[at] : u)} ${unit}`.trim()),
    });
    const time = { label: said("time"), value: (_plot, value) => (missing(value) ? "\u2013" : `${text(value)} s`) };
    if ("curves" in panel) {
      return {
        data: uPlot.join(panel.curves.map((curve) => [curve.x ?? panel.time, curve.y])),
        series: [time, ...panel.curves.map((curve) => {
          const [stroke, width, dash] = looks[curve.role];
          return { ...line(curve.name, stroke, width, dash, curve), spanGaps: curve.role !== "residual" };
        })],
        bands: [],
      };
    }
    if ("error" in panel) {
      const two = "other" in panel;
      const u = two ? undefined : panel.twice_u_val.map((limit) => (missing(limit) ? null : limit / 2));
      return {
        data: [panel.time, ...(two ? [panel.other] : []), panel.error, panel.twice_u_val, panel.twice_u_val.map((limit) => (missing(limit) ? null : -limit))],
        series: [time, ...(two ? [line(STATED, "#d9822b", 1, undefined, { model: STATED })] : []), two ? line(EXTENDED, "#0b4f8a", 1, undefined, { model: EXTENDED }) : line("E", "#0b4f8a", 1, undefined, { u }), line(two ? "+2" : limit("+"), "#1b1f24", 1, [5, 3]), line(two ? "\u22122" : limit("\u2212"), "#1b1f24", 1, [5, 3])],
        bands: [],
      };
    }
    const model = panel.models ? { model: EXTENDED } : {};
    /* Of a reading that the model predicts, as its 95 % band has it. */
    const u = panel.high.map((high, at) => (missing(high) || missing(panel.low[at]) ? null : (high - panel.low[at]) / 3.92));
    const data = [panel.time, panel.high, panel.low, panel.measured, panel.simulated];
    const series = [
      time, line(said("band, high"), "#c6d9ec", 1, undefined, model), line(said("band, low"), "#c6d9ec", 1, undefined, model),
      line(said("measured"), "#8b939c", 2, undefined, { u: panel.u }),
      line(panel.models ? EXTENDED : said("simulated"), "#0b4f8a", 1.2, undefined, { ...model, u }),
    ];
    if (panel.closed.length === panel.time.length) {
      data.push(panel.closed);
      series.push(line(panel.models ? STATED : said("own inputs re-estimated"), "#d9822b", 1.2, [4, 3], panel.models ? { model: STATED } : {}));
    }
    return { data, series, bands: [{ series: [1, 2], fill: "#c6d9ec" }] };
  }

  function phases(list) {
    const shade = (plot) => list.forEach(([, start, stop], index) => {
      if (index % 2 === 0) return;
      const from = Math.max(plot.valToPos(start, "x", true), plot.bbox.left);
      const to = Math.min(plot.valToPos(stop, "x", true), plot.bbox.left + plot.bbox.width);
      plot.ctx.fillStyle = "#f0f1f3";
      if (to > from) plot.ctx.fillRect(from, plot.bbox.top, to - from, plot.bbox.height);
    });
    return { hooks: { drawClear: shade } };
  }

  function element(name, properties, ...children) {
    const made = Object.assign(document.createElement(name), properties);
    made.append(...children);
    return made;
  }

  function draw(figure, spec, name) {
    const seen = element("span", { className: "seen" });
    const spoken = element("p", { className: "spoken" });
    spoken.setAttribute("aria-live", "polite");
    const bar = element("p", { className: "bar" });
    const area = element("div", { className: "area", tabIndex: 0 });
    area.setAttribute("role", "group");
    area.setAttribute("aria-label", said("Plot to zoom: the arrow keys move the cursor, plus and minus zoom, 0 shows all"));
    const holder = element("div", { className: "zoom" }, bar, area, spoken);
    const still = figure.querySelector("svg");
    if (spec.beneath) still.after(holder);
    else figure.prepend(holder);
    const plots = [];
    const panels = unpack(spec.panels);
    const ends = () => plots.map((plot) => [plot.data[0][0], plot.data[0].at(-1)]);
    const all = () => [Math.min(...ends().map((end) => end[0])), Math.max(...ends().map((end) => end[1]))];
    let window = [0, 1];
    let cursor = null;

    function show(from, to) {
      const [first, last] = all();
      const span = Math.min(to - from, last - first);
      const start = Math.min(Math.max(from, first), last - span);
      plots.forEach((plot) => plot.setScale("x", { min: start, max: start + span }));
    }
    const around = (share) => {
      const middle = cursor !== null && cursor >= window[0] && cursor <= window[1] ? cursor : (window[0] + window[1]) / 2;
      show(middle - (middle - window[0]) * share, middle + (window[1] - middle) * share);
    };
    const along = (share) => {
      const step = share * (window[1] - window[0]);
      show(window[0] + step, window[1] + step);
    };
    const closer = () => around(0.5), wider = () => around(2), whole = () => show(...all());
    const acts = [
      [said("Zoom in"), closer], [said("Zoom out"), wider], [said("Earlier"), () => along(-0.5)], [said("Later"), () => along(0.5)], [said("Show all"), whole],
    ];
    acts.forEach(([label, act]) => {
      const button = element("button", { type: "button", textContent: label });
      button.addEventListener("click", act);
      bar.append(button);
    });
    if (panels.some((panel) => panel.models)) bar.append(choice());
    bar.append(seen, element("span", { className: "held", textContent: held(panels) }));

    /* Which of the two models the plots show. */
    function choice() {
      const group = element("span", { className: "choice" });
      group.setAttribute("role", "group");
      group.setAttribute("aria-label", said("Models shown"));
      for (const [label, models] of [[said("Both models"), [STATED, EXTENDED]], [said("As stated"), [STATED]], [said("Extended"), [EXTENDED]]]) {
        const button = element("button", { type: "button", textContent: label });
        button.setAttribute("aria-pressed", String(models.length === 2));
        button.addEventListener("click", () => {
          for (const other of group.children) other.setAttribute("aria-pressed", String(other === button));
          for (const plot of plots) plot.series.forEach((one, at) => { if (one.model) plot.setSeries(at, { show: models.includes(one.model) }); });
        });
        group.append(button);
      }
      return group;
    }

    function follow(plot, key) {
      if (key !== "x") return;
      const { min, max } = plot.scales.x;
      window = [min, max];
      plots.forEach((other) => (other.scales.x.min !== min || other.scales.x.max !== max) && other.setScale("x", { min, max }));
      const inside = plots.map((one) => one.data[0].filter((time) => time >= min && time <= max).length);
      const counts = [...new Set([Math.min(...inside), Math.max(...inside)])];
      const samples = counts.length > 1 ? said("{low} to {high}", { low: counts[0], high: counts[1] }) : counts[0];
      seen.textContent = said("{start} s to {end} s, {samples} samples a line", { start: text(min), end: text(max), samples });
    }

    function move(step) {
      const times = plots[0].data[0].filter((time) => time >= window[0] && time <= window[1]);
      if (!times.length) return;
      const at = cursor === null ? -1 : times.findIndex((time) => time >= cursor);
      cursor = times[Math.min(Math.max(at + step, 0), times.length - 1)];
      plots.forEach((plot) => plot.setCursor({ left: plot.valToPos(cursor, "x"), top: plot.height / 3 }));
      const read = (row) => `${row.querySelector(".u-label").textContent} ${row.querySelector(".u-value").textContent}`;
      spoken.textContent = plots.map((plot) => [...plot.root.querySelectorAll(".u-series")].map(read).join(", ")).join("; ");
    }
    const keys = { "+": closer, "=": closer, "-": wider, 0: whole, ArrowLeft: () => move(-1), ArrowRight: () => move(1) };
    area.addEventListener("keydown", (event) => {
      const act = event.ctrlKey || event.altKey || event.metaKey ? undefined : keys[event.key];
      if (!act) return;
      act();
      event.preventDefault();
    });

    panels.forEach((panel, index) => {
      const { data, series, bands } = columns(panel);
      const last = index === panels.length - 1;
      const axis = { values: tick, font: "12px Report, sans-serif", grid: { stroke: "#e4e8ec", width: 1 }, stroke: "#1b1f24" };
      const plot = new uPlot({
        title: panel.name, width: figure.clientWidth, height: ("error" in panel || "curves" in panel ? 170 : 220) + (last ? 20 : 0), series, bands,
        cursor: { sync: { key: name }, drag: { x: true, y: false } },
        scales: { x: { time: false } },
        axes: [last ? { ...axis, label: said("time / s"), labelFont: axis.font, labelSize: 20 } : axis, { ...axis, label: panel.title, labelFont: "12px Report, sans-serif", size: 64, space: 24 }],
        hooks: { setScale: [follow], setCursor: [(one) => (cursor = missing(one.cursor.idx) ? cursor : one.data[0][one.cursor.idx])] },
        plugins: [phases(spec.phases)],
      }, data, area);
      plots.push(plot);
    });
    /* Records of one test begin at times of their own: from the start all of each is seen. */
    show(...all());
    plots.forEach((plot) => plot.root.querySelector(".u-wrap").setAttribute("aria-hidden", "true"));
    if (!spec.beneath) figure.classList.add("live");
    new ResizeObserver(() => plots.forEach((plot) => plot.setSize({ width: figure.clientWidth, height: plot.height }))).observe(figure);
  }

  document.querySelectorAll("script[data-series]").forEach((source, index) => {
    draw(source.closest("figure"), JSON.parse(source.textContent), `run-${index}`);
  });
})();
