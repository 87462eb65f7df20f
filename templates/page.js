/* Tables that sort, chapters of the annex that fold, and contents that follow the reader and fold on a narrow screen. Without
   script all of it is there, as it is on paper. */
"use strict";
(() => {
  const words = JSON.parse(document.getElementById("words")?.textContent ?? "{}");
  const said = (message) => words[message] ?? message;
  const powers = "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079";
  function size(words) {
    const plain = words.replaceAll("\u2212", "-").replace(/(\d),(?=\d)/g, "$1.").replace(/\u00d710(\u207b?)([\u2070\u00b9\u00b2\u00b3\u2074-\u2079]+)/, (_all, sign, digits) =>
      `e${sign ? "-" : ""}${[...digits].map((digit) => powers.indexOf(digit)).join("")}`);
    const found = plain.match(/[-+]?\d+(\.\d+)?(e-?\d+)?/);
    /* "< 0.01 %" comes before 0.01 %, "> 99.9 %" after it; what is no number comes last. */
    return found ? Number(found[0]) * (plain.includes("<") ? 1 - 1e-9 : plain.includes(">") ? 1 + 1e-9 : 1) : Infinity;
  }

  const kinds = {
    number: (a, b) => (a === b ? 0 : size(a) - size(b) || 0),
    text: (a, b) => a.localeCompare(b, "en", { numeric: true }),
  };

  function sortable(head) {
    const row = head.parentElement;
    const body = head.closest("table").tBodies[0];
    const original = [...body.rows];
    /* A row that spans the table, such as the rest of a budget, stays at the end. */
    const [sorted, fixed] = [original.filter((one) => !one.querySelector("[colspan]")), original.filter((one) => one.querySelector("[colspan]"))];
    if (sorted.length < 3) return;
    const column = [...row.cells].indexOf(head);
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const next = { ascending: "descending", descending: null }[head.getAttribute("aria-sort")];
      row.querySelectorAll("[aria-sort]").forEach((other) => other.removeAttribute("aria-sort"));
      const rows = [...sorted];
      if (next !== null) {
        const way = next ?? "ascending";
        head.setAttribute("aria-sort", way);
        const words = (one) => one.cells[column].textContent.trim();
        rows.sort((a, b) => kinds[head.dataset.sort](words(a), words(b)) * (way === "ascending" ? 1 : -1));
      }
      body.append(...rows, ...fixed);
    });
  }

  function contents(nav) {
    const links = new Map([...nav.querySelectorAll("a")].map((link) => [document.querySelector(link.hash), link]));
    const mark = () => {
      const above = [...links.keys()].filter((part) => part.getBoundingClientRect().top < innerHeight / 3);
      links.forEach((link) => link.removeAttribute("aria-current"));
      const link = links.get(above.at(-1) ?? links.keys().next().value);
      link.setAttribute("aria-current", "location");
      const box = nav.getBoundingClientRect();
      const own = link.getBoundingClientRect();
      if (getComputedStyle(nav).position === "fixed" && (own.top < box.top || own.bottom > box.bottom)) link.scrollIntoView({ block: "nearest" });
    };
    let waiting = false;
    addEventListener("scroll", () => {
      if (waiting) return;
      waiting = true;
      requestAnimationFrame(() => { waiting = false; mark(); });
    }, { passive: true });
    mark();
    const list = nav.querySelector("ol");
    list.id = "contents-list";
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = nav.querySelector("h2").textContent;
    button.setAttribute("aria-controls", list.id);
    nav.prepend(button);
    const fold = (closed) => {
      nav.classList.toggle("closed", closed);
      button.setAttribute("aria-expanded", String(!closed));
    };
    button.addEventListener("click", () => fold(!nav.classList.contains("closed")));
    nav.classList.add("folds");
    fold(true);
  }

  /* A chapter shows its title and its conclusion until it is opened, by its title, by a link into it or by a search for its words. */
  function chapter(section) {
    const head = section.querySelector("h2");
    const body = document.createElement("div");
    const rest = [...section.childNodes].filter((one) => one !== head);
    const first = section.firstElementChild.nextElementSibling;
    body.id = `${section.id}-chapter`;
    body.append(...rest.filter((one) => one !== first || !one.matches(".conclusion")));
    section.append(body);
    const button = document.createElement("button");
    button.type = "button";
    button.className = "chapter";
    button.setAttribute("aria-controls", body.id);
    button.append(...head.childNodes);
    head.append(button);
    const open = (wanted) => {
      button.setAttribute("aria-expanded", String(wanted));
      /* The browser's search finds words in what is hidden like this. */
      if (wanted) body.removeAttribute("hidden");
      else body.setAttribute("hidden", "until-found");
    };
    const opened = () => button.getAttribute("aria-expanded") === "true";
    button.addEventListener("click", () => open(!opened()));
    body.addEventListener("beforematch", () => open(true));
    open(false);
    return { section, open, opened };
  }

  function chapters(sections) {
    if (!sections.length) return;
    const all = sections.map(chapter);
    const bar = document.createElement("p");
    bar.className = "bar";
    for (const [label, opened] of [[said("Open all chapters"), true], [said("Close all chapters"), false]]) {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = label;
      button.addEventListener("click", () => all.forEach((one) => one.open(opened)));
      bar.append(button);
    }
    sections[0].before(bar);
    const reveal = (hash) => {
      const target = hash.length > 1 && document.getElementById(decodeURIComponent(hash.slice(1)));
      const found = target && all.find((one) => one.section.contains(target));
      if (!found) return;
      found.open(true);
      target.scrollIntoView();
    };
    document.addEventListener("click", (event) => {
      const link = event.target.closest('a[href^="#"]');
      if (link) reveal(link.hash);
    });
    addEventListener("hashchange", () => reveal(location.hash));
    /* On paper all chapters are open, and afterwards those that were. */
    let closed = [];
    addEventListener("beforeprint", () => {
      closed = all.filter((one) => !one.opened());
      closed.forEach((one) => one.open(true));
    });
    addEventListener("afterprint", () => closed.forEach((one) => one.open(false)));
    reveal(location.hash);
  }

  /* On a phone each row is a card: every cell then carries the words of its column, and says that it is a cell. */
  function cards(table) {
    const heads = table.tHead && table.tHead.rows.length === 1 ? [...table.tHead.rows[0].cells] : [];
    if (heads.length < 3 || heads.some((head) => head.colSpan > 1)) return;
    table.classList.add("cards");
    table.setAttribute("role", "table");
    heads.forEach((head) => head.setAttribute("role", "columnheader"));
    for (const row of [table.tHead.rows[0], ...[...table.tBodies].flatMap((body) => [...body.rows])]) row.setAttribute("role", "row");
    for (const body of table.tBodies) {
      body.setAttribute("role", "rowgroup");
      for (const row of body.rows) {
        let column = 0;
        for (const cell of row.cells) {
          if (cell.colSpan === 1) cell.dataset.label = heads[column].innerText.trim().replace(/\s+/g, " ");
          cell.setAttribute("role", cell.tagName === "TH" ? "rowheader" : "cell");
          column += cell.colSpan;
        }
      }
    }
  }

  /* What scrolls sideways on a narrow screen can be reached by keys. */
  function reachable() {
    document.querySelectorAll("section, article").forEach((part) => {
      if (part.scrollWidth > part.clientWidth) part.tabIndex = 0;
      else part.removeAttribute("tabindex");
    });
  }

  document.querySelectorAll("main table").forEach(cards);
  chapters([...document.querySelectorAll(".cover ~ section")]);
  reachable();
  addEventListener("resize", reachable);
  document.querySelectorAll("th[data-sort]").forEach(sortable);
  const nav = document.getElementById("contents");
  /* A certificate alone has none. */
  if (nav) contents(nav);
})();
