  // ------------------------------------------------------------ address
  // #RUN/TRIAL is a trial's page, #?runs=…&outcome=… what is chosen on the overview, #trials a section of it.
  const FIELDS = ["run", "outcome", "family", "sort"];
  const title = document.title;
  let ready = false;
  const state = () => {
    const told = new URLSearchParams();
    if (picked.length !== newest.length || picked.some((i) => !newest.includes(i))) {
      for (const i of picked) told.append("runs", runs[i].name);
      if (!picked.length) told.append("runs", "");
    }
    if (against !== reference) told.set("reference", runs[against].name);
    for (const id of FIELDS) {
      const value = id === "run" && runs[$(id).value] ? runs[$(id).value].name : $(id).value;
      if ($(id).selectedIndex > 0) told.set(id, value);
    }
    if ($("search").value) told.set("search", $("search").value);
    if ($("direction").getAttribute("aria-pressed") === "true") told.set("descending", "1");
    if (page) told.set("page", page + 1);
    return told.toString();
  };
  const remember = () => {
    if (!ready || open) return;
    const told = state();
    if (told || location.hash.startsWith("#?")) history.replaceState(null, "", `#${told ? `?${told}` : ""}`);
  };
  const restore = (text) => {
    const told = new URLSearchParams(text);
    const numbered = (name) => runs.findIndex((r) => r.name === name);
    picked = order.filter((i) => (told.has("runs") ? told.getAll("runs").map(numbered) : newest).includes(i));
    against = Math.max(numbered(told.get("reference")), -1);
    if (against < 0) against = reference;
    $("reference").value = against;
    for (const id of FIELDS) {
      const value = told.get(id);
      $(id).value = id === "run" && numbered(value) >= 0 ? numbered(value) : value ?? $(id).options[0].value;
      if ($(id).selectedIndex < 0) $(id).selectedIndex = 0;
    }
    $("search").value = told.get("search") ?? "";
    $("direction").setAttribute("aria-pressed", String(told.has("descending")));
    showPicked();
    openGroups();
    select();
    page = Math.max(0, (parseInt(told.get("page"), 10) || 1) - 1);
    show();
  };
  const overview = () => {
    const told = state();
    return told ? `#?${told}` : "#trials";
  };
  const route = () => {
    const hash = location.hash;
    const at = hash.startsWith("#?") ? -1 : hash.lastIndexOf("/");
    let found = null;
    if (at > 0) {
      let name = null;
      try { name = decodeURIComponent(hash.slice(1, at)); } catch { /* not one of ours */ }
      found = byKey.get(`${runs.findIndex((r) => r.name === name)}/${hash.slice(at + 1)}`) ?? null;
    }
    if (found) { showTrial(found); return; }
    const left = open;
    open = null;
    $("overview").hidden = false;
    $("trial").hidden = true;
    document.title = title;
    if (hash.startsWith("#?") && hash.slice(2) !== state()) restore(hash.slice(2));
    if (left) {
      $("tries").replaceChildren();
      const target = hash.startsWith("#?") ? $("trials") : $(hash.slice(1)) ?? $("top");
      target.scrollIntoView();
      const card = [...$("trials").querySelectorAll("a")].find((a) => a.getAttribute("href") === link(left));
      card?.focus();
    }
  };
  addEventListener("hashchange", route);
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("input[type=search], select")) return;
    if (event.key === "/") {
      event.preventDefault();
      if (open) location.hash = overview();
      setTimeout(() => $("search").focus());
    } else if (open && event.key === "Escape") {
      location.hash = overview();
    } else if (open && (event.key === "ArrowLeft" || event.key === "ArrowRight")) {
      const next = neighbour(event.key === "ArrowLeft" ? -1 : 1);
      if (next) { event.preventDefault(); location.hash = link(next); }
    }
  });

  restore("");
  applyTheme();
  ready = true;
  route();
  // Reading Plotly takes a browser most of a second: first the page, then its charts.
  const idle = window.requestIdleCallback ?? ((then) => setTimeout(then, 200));
  addEventListener("load", () => idle(() => {
    document.querySelectorAll(".chart").forEach((box) => watcher.observe(box));
  }));
  root.dataset.ready = "true";
})();
