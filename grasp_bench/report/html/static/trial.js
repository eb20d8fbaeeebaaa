  // ------------------------------------------------------------ one trial
  const NUMBERS = [
    ["category", "Category"], ["family", "Kind"], ["mass", "Mass", " g"], ["size", "Longest edge", " mm"],
    ["quality", "Predicted quality"], ["rank", "Rank of the grasp tried"], ["x", "Grasp x", " px"],
    ["y", "Grasp y", " px"], ["angle", "Grasp angle", "°"], ["width", "Grasp width", " px"],
    ["widening", "Jaws opened wider than predicted", " mm"], ["shortfall", "Tips above the wanted depth", " mm"],
    ["margin", "Least force that broke the grip", " N"], ["factor", "The same, besides its weight", " × weight"],
    ["direction", "Weakest direction"], ["torque", "Torque that broke the grip", " N m"],
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
    part(".no-media").replaceChildren(small(t.object), `No picture of this ${what} is in this file.`);
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
  const sameElsewhere = (t) => trials.filter((o) => o.same === t.same && o !== t)
    .sort((a, b) => order.indexOf(a.run) - order.indexOf(b.run));
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
    $("replay").textContent = `grasp-bench replay ${quoted(runs[t.run].path)} --trial ${t.trial} --video trial.gif`;
    $("back").href = overview();
    steer("previous", neighbour(-1));
    steer("next", neighbour(1));
    $("overview").hidden = true;
    $("trial").hidden = false;
    document.title = `${t.object}, trial ${t.trial} of ${name}`;
    scrollTo(0, 0);
    $("trial-title").focus({ preventScroll: true });
  };
