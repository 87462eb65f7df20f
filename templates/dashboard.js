/* Chooses and sorts the cards of a dashboard, and draws one quantity of all of them on one scale. Without script all of
   it is there, in the order of the folders. */
"use strict";
(() => {
  const choice = document.getElementById("choice");
  const board = document.querySelector(".board");
  const cards = [...board.children];
  const { words, show, order, count } = choice.elements;

  const wanted = {
    "": () => true,
    attention: (card) => card.dataset.gravity < 3,
    news: (card) => card.dataset.news === "yes",
    doubted: (card) => card.dataset.doubted === "yes",
  };
  const before = {
    title: (a, b) => a.dataset.title.localeCompare(b.dataset.title, "en", { numeric: true }),
    date: (a, b) => b.dataset.date.localeCompare(a.dataset.date),
    gravity: (a, b) => a.dataset.gravity - b.dataset.gravity,
  };

  function choose() {
    const parts = words.value.toLowerCase().split(/\s+/).filter(Boolean);
    for (const card of cards) {
      const text = card.textContent.toLowerCase();
      card.hidden = !(wanted[show.value](card) && parts.every((part) => text.includes(part)));
    }
    board.append(...(order.value ? [...cards].sort(before[order.value]) : cards));
    count.value = `${cards.filter((card) => !card.hidden).length} of ${cards.length} shown`;
  }

  choice.hidden = false;
  choice.addEventListener("submit", (event) => event.preventDefault());
  choice.addEventListener("input", choose);
  choose();

  const quantity = document.getElementById("quantity");
  if (!quantity) return;
  const rows = [...document.querySelectorAll("#measured tbody tr")];
  const number = (row, name) => Number(row.dataset[name]);
  const text = (value) => String(Number(value.toPrecision(3))).replace("-", "\u2212");

  function drawn(name, attributes) {
    const made = document.createElementNS("http://www.w3.org/2000/svg", name);
    Object.entries(attributes).forEach(([key, value]) => made.setAttribute(key, value));
    return made;
  }

  /* Where the largest is many times the smallest, small ones would fall together: the scale is then logarithmic. */
  function scale(shown) {
    const least = Math.min(...shown.map((row) => number(row, "low")));
    const most = Math.max(...shown.map((row) => number(row, "high")));
    const curved = least > 0 && most / least > 30;
    const way = curved ? Math.log : (value) => value;
    const span = way(most) - way(least) || 1;
    return { least, most, curved, at: (value) => `${(2 + (96 * (way(value) - way(least))) / span).toFixed(2)}%` };
  }

  function draw() {
    const chosen = quantity.elements.quantity.value;
    rows.forEach((row) => { row.hidden = row.dataset.quantity !== chosen; });
    const shown = rows.filter((row) => !row.hidden);
    /* Results of one name in several units stand on a scale for each unit. */
    const units = [...new Set(shown.map((row) => row.dataset.scale))];
    const scales = units.map((unit) => {
      const group = shown.filter((row) => row.dataset.scale === unit);
      const { least, most, curved, at } = scale(group);
      group.forEach((row) => {
        const [low, high, size] = ["low", "high", "size"].map((name) => at(number(row, name)));
        const picture = drawn("svg", { "aria-hidden": "true" });
        picture.append(
          drawn("line", { class: "range", x1: "0", x2: "100%", y1: "50%", y2: "50%" }),
          drawn("line", { class: "extent", x1: low, x2: high, y1: "50%", y2: "50%" }),
          drawn("circle", { class: "point", cx: size, cy: "50%", r: "4" }),
        );
        const cell = row.querySelector(".interval");
        cell.querySelector("svg")?.remove();
        cell.append(picture);
      });
      return `Lines from ${text(least)} to ${text(most)} ${unit}${curved ? ", logarithmic" : ""}`.trimEnd();
    });
    quantity.elements.scale.value = `${scales.join("; ")}; bars: coverage intervals.`;
  }

  quantity.hidden = false;
  quantity.addEventListener("submit", (event) => event.preventDefault());
  quantity.addEventListener("input", draw);
  draw();
})();
