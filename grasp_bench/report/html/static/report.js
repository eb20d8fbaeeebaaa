"use strict";
(() => {
  const $ = (id) => document.getElementById(id);
  const read = (id) => JSON.parse($(id).textContent);
  const { runs, outcomes, trials } = read("data");
  const charts = read("charts");
  const PAGE = 60;
  const root = document.documentElement;
  const byKey = new Map(trials.map((t) => [`${t.run}/${t.trial}`, t]));

  const element = (tag, attributes = {}, ...children) => {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    made.append(...children);
    return made;
  };
  const link = (trial) => `#${encodeURIComponent(runs[trial.run].name)}/${trial.trial}`;
  const badge = (outcome) => {
    const made = element("span", { class: "outcome" }, outcome);
    made.style.setProperty("--dot", `var(--${outcomes.includes(outcome) ? outcome : "error"})`);
    return made;
  };

  // ------------------------------------------------------------ theme
  const stored = (() => { try { return localStorage.getItem("grasp-bench-theme"); } catch { return null; } })();
  const system = matchMedia("(prefers-color-scheme: dark)");
  let chosen = stored;
  const applyTheme = () => {
    const theme = chosen ?? (system.matches ? "dark" : "light");
    root.dataset.theme = theme;
    $("theme").textContent = theme === "dark" ? "Light" : "Dark";
    $("theme").setAttribute("aria-label", `Switch to the ${theme === "dark" ? "light" : "dark"} theme`);
    redraw();
  };
  $("theme").addEventListener("click", () => {
    chosen = root.dataset.theme === "dark" ? "light" : "dark";
    try { localStorage.setItem("grasp-bench-theme", chosen); } catch { /* files may not store */ }
    applyTheme();
  });
  system.addEventListener("change", applyTheme);

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
  const coloured = (figure) => {
    const soft = colour("--soft"), grid = colour("--grid");
    const axis = { gridcolor: grid, zerolinecolor: grid, linecolor: soft };
    const data = figure.data.map((trace) => {
      const { run, outcome } = trace.meta ?? {};
      const own = outcome !== undefined ? colour(`--${outcomes.includes(outcome) ? outcome : "error"}`)
        : run !== undefined ? colour(`--run-${run % 8}`) : soft;
      const made = { ...trace, marker: { ...trace.marker, color: own } };
      if (trace.mode?.includes("lines")) made.line = { ...trace.line, color: own };
      if (trace.error_y) made.error_y = { ...trace.error_y, color: own };
      return made;
    });
    const layout = { ...figure.layout, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      font: { color: colour("--text"), family: "system-ui, sans-serif", size: 13 },
      hoverlabel: { bgcolor: colour("--card"), font: { color: colour("--text") } } };
    for (const name of ["xaxis", "yaxis"]) layout[name] = { ...layout[name], ...axis, fixedrange: true };
    return { data, layout };
  };
  const draw = async (box) => {
    let Plotly;
    try { Plotly = await loadPlotly(); } catch { Plotly = null; }
    if (!Plotly) { box.textContent = "This browser cannot draw the chart; its numbers are below."; return; }
    const { data, layout } = coloured(charts[box.dataset.chart]);
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

  // ------------------------------------------------------------ pictures
  const urls = new Map();
  const picture = (key, kind) => {
    const name = `${key}-${kind}`;
    if (!urls.has(name)) {
      const store = $(`media-${key}`);
      const media = store ? JSON.parse(store.textContent) : {};
      urls.set(name, media[kind] ? URL.createObjectURL(new Blob([bytes(media[kind])], { type: "image/webp" })) : null);
    }
    return urls.get(name);
  };
  // A trial is one try; an episode of clutter has several.
  const triesOf = (t) => t.attempts?.map((a, i) => [`${t.run}-${t.trial}-${i}`, a]) ?? [[`${t.run}-${t.trial}`, t]];
  const sheetOf = (t) => {
    const keys = triesOf(t).map(([key]) => key);
    if (!t.success) keys.reverse();   // what a table was given up for is its last attempt
    return keys.map((key) => picture(key, "sheet")).find(Boolean) ?? null;
  };
  const lazy = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      if (!isIntersecting) continue;
      lazy.unobserve(target);
      const trial = byKey.get(target.dataset.key);
      const url = sheetOf(trial);
      if (!url) { target.textContent = "no picture"; continue; }
      const alt = `${trial.object}: what was seen, its depth, the proposed grasps, and the end`;
      target.replaceChildren(element("img", { src: url, alt, decoding: "async" }));
    }
  }, { rootMargin: "400px" });

  // ------------------------------------------------------------ grid
  const SORTS = {
    failures: ["Failures first", (t) => [t.success ? 1 : 0, t.run, t.trial]],
    trial: ["Trial", (t) => [t.trial, t.run]],
    object: ["Object", (t) => [t.object, t.run, t.trial]],
    quality: ["Predicted quality", (t) => [t.quality]],
    lift: ["Lift height", (t) => [t.lift]],
    force: ["Contact force", (t) => [t.force]],
    mass: ["Mass", (t) => [t.mass]],
    size: ["Size", (t) => [t.size]],
    seconds: ["Time", (t) => [t.seconds]],
  };
  const option = (value, text) => element("option", { value }, text);
  const present = (key) => [...new Set(trials.map((t) => t[key]).filter((v) => v !== undefined))];
  $("run").append(option("", "all"), ...runs.map((r, i) => option(i, r.name)));
  const used = present("outcome");
  $("outcome").append(option("", "all"), option("*", "all failures"),
    ...used.sort((a, b) => outcomes.indexOf(a) - outcomes.indexOf(b)).map((o) => option(`=${o}`, o)));
  $("family").append(option("", "all"), ...present("family").sort().map((f) => option(`=${f}`, f)));
  $("sort").append(...Object.entries(SORTS).map(([key, [name]]) => option(key, name)));

  let shown = [];
  let page = 0;
  const compare = (a, b) => {
    for (let i = 0; i < a.length; i++) {
      if (a[i] === b[i]) continue;
      if (a[i] === undefined) return 1;   // what is not known comes last, either way
      if (b[i] === undefined) return -1;
      const less = typeof a[i] === "string" ? a[i].localeCompare(b[i]) : a[i] - b[i];
      return $("direction").getAttribute("aria-pressed") === "true" ? -less : less;
    }
    return 0;
  };
  const select = () => {
    const words = $("search").value.toLowerCase().split(/\s+/).filter(Boolean);
    const [run, outcome, family] = ["run", "outcome", "family"].map((id) => $(id).value);
    const key = SORTS[$("sort").value][1];
    shown = trials.filter((t) => (run === "" || t.run === Number(run))
      && (outcome === "" || (outcome === "*" ? !t.success : `=${t.outcome}` === outcome))
      && (family === "" || `=${t.family}` === family)
      && words.every((w) => `${t.object} ${(t.objects ?? []).join(" ")} ${t.category} ${t.detail ?? ""} ${t.outcome} ${runs[t.run].name}`
        .toLowerCase().includes(w)))
      .map((t) => [key(t), t]).sort((a, b) => compare(a[0], b[0])).map(([, t]) => t);
  };
  const card = (t) => {
    const image = element("div", { class: "picture", "data-key": `${t.run}/${t.trial}` });
    lazy.observe(image);
    const text = element("div", { class: "text" }, element("span", { class: "name" }, t.object), badge(t.outcome),
      element("span", { class: "detail" }, t.detail ?? ""),
      element("span", { class: "detail" }, `trial ${t.trial}, ${runs[t.run].name}`
        + (t.quality === undefined ? "" : `, quality ${t.quality.toFixed(2)}`)));
    return element("li", {}, element("a", { href: link(t) }, image, text));
  };
  const show = () => {
    const pages = Math.max(1, Math.ceil(shown.length / PAGE));
    page = Math.min(Math.max(page, 0), pages - 1);
    lazy.disconnect();
    $("grid").replaceChildren(...shown.slice(page * PAGE, (page + 1) * PAGE).map(card));
    const won = shown.filter((t) => t.success).length;
    $("count").textContent = `${shown.length} of ${trials.length} trials, ${won} of them succeeded`;
    $("page").textContent = `Page ${page + 1} of ${pages}`;
    $("before").disabled = page === 0;
    $("after").disabled = page === pages - 1;
  };
  const update = () => { page = 0; select(); show(); };
  $("filters").addEventListener("input", update);
  $("filters").addEventListener("submit", (event) => event.preventDefault());
  $("filters").addEventListener("reset", () => {
    $("direction").setAttribute("aria-pressed", "false");
    setTimeout(update);
  });
  $("direction").addEventListener("click", () => {
    const pressed = $("direction").getAttribute("aria-pressed") === "true";
    $("direction").setAttribute("aria-pressed", String(!pressed));
    update();
  });
  const turn = (by) => { page += by; show(); $("trials-title").focus(); $("trials").scrollIntoView(); };
  $("before").addEventListener("click", () => turn(-1));
  $("after").addEventListener("click", () => turn(1));

  // ------------------------------------------------------------ one trial
  const NUMBERS = [
    ["category", "Category"], ["family", "Kind"], ["mass", "Mass", " g"], ["size", "Longest edge", " mm"],
    ["quality", "Predicted quality"], ["rank", "Rank of the grasp tried"], ["x", "Grasp x", " px"],
    ["y", "Grasp y", " px"], ["angle", "Grasp angle", "°"], ["width", "Grasp width", " px"],
    ["position", "TCP x, y, z", " mm"], ["opening", "Jaws opened", " mm"], ["tcp_mm", "TCP error", " mm"],
    ["tcp_deg", "TCP error, angle", "°"], ["lift", "Rise at the end of the lift", " mm"],
    ["force", "Contact force while held", " N"], ["steps", "Physics steps"], ["seconds", "Wall time", " s"],
  ];
  let open = null;
  const still = matchMedia("(prefers-reduced-motion: reduce)");
  const tryOn = (key, t, title, what) => {
    const made = $("try").content.cloneNode(true).firstElementChild;
    const part = (name) => made.querySelector(name);
    part(".try-title").textContent = title;
    part(".try-title").hidden = part(".try-outcome").hidden = !title;
    part(".try-outcome").replaceChildren(badge(t.outcome), t.detail ? `: ${t.detail}` : "",
      t.removed ? `; taken away: ${t.removed.join(", ")}` : "");
    part(".numbers-title").hidden = Boolean(title);
    const sheet = picture(key, "sheet"), clip = picture(key, "clip");
    part(".sheet-figure").hidden = !sheet;
    part(".clip-figure").hidden = !clip;
    part(".no-media").hidden = Boolean(sheet || clip);
    part(".no-media").textContent = `No picture of this ${what} is in this file.`;
    if (sheet) {
      part(".sheet img").src = sheet;
      part(".sheet img").alt = `Four pictures of the ${what} on ${t.object}`;
    }
    const shown = part(".clip"), button = part(".play");
    const setClip = (playing) => {
      if (playing && clip) shown.src = clip; else shown.removeAttribute("src");
      shown.alt = playing ? `Clip of the ${what} on ${t.object}` : "The clip is stopped";
      button.textContent = playing ? "Stop" : "Play";
      if (title) button.setAttribute("aria-label", `${button.textContent} the clip of ${title}`);
    };
    button.addEventListener("click", () => setClip(button.textContent === "Play"));
    part(".clip-figure figcaption span").textContent = `The ${what}, two and a half times as fast.`;
    setClip(!still.matches);
    part(".numbers").replaceChildren(...NUMBERS.filter(([name]) => t[name] !== undefined).map(
      ([name, label, unit = ""]) => element("div", {}, element("dt", {}, label),
        element("dd", {}, `${Array.isArray(t[name]) ? t[name].join(", ") : t[name]}${unit}`))));
    return made;
  };
  const steer = (id, trial) => {
    $(id).hidden = !trial;
    if (trial) $(id).href = link(trial);
  };
  const neighbour = (by) => {
    const at = shown.indexOf(open);
    return at < 0 ? null : shown[at + by] ?? null;
  };
  const sameElsewhere = (t) => runs.map((_, i) => byKey.get(`${i}/${t.trial}`))
    .filter((o) => o && o !== t && o.object === t.object
      && runs[o.run].scenario === runs[t.run].scenario);
  const item = (t, text) => element("li", {}, element("a", { href: link(t) }, text), " ", badge(t.outcome));
  const quoted = (name) => (/^[\w./-]+$/.test(name) ? name : `'${name.replaceAll("'", "'\\''")}'`);
  const showTrial = (t) => {
    open = t;
    const name = runs[t.run].name;
    $("trial-title").textContent = `${t.object}: trial ${t.trial} of ${name}`;
    $("trial-outcome").replaceChildren(badge(t.outcome), t.detail ? `: ${t.detail}` : "");
    $("on-table").hidden = $("replay-attempt").hidden = !t.attempts;
    $("on-table").textContent = t.attempts
      ? `On the table: ${t.objects.join(", ")}. Taken away: ${t.cleared} of ${t.objects.length}`
        + `${t.seconds === undefined ? "" : `, in ${t.seconds} s of wall time`}.` : "";
    $("tries").replaceChildren(...triesOf(t).map(([key, one], i) =>
      tryOn(key, one, t.attempts ? `Attempt ${i}: ${one.object}` : "", t.attempts ? "attempt" : "trial")));
    const others = sameElsewhere(t);
    $("others").replaceChildren(...(others.length ? others.map((o) => item(o, runs[o.run].name))
      : [element("li", {}, "none in this report")]));
    $("replay").textContent = `grasp-bench replay ${quoted(runs[t.run].path)} --trial ${t.trial} --video trial.mp4`;
    steer("previous", neighbour(-1));
    steer("next", neighbour(1));
    $("overview").hidden = true;
    $("trial").hidden = false;
    document.title = `${t.object}, trial ${t.trial} of ${name}`;
    scrollTo(0, 0);
    $("trial-title").focus({ preventScroll: true });
  };
  const title = document.title;
  const route = () => {
    const at = location.hash.lastIndexOf("/");
    let found = null;
    if (at > 0) {
      let name = null;
      try { name = decodeURIComponent(location.hash.slice(1, at)); } catch { /* not one of ours */ }
      found = byKey.get(`${runs.findIndex((r) => r.name === name)}/${location.hash.slice(at + 1)}`) ?? null;
    }
    if (found) { showTrial(found); return; }
    const left = open;
    open = null;
    $("overview").hidden = false;
    $("trial").hidden = true;
    document.title = title;
    if (left) {
      $("tries").replaceChildren();
      const target = $(location.hash.slice(1)) ?? $("top");
      target.scrollIntoView();
      const card = [...$("grid").querySelectorAll("a")].find((a) => a.getAttribute("href") === link(left));
      card?.focus();
    }
  };
  addEventListener("hashchange", route);
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("input, select")) return;
    if (event.key === "/") {
      event.preventDefault();
      if (open) location.hash = "#trials";
      setTimeout(() => $("search").focus());
    } else if (open && event.key === "Escape") {
      location.hash = "#trials";
    } else if (open && (event.key === "ArrowLeft" || event.key === "ArrowRight")) {
      const next = neighbour(event.key === "ArrowLeft" ? -1 : 1);
      if (next) { event.preventDefault(); location.hash = link(next); }
    }
  });
  for (const list of document.querySelectorAll("ul[data-trials]")) {
    for (const number of list.dataset.trials.split(" ")) {
      const won = [list.dataset.first, list.dataset.second].map((run) => byKey.get(`${run}/${number}`));
      const failed = won.find((t) => t && !t.success);
      if (failed) list.append(item(failed, `${failed.object}, failed by ${runs[failed.run].name}`));
    }
  }

  applyTheme();
  update();
  route();
  // Reading Plotly takes a browser most of a second: first the page, then its charts.
  const idle = window.requestIdleCallback ?? ((then) => setTimeout(then, 200));
  addEventListener("load", () => idle(() => {
    document.querySelectorAll(".chart").forEach((box) => watcher.observe(box));
  }));
  root.dataset.ready = "true";
})();
