"""Past values: what to ask, and answers as a DataFrame. pandas is imported when it is needed."""

from __future__ import annotations

import math
from typing import Any, Dict, Iterator, List, NamedTuple, Sequence, Tuple
from urllib.parse import urlencode

from ._errors import Error
from ._values import Json, Sample, unit_text, utc

#: Seconds. The server has buckets of these widths only (docs/history.md#answers).
WIDTHS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800,
          3600, 7200, 10800, 21600, 43200, 86400, 172800, 604800)
ROWS = 1000  #: at most, where no width is given
MAX_BUCKETS = 5000  #: of a question
MAX_KEYS = 32
MAX_ROWS = 10_000_000
SHOWN = {"mean": "mean", "first": "first", "last": "last", "minimum": "min", "maximum": "max", "count": "n"}


class Range(NamedTuple):
    """From a multiple of `width` since 1970 to another. Milliseconds."""

    start: int
    end: int
    width: int

    @classmethod
    def of(cls, start: float, end: float, every: float) -> Range:
        """Seconds. `every` 0: the finest width that gives at most ROWS rows."""
        if not end > start:
            raise Error("invalid", "since: expected a time before `until`")
        if not every:
            every = next((width for width in WIDTHS if (end - start) / width <= ROWS - 1), WIDTHS[-1])
        if every not in WIDTHS:
            near = sorted(sorted(WIDTHS, key=lambda width: abs(math.log(width / every)))[:3])
            raise Error("invalid", f"every is {every:g} s; the history has {', '.join(map(_span, near))}, ...")
        width = round(every * 1000)
        span = cls(math.floor(start * 1000 / width) * width, math.ceil(end * 1000 / width) * width, width)
        if span.rows > MAX_ROWS:
            raise Error("out-of-range", f"{span.rows} rows; expected at most {MAX_ROWS}: a shorter time, or longer `every`")
        return span

    @property
    def rows(self) -> int:
        return (self.end - self.start) // self.width

    def parts(self) -> Iterator[Range]:
        """Ranges that the server answers at once."""
        step = self.width * MAX_BUCKETS
        for start in range(self.start, self.end, step):
            yield Range(start, min(start + step, self.end), self.width)

    def paths(self, keys: Sequence[str]) -> Iterator[str]:
        for part in self.parts():
            for place in range(0, len(keys), MAX_KEYS):
                query = [("key", key) for key in keys[place : place + MAX_KEYS]]
                query += [("from", f"{part.start / 1000:.3f}"), ("to", f"{part.end / 1000:.3f}"), ("buckets", str(part.rows))]
                yield "/api/v1/history?" + urlencode(query)


def _span(seconds: float) -> str:
    for unit, size in (("d", 86400), ("h", 3600), ("min", 60), ("s", 1)):
        if seconds >= size and not seconds % size:
            return f"{seconds / size:g}{unit}"
    return f"{seconds * 1000:g}ms"


def samples(answers: Sequence[Json]) -> List[Sample]:
    """The values that were kept, in order of time and key."""
    rows: List[Sample] = []
    for series in (series for answer in answers for series in answer["series"]):
        words = series.get("words") or []
        columns = [_values(series, name) for name in ("last", "first", "minimum", "maximum", "mean", "count")]
        several: List[Tuple[Any, ...]] = [
            (time, *(words[int(one)] if words else one for one in values[:4]), *values[4:])
            for time, *values in zip(series.get("t", ()), *columns)]
        single = [(time, text or None) for time, text in series.get("texts", ())]
        single += [(start, None) for start, _ in series.get("gaps", ())]
        several += [(time, value, value, value, value, None, int(value is not None)) for time, value in single]
        rows += [Sample(time, series["key"], *values) for when, *values in several if (time := utc(when)) is not None]
    return sorted(rows, key=lambda row: (row.time, row.key))


def _values(series: Json, show: str) -> List[Any]:
    """Of each bucket that has values."""
    if show == "mean" and series.get("words"):
        show = "last"
    single = series.get("v")
    if single:  # one in each
        return [1] * len(single) if show == "count" else list(single)
    return list(series.get(SHOWN[show], ()))


def frame(answers: Sequence[Json], span: Range, now: float, show: str = "mean") -> Any:
    """A DataFrame with a row for each bucket until now. A value holds until the next one, or until a gap begins."""
    import numpy
    import pandas

    rows = min(span.rows, max(0, math.ceil((now * 1000 - span.start) / span.width)))
    parts: Dict[str, List[Json]] = {}
    for answer in answers:
        for series in answer["series"]:
            parts.setdefault(series["key"], []).append(series)
    names = _short(list(parts))
    columns = {names[key]: _counts(numpy, several, span, rows) if show == "count" else
               _column(numpy, several, span, rows, show) for key, several in parts.items()}
    index = pandas.to_datetime(numpy.arange(rows, dtype="int64") * span.width + span.start, unit="ms", utc=True)
    table = pandas.DataFrame(columns, index=index)
    table.index.name = "time"
    table.attrs["units"] = {names[key]: unit_text(str(several[0].get("unit", ""))) for key, several in parts.items()}
    table.attrs["words"] = {names[key]: several[0]["words"] for key, several in parts.items() if several[0].get("words")}
    table.attrs["every"] = span.width / 1000
    return table


def _column(numpy: Any, several: List[Json], span: Range, rows: int, show: str) -> Any:
    text = any(series.get("kind") == "text" for series in several)
    kind, nothing = ("object", None) if text else ("float64", math.nan)
    shown = numpy.full(rows + 1, nothing, dtype=kind)
    held = numpy.full(rows + 1, nothing, dtype=kind)  # the last row takes what is beyond now
    known = numpy.zeros(rows + 1, dtype=bool)
    gap = numpy.zeros(rows + 1, dtype=bool)

    for number, series in enumerate(several):
        texts = series.get("texts") or []
        before = series.get("before")
        if before and not number:
            shown[0] = held[0] = before[1]
            known[0] = True
        for start, end in series.get("gaps", ()):
            gap[slice(*_places(numpy, [start, end], span, rows))] = True
        at = _places(numpy, [time for time, _ in texts] if text else series.get("t", ()), span, rows)
        shown[at] = [value or None for _, value in texts] if text else numpy.asarray(_values(series, show), dtype="float64")
        held[at] = shown[at] if text else numpy.asarray(_values(series, "last"), dtype="float64")
        known[at] = True
        gap[at] = False
    known |= gap  # in a gap nothing is held
    held[gap] = shown[gap] = nothing
    source = numpy.maximum.accumulate(numpy.where(known, numpy.arange(rows + 1), -1))
    filled = numpy.where(source >= 0, held[source], nothing)
    return numpy.where(known, shown, filled)[:rows]


def _counts(numpy: Any, several: List[Json], span: Range, rows: int) -> Any:
    counts = numpy.zeros(rows + 1)
    for series in several:
        texts = series.get("texts") or []
        numpy.add.at(counts, _places(numpy, [time for time, _ in texts], span, rows), [text != "" for _, text in texts])
        numpy.add.at(counts, _places(numpy, series.get("t", ()), span, rows), _values(series, "count"))
    return counts[:rows]


def _places(numpy: Any, times: Any, span: Range, rows: int) -> Any:
    """Rows of these times; what is beyond now is in the one after the last."""
    rounded = numpy.rint(numpy.asarray(times, dtype="float64") * 1000).astype("int64")
    return numpy.clip((rounded - span.start) // span.width, 0, rows)


def _short(keys: List[str]) -> Dict[str, str]:
    """Names of columns: without the owner where the keys are unique without."""
    bare = [key.split(":", 1)[1] for key in keys]
    return dict(zip(keys, bare)) if len(set(bare)) == len(keys) else dict(zip(keys, keys))
