  // ------------------------------------------------------------ charts
  const drawn = new Set();
  let library = null;
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const loadPlotly = () => {
    library ??= (async () => {
      const packed = new Blob([bytes($("plotly").textContent)]).stream();
      const source = await new Response(packed.pipeThrough(new DecompressionStream("gzip"))).text();
      const script = document.createElement("script");
      script.textContent = source;
      document.head.append(script);
      return window.Plotly;
    })();
    return library;
  };
  const colour = (name) => getComputedStyle(root).getPropertyValue(name).trim();
  const SERIES = 8;   // as many colours as the theme has
  const kept = (values, positions) => (Array.isArray(values) ? positions.map((i) => values[i]) : values);
  const cut = (trace, positions) => {
    const made = { ...trace };
    for (const key of ["x", "y", "customdata"]) made[key] = kept(trace[key], positions);
    if (trace.error_y) {
      made.error_y = { ...trace.error_y, array: kept(trace.error_y.array, positions),
        arrayminus: kept(trace.error_y.arrayminus, positions) };
    }
    return made;
  };
  // A figure holds all runs; what is drawn of it are the first few that were chosen.
  const chosenOf = (figure) => {
    const told = new Set(figure.data.map((t) => t.meta.run).filter((r) => r !== undefined));
    const able = told.size ? picked.filter((r) => told.has(r)) : picked;   // of some runs a figure says nothing
    const drawn = able.slice(0, SERIES);
    const whole = figure.data.filter((t) => t.meta.run === undefined || drawn.includes(t.meta.run));
    const layout = { ...figure.layout };
    let data = whole.map((t) => (t.meta.outcome === undefined && t.meta.phase === undefined ? t : cut(t, drawn)));
    if (data.some((t, i) => t !== whole[i])) {
      data = data.filter((t) => t.x.some(Boolean));
      const legend = innerWidth < 640 ? 20 * data.length : 0;   // its names stand one below the other there
      layout.height = 130 + 34 * drawn.length + legend;
    }
    const names = layout.xaxis?.categoryarray;
    if (names) {   // without places that none of them has
      const used = names.map((_, i) => i).filter((i) => data.some((t) => t.y[i] !== null));
      data = data.map((t) => cut(t, used));
      layout.xaxis = { ...layout.xaxis, categoryarray: kept(names, used) };
    }
    const few = picked.length <= SERIES;   // the same colours in all charts
    const colours = new Map(drawn.map((r, i) => [r, few ? picked.indexOf(r) : i]));
    return { data, layout, left: able.length - drawn.length, colours };
  };
  const coloured = ({ data: traces, layout: placed, colours }) => {
    const soft = colour("--soft"), grid = colour("--grid");
    const axis = { gridcolor: grid, zerolinecolor: grid, linecolor: soft };
    const data = traces.map((trace) => {
      const { run, outcome, phase } = trace.meta;
      const own = outcome !== undefined ? colour(`--${outcomes.includes(outcome) ? outcome : "error"}`)
        : run !== undefined ? colour(`--run-${colours.get(run)}`)
          : phase !== undefined ? colour(`--run-${phase % SERIES}`) : soft;
      const made = { ...trace, marker: { ...trace.marker, color: own } };
      if (trace.mode?.includes("lines")) made.line = { ...trace.line, color: own };
      if (trace.meta.band) made.fillcolor = `${own}30`;
      if (trace.error_y) made.error_y = { ...trace.error_y, color: own };
      return made;
    });
    const layout = { ...placed, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      font: { color: colour("--text"), family: "system-ui, sans-serif", size: 13 },
      hoverlabel: { bgcolor: colour("--card"), font: { color: colour("--text") } } };
    for (const name of ["xaxis", "yaxis"]) layout[name] = { automargin: true, ...layout[name], ...axis, fixedrange: true };
    return { data, layout };
  };
  const draw = async (box) => {
    let Plotly;
    try { Plotly = await loadPlotly(); } catch { Plotly = null; }
    if (!Plotly) { box.textContent = "This browser cannot draw the chart; its numbers are below."; return; }
    const chosen = chosenOf(charts[box.dataset.chart]);
    const note = document.querySelector(`[data-note="${box.dataset.chart}"]`);
    note.hidden = !chosen.left;
    note.textContent = `The first ${SERIES} of the chosen runs are drawn, ${chosen.left} more are in the numbers.`;
    const { data, layout } = coloured(chosen);
    await Plotly.react(box, data, layout, { displayModeBar: false, responsive: true });
    drawn.add(box);
    box.dataset.drawn = root.dataset.theme;
  };
  const redraw = () => drawn.forEach(draw);
  const watcher = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (entry.isIntersecting) { watcher.unobserve(entry.target); draw(entry.target); }
    }
  }, { rootMargin: "300px" });

