// What the page asks of its browser: whether somebody sees it, and what it keeps for us.

import { signal } from "@preact/signals";

/** A tab that nobody sees asks for nothing. */
export const hidden = signal(false);

export function kept(key: string): string {
  try {
    return sessionStorage.getItem(key) ?? "";
  } catch {
    return ""; // a browser that stores nothing for us
  }
}

export function keep(key: string, value: string, store: "sessionStorage" | "localStorage" = "sessionStorage") {
  try {
    if (value) window[store].setItem(key, value);
    else window[store].removeItem(key);
  } catch {
    // Then it lasts as long as the page.
  }
}
