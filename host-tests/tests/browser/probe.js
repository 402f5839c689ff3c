"use strict";
// Runs in a copy of a page, at its end: writes what is wrong with it, a line each, and what was looked at.
(() => {
  const faults = [];
  const all = (selector) => [...document.querySelectorAll(selector)];
  const expect = (holds, text) => holds || faults.push("FAULT " + text);

  // Contrast by WCAG 2: colours as computed, blended over what lies under them.
  const colour = (css) => {
    const n = (css.match(/-?\d*\.?\d+(e-?\d+)?/g) ?? []).map(Number);
    const full = css.startsWith("color(") ? 1 : 255;
    return { rgb: n.slice(0, 3).map((v) => v / full), alpha: n[3] ?? 1 };
  };
  const blend = (top, under) => top.rgb.map((v, i) => v * top.alpha + under[i] * (1 - top.alpha));
  const behind = (element) => {
    if (element === null) return [1, 1, 1];
    return blend(colour(getComputedStyle(element).backgroundColor), behind(element.parentElement));
  };
  const luminance = (rgb) => {
    const [r, g, b] = rgb.map((v) => v > 0.04045 ? ((v + 0.055) / 1.055) ** 2.4 : v / 12.92);
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const contrast = (css, element) => {
    const under = behind(element);
    const [a, b] = [luminance(blend(colour(css), under)), luminance(under)];
    return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
  };

  let texts = 0;
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const element = walker.currentNode.parentElement;
    const text = walker.currentNode.data.trim();
    if (text === "" || element.closest("script, style, desc, .unseen") !== null) continue;
    const style = getComputedStyle(element);
    const ratio = contrast(element.closest("svg") === null ? style.color : style.fill, element);
    expect(ratio >= 4.5, "contrast " + ratio.toFixed(2) + " of: " + text);
    texts += 1;
  }
  for (const path of all(".plot .series path")) {
    const style = getComputedStyle(path);
    const ink = style.stroke === "none" ? style.fill : style.stroke;
    const ratio = ink === "none" ? 21 : contrast(ink, path);
    expect(ratio >= 3, "contrast " + ratio.toFixed(2) + " of a series");
  }

  // What a screen reader says, and what the pointer and the keys show.
  const readout = document.getElementById("readout");
  const plots = all(".plot > svg");
  for (const svg of plots) {
    const name = svg.getAttribute("aria-label") ?? "";
    const words = document.getElementById(svg.getAttribute("aria-describedby"));
    expect(svg.getAttribute("role") === "img" && name !== "", "a plot without a name");
    expect(words !== null && words.textContent.includes("Series: "), "no words for " + name);
    const labels = [...svg.querySelectorAll(".series")].filter((g) => g.firstElementChild.getAttribute("d"))
      .map((g) => g.dataset.label);
    if (labels.length === 0) continue;
    const shown = (event) => {
      svg.dispatchEvent(event);
      const lines = readout.textContent.split("\n");
      const axes = [svg.dataset.xName + " ", svg.dataset.yName + " "];
      const units = [svg.dataset.xUnit, svg.dataset.yUnit];
      const good = labels.includes(lines[0]) && axes.every((axis, i) => {
        const rest = lines[i + 1] ?? "";
        return rest.startsWith(axis) && rest.endsWith(" " + units[i])
          && Number.isFinite(Number.parseFloat(rest.slice(axis.length).replace("\u2212", "-")));
      });
      expect(good && getComputedStyle(readout).display === "block", "no values of " + name + ": " + lines.join("; "));
    };
    svg.scrollIntoView();
    const box = svg.getBoundingClientRect();
    const [clientX, clientY] = [box.x + box.width / 2, box.y + box.height / 2];
    shown(new PointerEvent("pointermove", { clientX, clientY }));
    shown(new KeyboardEvent("keydown", { key: "ArrowRight" }));
    svg.dispatchEvent(new PointerEvent("pointerleave"));
    expect(getComputedStyle(readout).display === "none", "values stay after " + name);
  }

  const ids = all("[id]").map((element) => element.id);
  expect(new Set(ids).size === ids.length, "an id twice");
  expect(document.documentElement.lang !== "" && document.title !== "", "no language or title");
  expect(all("h1").length === 1 && all("th:not([scope])").length === 0, "headings");
  const first = [...document.querySelector("main").children].slice(1, 3);
  expect(first.some((element) => element.matches(".verdict")), "no verdict on top");
  expect(innerWidth >= document.documentElement.scrollWidth, "wider than the window of " + innerWidth);
  for (const table of all(".scroll")) {
    expect(table.clientWidth >= table.scrollWidth, "a table of " + table.scrollWidth + " in " + table.clientWidth);
  }
  expect(performance.getEntriesByType("resource").length === 0, "a request");

  const result = document.createElement("pre");
  result.id = "probe";
  result.textContent = [...faults, "plots " + plots.length, "texts " + texts].join("\n");
  document.body.append(result);
})();
