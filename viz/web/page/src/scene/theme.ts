// Colours of the scene. The palette is Okabe and Ito's (2008), which people of all kinds of colour vision tell apart; a
// sensor has the same colour in the scene, in the legend and in every panel (style.css).
import { Color, ColorManagement } from "three";

ColorManagement.enabled = false; // colours are written to the screen as they are named

export interface SceneTheme {
  background: Color;
  free: Color;
  lidar: Color;
  camera: Color;
  both: Color;
  conflict: Color;
  lines: Color;
  trajectory: Color;
  truth: Color;
  loop: Color;
  loopOff: Color;
  scan: Color;
  robot: Color;
  robotEdge: Color;
  keyframe: Color;
  highlight: Color;
}

const common = {
  lidar: new Color("#0072b2"),
  camera: new Color("#e69f00"),
  conflict: new Color("#d55e00"),
  loop: new Color("#cc79a7"),
  loopOff: new Color("#d55e00"),
};

export const THEMES: Record<"light" | "dark", SceneTheme> = {
  light: {
    ...common,
    background: new Color("#e4e9ed"),
    free: new Color("#ffffff"),
    both: new Color("#17212b"),
    lines: new Color("#cdd5db"),
    trajectory: new Color("#009e73"),
    truth: new Color("#6b7780"),
    loop: new Color("#b0528a"),
    scan: new Color("#d55e00"),
    robot: new Color("#f0e442"),
    robotEdge: new Color("#17212b"),
    keyframe: new Color("#009e73"),
    highlight: new Color("#17212b"),
  },
  dark: {
    ...common,
    lidar: new Color("#56b4e9"),
    background: new Color("#0d151b"),
    free: new Color("#1f2d38"),
    both: new Color("#eef4f8"),
    lines: new Color("#1a2730"),
    trajectory: new Color("#2fd6a3"),
    truth: new Color("#8a9ba8"),
    loop: new Color("#e79cc5"),
    scan: new Color("#ff7f50"),
    robot: new Color("#f0e442"),
    robotEdge: new Color("#0d151b"),
    keyframe: new Color("#2fd6a3"),
    highlight: new Color("#ffffff"),
  },
};
