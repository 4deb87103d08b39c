#!/usr/bin/env python3
"""Writes the temperatures of the last hour to temperatures.csv, and draws them to temperatures.png: history.py [PATTERN]"""

import sys

import matplotlib

import rubicon.sync

matplotlib.use("agg")  # no window

pattern = sys.argv[1] if len(sys.argv) > 1 else "proxy.*.*.sensor.temperature-*.value"
with rubicon.sync.connect() as space:
    frame = space.history(pattern, since="1h", every="1min")
frame.to_csv("temperatures.csv")
axes = frame.plot(figsize=(10, 5), ylabel="°C")
axes.legend(fontsize="x-small", loc="upper left", bbox_to_anchor=(1, 1))
axes.figure.savefig("temperatures.png", bbox_inches="tight")
print(frame.describe().loc[["min", "mean", "max"]].T.round(1).to_string())
