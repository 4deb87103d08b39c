import json
import unittest
from datetime import datetime, timedelta, timezone

from rubicon import Device, Error, Island, Outcome, Value
from rubicon._door import outcome_of
from rubicon._values import Devices, Subject, Values, moment, seconds_of, text_of, utc


def value(text, about=None, status=None, media=""):
    return Value(Subject(6541, "proxy.a.b.sensor.c-1.value", media, about, status or {}), [0, text, 7, 1795234047.25])


class ValuesOfPoints(unittest.TestCase):
    def test_the_type_decides(self):
        for data_type, text, expected in (
            ("real", "21.5", 21.5), ("real", "21", 21.0), ("integer", "7", 7), ("boolean", "on", True),
            ("boolean", "off", False), ("boolean", "1", True), ("enumeration", "heat", "heat"), ("text", "7", "7"),
            ("json", '{"r": 1}', {"r": 1}), ("real", "", None), ("real", "many", "many"), ("integer", "1.5", "1.5"),
            ("boolean", "perhaps", "perhaps"), ("json", "{", "{"), (None, "7", "7"), (7, "7", "7"),
        ):
            with self.subTest(f"{data_type} {text}"):
                got = value(text, {"data_type": data_type}).value
                self.assertEqual((got, type(got)), (expected, type(expected)))

    def test_words_of_a_boolean_are_its_own(self):
        about = {"data_type": "boolean", "words": ["closed", "open"]}
        self.assertIs(value("open", about).value, True)
        self.assertIs(value("closed", about).value, False)
        self.assertEqual(value("open", about).text, "open")

    def test_a_date_is_a_datetime(self):
        about = {"data_type": "text", "type": "dateTime"}
        self.assertEqual(value("2026-01-31T12:00:00", about).value, datetime(2026, 1, 31, 12))
        self.assertEqual(value("soon", about).value, "soon")

    def test_quality_and_times_come_along(self):
        one = value("21.5", {"data_type": "real", "unit": "Cel"},
                    {"quality": "stale", "reason": "silent", "heard": 1795234000.5, "changed": 0})
        self.assertEqual((one.unit, one.quality, one.reason, one.good), ("°C", "stale", "silent", False))
        self.assertEqual(one.heard, datetime.fromtimestamp(1795234000.5, timezone.utc))
        self.assertIsNone(one.changed)
        self.assertEqual(one.time.tzinfo, timezone.utc)
        self.assertEqual((str(one), one.name, one.sequence), ("21.5 °C", "b.c-1", 7))

    def test_what_is_no_entry_has_no_members(self):
        for entry in ([], [0], [0, 5], [0, None, "x", []], [0, "a", 1, 1e300], [0, "a", 1, "now"]):
            one = Value(Subject(1, "a"), entry)
            with self.subTest(entry):
                self.assertIsNone(one.time)
                self.assertIsInstance(one.sequence, int)
                self.assertIn("1:a", repr(one))

    def test_json_of_any_tuple(self):
        self.assertEqual(value('{"id": 1}', media="application/json").value, {"id": 1})

    def test_names_of_devices_are_no_html(self):
        device = Device(6541, "proxy.a.b", "a", "b", name="<script>alert(1)</script>", points=(value("<b>"),))
        for text in (device._repr_html_(), Devices([device])._repr_html_(), Values([value("<i>x")])._repr_html_()):
            self.assertNotIn("<script>", text)
            self.assertNotIn("<i>", text)
            self.assertIn("&lt;", text)

    def test_a_device_prints_its_points(self):
        device = Device(6541, "proxy.a.b", "a", "b", "Kitchen", status="reachable",
                        points=(value("21.5", {"data_type": "real", "unit": "Cel"}, {"quality": "good"}),))
        self.assertRegex(str(device), r"^proxy.a.b  Kitchen  reachable\n  c-1 +21.5 °C  good$")
        self.assertEqual(device["c-1"].value, 21.5)
        with self.assertRaisesRegex(KeyError, "expected one of c-1"):
            device["d-1"]

    def test_members_that_a_later_server_adds_are_left_out(self):
        island = Island.of({"id": 1, "name": "a", "since": 5, "colour": "blue"})
        self.assertEqual((island.id, island.since.year), (1, 1970))


class Spans(unittest.TestCase):
    def test_numbers_texts_and_timedeltas(self):
        for span, seconds in (("250ms", 0.25), ("5s", 5), ("5 min", 300), ("1.5h", 5400), ("7d", 604800), (3, 3),
                              (timedelta(hours=1), 3600)):
            self.assertEqual(seconds_of(span, "span"), seconds)
        for span in ("5", "s", "-1s", -1, None, True, "5 years"):
            with self.subTest(span), self.assertRaisesRegex(Error, "expected a span"):
                seconds_of(span, "span")

    def test_moments(self):
        self.assertEqual(moment("1h", 10000, "since"), 6400)
        self.assertEqual(moment(datetime(2026, 1, 1, tzinfo=timezone.utc), 0, "since"), 1767225600)
        self.assertEqual(utc(1767225600).isoformat(), "2026-01-01T00:00:00+00:00")

    def test_texts_of_values(self):
        for given, text in ((True, "true"), (21.5, "21.5"), (7, "7"), ("on", "on"), (b"\xff", b"\xff")):
            self.assertEqual(text_of(given), text)
        self.assertEqual(json.loads(text_of({"r": 1})), {"r": 1})


class Outcomes(unittest.TestCase):
    """docs/api.md, `verdict`."""

    def state(self, code, **more):
        return outcome_of(Outcome("unknown"), {"ok": False, "error": {"code": code, "text": ""}, **more}).state

    def test_what_was_not_executed_is_told_apart_from_what_nobody_knows(self):
        self.assertEqual(self.state("expired", verdict="expired"), "expired")
        self.assertEqual(self.state("expired", verdict="timed-out"), "timed-out")
        self.assertEqual(self.state("expired"), "timed-out", "an older island does not say which")

    def test_a_refusal_is_one_whatever_its_code(self):
        self.assertEqual(self.state("not-found", verdict="refused"), "refused")
        self.assertEqual(self.state("not-found", verdict="no-such-owner"), "no-such-owner")
        self.assertEqual(self.state("busy"), "refused")


if __name__ == "__main__":
    unittest.main()
