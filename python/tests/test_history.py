import math
import unittest
from datetime import datetime, timezone

from rubicon import Error
from rubicon._history import MAX_BUCKETS, Range, frame, samples

try:
    import pandas
except ImportError:
    pandas = None

LIGHT = "6541:proxy.wsn-1.7.sensor.light-1.value"


def series(**members):
    return {"key": LIGHT, "kind": "number", "unit": "lx", "gaps": [], **members}


class Ranges(unittest.TestCase):
    def test_the_width_is_one_that_the_server_has(self):
        self.assertEqual(Range.of(1000, 4600, 300), (900_000, 4_800_000, 300_000))
        with self.assertRaisesRegex(Error, "every is 420 s; the history has .*5min, 10min"):
            Range.of(0, 4600, 420)

    def test_without_a_width_there_are_at_most_a_thousand_rows(self):
        for span in (0.5, 60, 3600, 86400, 30 * 86400, 400 * 86400):
            rows = Range.of(1e9 + 0.3, 1e9 + 0.3 + span, 0).rows
            self.assertTrue(100 <= rows <= 1000, f"{span}: {rows}")

    def test_long_times_are_asked_in_parts(self):
        span = Range.of(0, 12000 * 60, 60)
        self.assertEqual([part.rows for part in span.parts()], [MAX_BUCKETS, MAX_BUCKETS, 2000])
        paths = list(span.paths([f"1:a.{one}" for one in range(40)]))
        self.assertEqual(len(paths), 6)
        self.assertTrue(all(path.count("key=") <= 32 for path in paths))
        with self.assertRaisesRegex(Error, "out-of-range"):
            Range.of(0, 1e9, 0.001)
        with self.assertRaisesRegex(Error, "before `until`"):
            Range.of(5, 5, 1)


class Rows(unittest.TestCase):
    def test_of_numbers_words_texts_and_gaps(self):
        answer = {"series": [
            series(t=[100, 200.5], v=[1, 2], gaps=[[300, 400]]),
            {"key": "1:b", "kind": "words", "t": [100], "v": [1], "words": ["off", "on"], "gaps": []},
            {"key": "1:c", "kind": "text", "texts": [[150, "a"], [250, ""]], "gaps": []},
        ]}  # fmt: skip
        rows = [(row.time.timestamp(), row.key[:3], row.value) for row in samples([answer])]
        self.assertEqual(rows, [(100, "1:b", "on"), (100, "654", 1), (150, "1:c", "a"), (200.5, "654", 2),
                                (250, "1:c", None), (300, "654", None)])

    def test_buckets_of_several_values(self):
        (one, other) = samples([{"series": [
            series(t=[100], first=[1], min=[0.5], max=[4], mean=[2], last=[3], n=[7]),
            {"key": "6541:z", "kind": "words", "t": [100], "first": [0], "min": [0], "max": [1], "mean": [0.2], "last": [1],
             "n": [2], "words": ["off", "on"], "gaps": []},
        ]}])  # fmt: skip
        self.assertEqual(one[2:], (3, 1, 0.5, 4, 2, 7))
        self.assertEqual(other[2:], ("on", "off", "off", "on", 1, 2))
        self.assertEqual(samples([{"series": [series(t=[100], v=[5])]}])[0][2:], (5, 5, 5, 5, 5, 1))


@unittest.skipIf(pandas is None, "pandas is not installed")
class Frames(unittest.TestCase):
    def made(self, *members, span=Range(0, 600_000, 60_000), now=600.0, show="mean"):
        return frame([{"series": list(members)}], span, now, show)

    def column(self, *members, **options):
        table = self.made(*members, **options)
        return [None if isinstance(one, float) and math.isnan(one) else one for one in table.iloc[:, 0]]

    def test_the_index_is_utc_and_units_are_attributes(self):
        table = self.made(series(t=[0, 60], v=[1, 2]))
        self.assertEqual(str(table.index.tz), "UTC")
        self.assertEqual(table.index[1], datetime(1970, 1, 1, 0, 1, tzinfo=timezone.utc))
        self.assertEqual(list(table.columns), ["proxy.wsn-1.7.sensor.light-1.value"])
        self.assertEqual(table.attrs["units"], {"proxy.wsn-1.7.sensor.light-1.value": "lx"})
        self.assertEqual(table.attrs["every"], 60)

    def test_a_value_holds_until_the_next_one(self):
        column = self.column(series(t=[60, 240], mean=[1, 4], last=[2, 5], before=[-5, 9]))
        self.assertEqual(column, [9, 1, 2, 2, 4, 5, 5, 5, 5, 5])

    def test_what_of_a_row_is_shown(self):
        bucket = series(t=[60], first=[1], min=[0.5], max=[4], mean=[2], last=[3], n=[7])
        for show, expected in (("first", 1), ("minimum", 0.5), ("maximum", 4), ("mean", 2), ("last", 3)):
            self.assertEqual(self.column(bucket, show=show)[:3], [None, expected, 3], show)
        self.assertEqual(self.column(bucket, show="count")[:3], [0, 7, 0])
        texts = {"key": "1:c", "kind": "text", "texts": [[60, "a"], [61, "b"], [240, ""]], "gaps": []}
        self.assertEqual(self.column(texts, show="count")[:5], [0, 2, 0, 0, 0])

    def test_a_gap_is_nan(self):
        column = self.column(series(t=[60, 420], v=[1, 7], gaps=[[180, 400]]))
        self.assertEqual(column, [None, 1, 1, None, None, None, None, 7, 7, 7])

    def test_a_bucket_that_a_gap_shares_with_a_value_has_the_value(self):
        column = self.column(series(t=[60, 120, 360], v=[1, 2, 6], gaps=[[130, 380]]))
        self.assertEqual(column[:8], [None, 1, 2, None, None, None, 6, 6])

    def test_what_is_to_come_has_no_rows(self):
        self.assertEqual(self.column(series(t=[60], v=[1]), now=190.0), [None, 1, 1, 1])

    def test_words_are_numbers_that_can_be_drawn(self):
        table = self.made(series(kind="words", t=[0, 120], last=[0, 1], mean=[0.2, 0.7], words=["closed", "open"]))
        self.assertEqual(list(table.iloc[:4, 0]), [0, 0, 1, 1])
        self.assertEqual(list(table.attrs["words"].values()), [["closed", "open"]])

    def test_texts_stay_texts(self):
        column = self.column({"key": "1:c", "kind": "text", "texts": [[60, "a"], [240, ""], [300, "b"]], "gaps": []})
        self.assertEqual(column[:7], [None, "a", "a", "a", None, "b", "b"])

    def test_parts_of_a_long_time_are_one_column(self):
        first, second = series(t=[60], v=[1]), series(t=[360], v=[6], before=[60, 1])
        table = frame([{"series": [first]}, {"series": [second]}], Range(0, 600_000, 60_000), 600.0)
        self.assertEqual(list(table.iloc[1:8, 0]), [1, 1, 1, 1, 1, 6, 6])

    def test_two_owners_of_a_key_keep_their_names(self):
        table = self.made(series(t=[0], v=[1]), {**series(t=[0], v=[2]), "key": LIGHT.replace("6541", "7")})
        self.assertEqual([name.split(":")[0] for name in table.columns], ["6541", "7"])


if __name__ == "__main__":
    unittest.main()
