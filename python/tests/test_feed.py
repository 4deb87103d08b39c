"""Frames as data: those of docs/api.md, and the same mutated."""

import asyncio
import copy
import json
import random
import unittest

from rubicon import Error
from rubicon._feed import MAX_EVENTS, MAX_WOKEN, Feed, Flow
from rubicon._http import Server
from rubicon._names import query_of
from rubicon._web import WebDoor

LIGHT = "6541:proxy.wsn-1.7.sensor.light-1."
ABOUT = json.dumps({"data_type": "real", "unit": "lx", "report": "state"})
GOOD = json.dumps({"quality": "good", "reason": ""})
STALE = json.dumps({"quality": "stale", "reason": "silent"})


class Conversation:
    """A feed, with what its streams are told by a server."""

    def __init__(self, pattern="proxy.*.*.sensor.*.value", flow=Flow()):
        self.feed = Feed("*", query_of(pattern), flow, lambda stream: None)
        self.feed.begin()

    def stream(self, role):
        return [one for one in self.feed.streams if one.role == role][-1]

    def describe(self, about=ABOUT, status=GOOD, snapshot=True):
        for role, text in (("description", about), ("status", status)):
            frame = {"k": {"0": LIGHT + role}, "set": [[0, text, 1, 1.5]]}
            self.stream(role).take({**frame, "snapshot": 6541} if snapshot else frame)

    def value(self, text, sequence=1, **members):
        self.stream("value").take({"k": {"0": LIGHT + "value"}, "set": [[0, text, sequence, 1795234047.25]], **members})

    def events(self):
        return list(self.feed.waiting())

    def kinds(self):
        return [(one.kind, one.text, one.quality) for one in self.events()]


class Feeds(unittest.TestCase):
    def test_values_come_with_unit_and_quality(self):
        talk = Conversation()
        talk.describe()
        talk.value("686.6")
        (event,) = talk.events()
        self.assertEqual((event.value, event.unit, event.quality, event.kind), (686.6, "lx", "good", "value"))

    def test_three_subscriptions_of_which_only_the_values_wake(self):
        streams = Conversation(flow=Flow(minimum=1)).feed.streams
        self.assertEqual([(one.pattern, one.flow.passive) for one in streams],
                         [("*:proxy.*.*.sensor.*.description", True), ("*:proxy.*.*.sensor.*.status", True),
                          ("*:proxy.*.*.sensor.*.value", False)])

    def test_a_value_waits_until_its_quality_is_known(self):
        talk = Conversation()
        talk.value("1", 1)
        talk.value("2", 2)
        self.assertEqual(talk.events(), [])
        talk.describe()
        self.assertEqual(talk.kinds(), [("value", "2", "good")])

    def test_what_nobody_reported_yet_is_no_event(self):
        talk = Conversation()
        talk.describe()
        talk.value("")
        self.assertEqual(talk.events(), [])
        talk.value("5", 2)
        self.assertEqual(talk.kinds(), [("value", "5", "good")])

    def test_of_each_tuple_the_latest_value_waits(self):
        talk = Conversation()
        talk.describe()
        for number in range(1, 1001):
            talk.value(str(number), number)
        self.assertEqual((len(talk.feed.queue), talk.feed.merged), (1, 999))
        (event,) = talk.events()
        self.assertEqual((event.text, event.merged, talk.feed.merged), ("1000", 999, 999))
        talk.value("1001", 1001)
        self.assertEqual(talk.events()[0].merged, 0)

    def test_a_change_of_quality_is_an_event(self):
        talk = Conversation()
        talk.describe()
        talk.value("5")
        talk.events()
        talk.describe(status=STALE)
        self.assertEqual(talk.kinds(), [("state", "5", "stale")])
        talk.describe(status=STALE)
        self.assertEqual(talk.events(), [])

    def test_an_owner_that_leaves_takes_the_quality_along(self):
        talk = Conversation()
        talk.describe()
        talk.value("5")
        talk.events()
        talk.stream("value").take({"absent": [6541]})
        self.assertEqual(talk.kinds(), [("state", "5", "network-down")])
        talk.stream("value").take({"present": [6541]})
        self.assertEqual(talk.kinds(), [("state", "5", "good")])

    def test_what_is_deleted_is_gone(self):
        talk = Conversation()
        talk.describe()
        talk.value("5")
        talk.events()
        talk.stream("value").take({"gone": [[0, "expired"]]})
        (event,) = talk.events()
        self.assertEqual((event.kind, event.text, event.reason), ("gone", "5", "expired"))

    def test_after_a_lost_line_values_come_again(self):
        talk = Conversation()
        talk.describe()
        talk.value("5", 1)
        talk.events()
        talk.feed.restart()
        talk.describe()
        talk.value("5", 1)
        (event,) = talk.events()
        self.assertTrue(event.again)
        talk.feed.restart()
        talk.describe()
        talk.value("6", 2)
        self.assertFalse(talk.events()[0].again)

    def test_a_heartbeat_is_no_repetition(self):
        talk = Conversation("proxy.*")
        frame = {"k": {"3": "6541:proxy.island"}, "set": [[3, "x", 1, 2.5, {"m": "text/plain"}]]}
        talk.stream("value").take(frame)
        talk.events()
        talk.feed.restart()
        talk.stream("value").take(frame)
        self.assertTrue(talk.events()[0].again)
        talk.stream("value").take({"set": frame["set"]})
        self.assertFalse(talk.events()[0].again)

    def test_what_does_not_come_again_is_gone(self):
        for how in ("snapshot", "patience"):
            with self.subTest(how):
                talk = Conversation()
                talk.describe()
                talk.value("5", snapshot=6541)
                talk.events()
                talk.feed.restart()
                if how == "snapshot":
                    talk.stream("value").take({"snapshot": 6541})
                else:
                    talk.feed.patience_ended()
                self.assertEqual([one.kind for one in talk.events()], ["gone"])

    def test_events_are_kept_in_order_up_to_a_bound(self):
        talk = Conversation()
        talk.describe(about=json.dumps({"report": "event", "data_type": "text"}))
        for number in range(MAX_EVENTS + 5):
            talk.value(str(number), number)
            talk.value("", number)
        self.assertEqual((talk.feed.lost, talk.feed.merged), (5, 0))
        self.assertEqual([one.text for one in talk.events()], [str(5 + one) for one in range(MAX_EVENTS)])

    def test_a_tuple_that_comes_and_goes_fills_no_memory(self):
        talk = Conversation()
        talk.describe()
        for number in range(3 * MAX_EVENTS):
            talk.value("5", number)
            talk.stream("value").take({"gone": [[0, "deleted"]]})
        self.assertLessEqual(len(talk.feed.queue), MAX_EVENTS + 3)
        self.assertEqual([one.kind for one in talk.events()], ["value", "gone"] * (MAX_EVENTS // 2))

    def test_a_deleted_tuple_that_comes_back_is_another_one(self):
        talk = Conversation()
        talk.describe()
        talk.value("5")
        talk.stream("value").take({"gone": [[0, "deleted"]]})
        talk.describe(status=STALE, snapshot=False)
        talk.value("6", 2)
        self.assertEqual(talk.kinds(), [("value", "5", "good"), ("gone", "5", "unknown"), ("value", "6", "stale")])

    def test_a_slow_reader_gets_each_value_as_it_is_when_it_is_asked_for(self):
        talk = Conversation()
        talk.describe()
        talk.stream("value").take({"k": {"0": LIGHT + "value", "1": LIGHT.replace("light-1", "light-2") + "value"}})
        talk.stream("value").take({"set": [[0, "1", 1, 1.5], [1, "1", 1, 1.5]]})
        waiting = talk.feed.waiting()
        self.assertEqual(next(waiting).text, "1")
        talk.stream("value").take({"set": [[1, "2", 2, 2.5]]})
        self.assertEqual([(one.text, one.merged) for one in waiting], [("2", 1)])

    def test_a_value_that_came_before_its_quality_is_still_a_repetition(self):
        talk = Conversation()
        talk.describe()
        talk.value("5", 1)
        talk.events()
        talk.feed.restart()
        talk.value("5", 1)
        talk.describe()
        self.assertTrue(talk.events()[0].again)

    def test_wildcards_within_parts_wake_only_what_matches(self):
        talk = Conversation("proxy.*.*.sensor.temperature-*.value")
        keys = [f"6541:proxy.wsn-1.{device}.sensor.{point}.description"
                for device in range(5) for point in ("temperature-1", "temperature-bed", "light-1")]
        talk.stream("description").take({"k": dict(enumerate(keys)), "set": []})
        woken = [one.pattern for one in talk.feed.streams if one.role == "value"]
        self.assertEqual(woken, ["*:proxy.*.*.sensor.temperature-1.value", "*:proxy.*.*.sensor.temperature-bed.value"])

    def test_too_many_kinds_of_points_are_an_error(self):
        talk = Conversation("proxy.*.*.sensor.t*.value")
        talk.stream("description").take({"k": {one: f"1:proxy.a.b.sensor.t-{one}.description" for one in range(MAX_WOKEN + 1)}})
        self.assertEqual(talk.feed.error.code, "out-of-range")

    def test_other_tuples_come_as_they_are(self):
        talk = Conversation("proxy.*")
        entry = [3, '{"id": 6541}', 1, 2.5, {"m": "application/json"}]
        talk.stream("value").take({"k": {"3": "6541:proxy.island"}, "set": [entry]})
        self.assertEqual(talk.events()[0].value, {"id": 6541})


class MutatedFrames(unittest.IsolatedAsyncioTestCase):
    """Whatever a server says: no exception, bounded, and the next sound frame counts."""

    async def test_frames_that_are_none_change_nothing(self):
        chance = random.Random(6541)
        door = WebDoor(Server("127.0.0.1", 1, None, "", 1))
        talk = Conversation()
        talk.describe()
        door._numbered = {1: talk.stream("value"), 2: talk.stream("status"), 3: talk.stream("description")}
        sound = [
            {"s": 1, "k": {"0": LIGHT + "value"}, "set": [[0, "1", 1, 2.5]], "snapshot": 6541},
            {"s": 2, "set": [[0, GOOD, 2, 3.5]]}, {"s": 1, "gone": [[0, "deleted"]]}, {"s": 1, "absent": [6541]},
            {"message": {"from": 1, "type": "x", "value": "y"}}, {"id": 3, "ok": True, "tuple": {}},
            {"lost": {"s": 1, "events": 3}}, {"islands": []}, {"alive": 5.5}, {"slow": True},
        ]
        for _ in range(20000):
            text = json.dumps(mutated(chance, copy.deepcopy(chance.choice(sound))))
            if chance.random() < 0.2:
                place = chance.randrange(len(text))
                text = text[:place] + chance.choice('{}[],:"0xé\\') + text[place + 1 :]
            door.take(text)
            for event in talk.events():
                repr(event), event.value, event.time, event.heard, event.kind
        for text in ("", "null", "7", "[]", "[" * 100000, '"s"', b"\xff\xfe", '{"s":1e999}', None):
            door.take(text)
        self.assertGreater(door.malformed, 1000)
        talk.feed.restart()
        talk.describe()
        talk.feed.patience_ended()
        talk.events()
        door.take(json.dumps(sound[0]))
        self.assertEqual([one.text for one in talk.events() if one.kind == "value"], ["1"])


def mutated(chance, value):
    """One member of a JSON value replaced, removed or repeated."""
    junk = [None, True, -1, 0, 2**70, 1e308, "", "x", "6541:a", [], {}, [[]], [0], {"0": 1}]
    if isinstance(value, dict) and value and chance.random() < 0.8:
        key = chance.choice(list(value))
        if chance.random() < 0.2:
            del value[key]
        else:
            value[key] = mutated(chance, value[key])
    elif isinstance(value, list) and value and chance.random() < 0.8:
        place = chance.randrange(len(value))
        if chance.random() < 0.2:
            del value[place]
        else:
            value[place] = mutated(chance, value[place])
    else:
        return chance.choice(junk)
    return value


class Waiting(unittest.IsolatedAsyncioTestCase):
    async def test_who_waits_is_woken_by_events_errors_and_the_end(self):
        talk = Conversation()
        waiting = asyncio.ensure_future(talk.feed.wait())
        await asyncio.sleep(0)
        talk.describe()
        await asyncio.sleep(0)
        self.assertFalse(waiting.done())
        talk.value("5")
        self.assertTrue(await waiting)
        talk.events()
        waiting = asyncio.ensure_future(talk.feed.wait())
        await asyncio.sleep(0)
        talk.feed.end()
        self.assertFalse(await waiting)
        talk.feed.fail(Error("refused", "no"))
        with self.assertRaises(Error):
            await talk.feed.wait()


if __name__ == "__main__":
    unittest.main()
