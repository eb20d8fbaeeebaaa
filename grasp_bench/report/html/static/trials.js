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
      if (!url) {
        const drawn = small(trial.object);
        target.classList.add("none");
        target.replaceChildren(drawn || "no picture");
        continue;
      }
      const alt = `${trial.object}: what was seen, its depth, the proposed grasps, and the end`;
      target.replaceChildren(element("img", { src: url, alt, decoding: "async" }));
    }
  }, { rootMargin: "400px" });

  const thumbs = read("thumbs");
  const small = (name) => (thumbs[name] ? element("img", { src: `data:image/webp;base64,${thumbs[name]}`, alt: "",
    class: "thumb", width: 48, height: 48 }) : "");
  const pictured = (t) => triesOf(t).some(([key]) => $(`media-${key}`) !== null);

  // ------------------------------------------------------------ grid
  const PAGE = 60;
  const contested = () => picked.some((i) => !runs[i].control);
  const later = (t) => (t.success ? 1 : runs[t.run].control && contested() ? 2 : 0);   // controls are meant to fail
  const SORTS = {
    failures: ["Failures first", (t) => [later(t), order.indexOf(t.run), t.trial]],
    trial: ["Trial", (t) => [t.trial, t.run]],
    object: ["Object", (t) => [t.object, t.run, t.trial]],
    quality: ["Predicted quality", (t) => [t.quality]],
    lift: ["Lift height", (t) => [t.lift]],
    force: ["Contact force", (t) => [t.force]],
    mass: ["Mass", (t) => [t.mass]],
    size: ["Size", (t) => [t.size]],
    seconds: ["Time", (t) => [t.seconds]],
  };
  const present = (key) => [...new Set(trials.map((t) => t[key]).filter((v) => v !== undefined))];
  $("run").append(option("", "runs shown"), option("*", "all runs"), ...order.map((i) => option(i, runs[i].name)));
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
    const among = new Set(run === "" ? picked : run === "*" ? order : [Number(run)]);
    shown = trials.filter((t) => among.has(t.run)
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
  const row = (t) => element("tr", {},
    element("td", { class: "picture" }, small(t.object)),
    element("th", { scope: "row" }, element("a", { href: link(t), class: "name" }, t.object)),
    element("td", {}, badge(t.outcome)), element("td", { class: "long why" }, t.detail ?? ""),
    element("td", { class: "of" }, runs[t.run].name), element("td", { class: "num" }, String(t.trial)),
    element("td", { class: "num" }, t.quality === undefined ? "" : t.quality.toFixed(2)));
  const show = () => {
    const cards = shown.some(pictured);
    const pages = Math.max(1, Math.ceil(shown.length / PAGE));
    page = Math.min(Math.max(page, 0), pages - 1);
    lazy.disconnect();
    const here = shown.slice(page * PAGE, (page + 1) * PAGE);
    $("grid").replaceChildren(...(cards ? here.map(card) : []));
    $("list").replaceChildren(...(cards ? [] : here.map(row)));
    $("grid").hidden = !cards;
    $("listed").hidden = cards || !here.length;
    const won = shown.filter((t) => t.success).length;
    $("count").textContent = `${shown.length} of ${trials.length} trials, ${won} of them succeeded`;
    $("page").textContent = `Page ${page + 1} of ${pages}`;
    $("before").disabled = page === 0;
    $("after").disabled = page === pages - 1;
    remember();
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

