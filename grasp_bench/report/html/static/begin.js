"use strict";
// The page's script is these files one after the other: begin, charts, runs, trials, trial, address.
(() => {
  const $ = (id) => document.getElementById(id);
  const read = (id) => JSON.parse($(id).textContent);
  const { runs, outcomes, trials, shown: newest, reference, versus, firmer } = read("data");
  const charts = read("charts");
  const root = document.documentElement;
  const byKey = new Map(trials.map((t) => [`${t.run}/${t.trial}`, t]));

  const element = (tag, attributes = {}, ...children) => {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    made.append(...children);
    return made;
  };
  const option = (value, text) => element("option", { value }, text);
  const link = (trial) => `#${encodeURIComponent(runs[trial.run].name)}/${trial.trial}`;
  const badge = (outcome) => {
    const made = element("span", { class: "outcome" }, outcome);
    made.style.setProperty("--dot", `var(--${outcomes.includes(outcome) ? outcome : "error"})`);
    return made;
  };
  const item = (t, text) => element("li", {}, element("a", { href: link(t) }, text), " ", badge(t.outcome));

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

