import type { ComponentChild } from "preact";
import type { Route } from "../core/router";
import { devicesView } from "./devices";
import { inboxView } from "./inbox";
import { logView } from "./log";
import { networksView } from "./networks";
import { overviewView } from "./overview";
import { plotsView } from "./plots";
import { recordingsView } from "./recordings";
import { settingsView } from "./settings";
import { trafficView } from "./traffic";
import { tuplesView } from "./tuples";

/** A view of the page: one file, one line in the list below. */
export interface View {
  /** The first part of its address: `#/devices`. */
  id: string;
  title: string;
  /** `g` and this key go there. */
  key: string;
  icon: string;
  /** It has sensors there that the user may wake. */
  wakes?(route: Route): boolean;
  /** A number at its name in the rail, for what needs the user. 0 shows none. */
  mark?(): number;
  show(route: Route): ComponentChild;
}

export const views: View[] = [
  overviewView,
  devicesView,
  tuplesView,
  plotsView,
  inboxView,
  networksView,
  trafficView,
  recordingsView,
  logView,
  settingsView,
];
