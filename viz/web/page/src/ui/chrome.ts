// Theme, the tabs of narrow screens, and help.
import { find, make } from "../dom";

const STORE = "fusion-slam-theme";
type Theme = "light" | "dark";

export function setUpTheme(apply: (theme: Theme) => void): void {
  const system = matchMedia("(prefers-color-scheme: dark)");
  let chosen: string | null = null;
  try {
    chosen = localStorage.getItem(STORE);
  } catch {
    // The system's theme then.
  }
  const use = (): void => {
    const theme: Theme = chosen === "light" || chosen === "dark" ? chosen : system.matches ? "dark" : "light";
    document.documentElement.dataset.theme = theme;
    apply(theme);
  };
  system.addEventListener("change", use);
  find("theme").addEventListener("click", () => {
    chosen = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
    try {
      localStorage.setItem(STORE, chosen);
    } catch {
      // For this visit only.
    }
    use();
  });
  use();
}

export function setUpTabs(): void {
  const tabs = [["map", "Map"], ["camera", "Camera"], ["health", "Health"], ["loops", "Loops"]] as const;
  const buttons = tabs.map(([name, title]) =>
    make("button", { type: "button", "data-for": name, click: () => (document.body.dataset.tab = name) }, title));
  find("tabs").append(...buttons);
  const mark = (): void => buttons.forEach((button) => button.setAttribute("aria-current", String(button.dataset.for === document.body.dataset.tab)));
  new MutationObserver(mark).observe(document.body, { attributes: true, attributeFilter: ["data-tab"] });
  document.body.dataset.tab = "map";
}

const KEYS: [string, string][] = [
  ["Arrow keys, + and −", "move and zoom"], ["F", "show everything"], ["R", "follow the robot"], ["2 / 3", "map from above / view in space"],
  ["Enter", "ask about the middle of the map"], ["L", "say where the robot is"], ["Space", "play or pause a recording"], [", and .", "5 s back or on"],
  ["Esc", "close what is open"],
];

export function setUpHelp(): void {
  const box = find<HTMLDialogElement>("helpbox");
  box.append(
    make("h2", {}, "What you see"),
    make("p", {}, "White is floor that the robot can drive on; coloured cells are walls and obstacles, and the colour says which sensor sees them. Everything else is unknown."),
    make("p", {}, "The yellow arrow is the robot, the green line is where it has been. A pink line joins two places that were recognised as the same: click it to read why."),
    make("p", {}, "Click any cell to ask how sure the map is of it, which sensor says so, and since when."),
    make("h2", {}, "Keys"),
    make("dl", {}, ...KEYS.flatMap(([key, text]) => [make("dt", {}, key), make("dd", {}, text)])),
    make("form", { method: "dialog" }, make("button", { type: "submit" }, "Close")));
  find("help").addEventListener("click", () => box.showModal());
}
