/* The upper part follows the news; the report is exchanged where there is a newer one, and stays where the reader was. */
"use strict";
(() => {
  const panel = document.getElementById("panel");
  const frame = document.getElementById("report");
  let shown = frame ? Number(frame.dataset.count) : 0;
  let place = 0;

  function exchange(count) {
    shown = count;
    if (frame.hidden) {
      frame.hidden = false;
      frame.src = `report?${count}`;
      return;
    }
    const page = frame.contentWindow;
    const end = page.document.documentElement.scrollHeight - page.innerHeight;
    /* A first page is shorter: at its end, the reader is on the way back to a place further down. */
    place = page.scrollY < end - 2 ? page.scrollY : Math.max(place, page.scrollY);
    frame.addEventListener("load", () => frame.contentWindow.scrollTo(0, place), { once: true });
    page.location.replace(`report?${count}`);
  }

  const news = new EventSource("events");
  news.addEventListener("message", (message) => {
    const state = JSON.parse(message.data);
    document.title = state.title;
    panel.innerHTML = state.panel;
    if (frame && state.report !== shown) exchange(state.report);
  });
  news.addEventListener("error", () => {
    panel.innerHTML = "<p><b>metrology watch does not answer: it has ended, or is about to begin again.</b></p>";
  });
})();
