  // ------------------------------------------------------------ which runs are shown
  const boxes = [...document.querySelectorAll(".pick")];
  const order = boxes.map((box) => Number(box.value));   // as the tables list them
  let picked = order.filter((i) => newest.includes(i));
  let against = reference;
  const OWN = [["merits", "no-merits"], ["held", "no-held"]].filter(([id]) => $(id));   // not of every run
  const showPicked = () => {
    for (const box of boxes) {
      box.checked = picked.includes(Number(box.value));
      box.closest("tr").classList.toggle("picked", box.checked);
    }
    for (const part of document.querySelectorAll("[data-of]")) {   // of one run or several
      part.hidden = !part.dataset.of.split(" ").some((i) => picked.includes(Number(i)));
    }
    for (const [table, none] of OWN) $(none).hidden = [...$(table).children].some((row) => !row.hidden);
    $("chosen").textContent = `${picked.length} of ${runs.length} run${runs.length === 1 ? "" : "s"} shown below`;
    redraw();
    showPairs();
  };
  const pick = (found) => {
    picked = order.filter((i) => found.includes(i));
    showPicked();
    update();
  };
  for (const box of boxes) {
    box.hidden = false;
    box.addEventListener("change", () => pick(boxes.filter((b) => b.checked).map((b) => Number(b.value))));
  }
  $("choice").hidden = runs.length < 2;
  $("first-choice").addEventListener("click", () => pick(newest));
  $("all-runs").addEventListener("click", () => pick(order));
  $("no-runs").addEventListener("click", () => pick([]));
  const openGroups = () => {   // those with nothing chosen are a line each
    for (const group of document.querySelectorAll("details.group")) {
      group.open = boxes.some((box) => box.checked && group.contains(box));
    }
  };

  // ------------------------------------------------------------ one of them against the others
  const compared = (found, id) => {
    const rows = order.map((i) => found[against].find(([run]) => run === i)).filter(Boolean);
    $(id).replaceChildren(...rows.map(([run, ...cells]) => {
      const name = element("th", { scope: "row" }, runs[run].label);
      return element("tr", {}, name, ...cells.map((c) => element("td", { class: "num" }, String(c ?? "–"))));
    }));
    $(`no-${id}`).hidden = rows.length > 0;
    $(id).closest("table").hidden = !rows.length;
    return rows;
  };
  const showPairs = () => {
    const rows = compared(versus, "pairs");
    if ($("firmer")) {
      compared(firmer, "firmer");
      $("firm-reference").textContent = runs[against].name;
    }
    $("discordant").hidden = true;
    const mine = new Map(trials.filter((t) => t.run === against).map((t) => [t.same, t]));
    const lists = picked.filter((i) => i !== against && rows.some(([run]) => run === i)).flatMap((i) => {
      const links = trials.filter((t) => t.run === i && mine.has(t.same) && mine.get(t.same).success !== t.success)
        .map((t) => (t.success ? mine.get(t.same) : t))
        .map((t) => item(t, `${t.object}, failed by ${runs[t.run].name}`));
      return links.length ? [element("h3", {}, `${runs[against].name} against ${runs[i].name}`),
        element("ul", { class: "trial-links" }, ...links)] : [];
    });
    $("discordant").querySelector("div").replaceChildren(...lists);
    $("discordant").hidden = !lists.length;
  };
  $("reference").replaceChildren(...order.map((i) => option(i, runs[i].name)));
  $("reference").addEventListener("change", () => {
    against = Number($("reference").value);
    showPairs();
    remember();
  });

