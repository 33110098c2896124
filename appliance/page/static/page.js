// Renews what a view shows: fetches the view's live part and replaces the pieces that differ, by their ids.
// If the page's server does not answer, values are hidden: what is old must not look new.
"use strict";

const PERIOD_MS = 500;
const LOST_AFTER_MS = 1500;
const live = document.body.dataset.live;
const lost = document.querySelector(".lost");
let answeredMs = performance.now();

function replacePieces(text) {
  const fresh = new DOMParser().parseFromString(text, "text/html");
  for (const piece of fresh.querySelectorAll("p[id].trouble, div[id].notes, section[id]")) {
    const shown = document.getElementById(piece.id);
    if (shown && shown.outerHTML !== piece.outerHTML) replacePiece(shown, piece);
  }
}

function replacePiece(shown, piece) {
  const focused = shown.contains(document.activeElement) ? document.activeElement.id : "";
  const scrolled = [...shown.querySelectorAll(".scroll")].map((part) => [part.scrollLeft, part.scrollTop]);
  const hadFocus = shown.querySelector(".scroll:focus") !== null;
  shown.replaceWith(document.importNode(piece, true));
  const now = document.getElementById(piece.id);
  now.querySelectorAll(".scroll").forEach((part, place) => part.scrollTo(...(scrolled[place] || [0, 0])));
  const target = focused ? document.getElementById(focused) : hadFocus ? now.querySelector(".scroll") : null;
  if (target) target.focus({ preventScroll: true });
}

async function renew() {
  try {
    const answer = await fetch(live, { redirect: "manual", signal: AbortSignal.timeout(LOST_AFTER_MS) });
    if (answer.status === 401) {
      location.assign("/login");
      return;
    }
    if (!answer.ok) throw new Error(String(answer.status));
    replacePieces(await answer.text());
    answeredMs = performance.now();
  } catch {
    // shown below, once it has lasted
  }
  const isLost = performance.now() - answeredMs > LOST_AFTER_MS;
  lost.hidden = !isLost;
  document.body.classList.toggle("stale", isLost);
  setTimeout(renew, PERIOD_MS);
}

if (live) setTimeout(renew, PERIOD_MS);
// a step of commissioning that is being done: ask again until it is
if (document.querySelector("main.commission #trouble:not([hidden])")) setTimeout(() => location.reload(), 2000);
