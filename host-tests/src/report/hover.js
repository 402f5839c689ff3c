"use strict";
// Shows the values of the drawn point nearest to the pointer; arrow keys step along a series.
(() => {
  const readout = document.getElementById("readout");

  const axis = (text) => {
    const [kind, ...numbers] = text.split(" ");
    const [low, high, from, to] = numbers.map(Number);
    const bend = kind === "log" ? Math.log : (v) => v;
    const unbend = kind === "log" ? Math.exp : (v) => v;
    const span = bend(high) - bend(low);
    return {
      place: (v) => from + (bend(v) - bend(low)) / span * (to - from),
      value: (p) => unbend(bend(low) + (p - from) / (to - from) * span),
    };
  };

  // Short series carry their values; of long ones the path is read: M absolute, l relative, tenths.
  const points = (series, x, y) => {
    const exact = series.dataset.points;
    if (exact !== undefined) {
      return exact.split(" ").filter(Boolean).map((pair) => {
        const [a, b] = pair.split(",").map(Number);
        return { a, b, px: x.place(a), py: y.place(b) };
      });
    }
    const found = [];
    let [px, py] = [0, 0];
    for (const [, command, body] of series.firstElementChild.getAttribute("d").matchAll(/([Ml])([^Ml]*)/g)) {
      const numbers = body.trim().split(" ").map((n) => Number(n) / 10);
      if (command === "M") [px, py] = [0, 0];
      for (let i = 0; numbers.length > i; i += 2) {
        px += numbers[i];
        py += numbers[i + 1];
        found.push({ a: x.value(px), b: y.value(py), px, py });
      }
    }
    return found;
  };

  const digits = (v) => {
    const plain = v === 0 || (Math.abs(v) >= 1e-3 && 1e5 > Math.abs(v));
    return (plain ? String(Number(v.toPrecision(4))) : v.toExponential(3)).replace("-", "\u2212");
  };

  for (const svg of document.querySelectorAll(".plot > svg")) {
    const cursor = svg.querySelector(".cursor");
    const data = svg.dataset;
    let series = null;
    let at = [0, 0];

    const load = () => {
      const [x, y] = [axis(data.x), axis(data.y)];
      series ??= [...svg.querySelectorAll(".series")]
        .map((g) => ({ label: g.dataset.label, points: points(g, x, y) }))
        .filter((s) => s.points.length > 0);
      return series.length > 0;
    };
    const hide = () => {
      readout.style.display = "none";
      cursor.setAttribute("visibility", "hidden");
    };
    const show = ([s, i]) => {
      at = [s, i];
      const { a, b, px, py } = series[s].points[i];
      cursor.setAttribute("cx", px);
      cursor.setAttribute("cy", py);
      cursor.setAttribute("visibility", "visible");
      readout.textContent = [series[s].label, data.xName + " " + digits(a) + " " + data.xUnit,
        data.yName + " " + digits(b) + " " + data.yUnit].join("\n");
      readout.style.display = "block";
      const p = new DOMPoint(px, py).matrixTransform(svg.getScreenCTM());
      const left = p.x + 14 + readout.offsetWidth > innerWidth ? p.x - 14 - readout.offsetWidth : p.x + 14;
      readout.style.left = Math.max(0, left) + "px";
      readout.style.top = Math.max(0, p.y - 14 - readout.offsetHeight) + "px";
    };
    const nearest = (event) => {
      if (!load()) return;
      const p = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
      let [best, least] = [at, Infinity];
      series.forEach((s, k) => s.points.forEach((q, i) => {
        const distance = (q.px - p.x) ** 2 + (q.py - p.y) ** 2;
        if (least > distance) [best, least] = [[k, i], distance];
      }));
      show(best);
    };
    svg.addEventListener("pointermove", nearest);
    svg.addEventListener("pointerdown", nearest);
    svg.addEventListener("pointerleave", hide);
    svg.addEventListener("blur", hide);
    svg.addEventListener("keydown", (event) => {
      const [ds, di] = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [1, 0], ArrowDown: [-1, 0] }[event.key] ?? [0, 0];
      if ((ds === 0 && di === 0) || !load()) return;
      event.preventDefault();
      const s = (at[0] + ds + series.length) % series.length;
      show([s, Math.min(Math.max(at[1] + di, 0), series[s].points.length - 1)]);
    });
  }
})();
