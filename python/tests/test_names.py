import unittest

from rubicon import Error
from rubicon import Device
from rubicon._names import ambiguous, devices_called, is_like_name, not_found, points_called, query_of, split_owner

ISLANDS = {6541: "home", 7: "Hut", 8: "hut"}


def _device(island, network, part, name, address, area="", sensors=(), actuators=(), properties=()):
    return Device(island=island, key=f"proxy.{network}.{part}", network=network, id=part, name=name, address=address,
                  area=area, sensors=sensors, actuators=actuators, properties=properties)


#: The house of tests/client/names_test.cpp, with the same rules.
HOUSE = (
    _device(6541, "dummy-rooms", "living", "Living room", "living", "", ("light-1",), ("lamp-1", "blindPosition-1"), ("rate",)),
    _device(6541, "log-flat", "kitchen", "Kitchen air", "kitchen", "Kitchen", ("temperature-1", "humidity-1")),
    _device(6541, "zigbee", "0x01", "living/ceiling", "0x01", "", (), ("lamp-1",), ("threshold-light-1",)),
    _device(6541, "knx", "1_4_6", "Küche: Decke", "1.4.6", "Kitchen", (), ("lamp-1", "lamp-2")),
    _device(6541, "knx", "1_4_7", "Fridge No. 2", "1.4.7", "", ("contact-door", "power-1")),
    _device(7, "wsn-1", "9", "Mote", "9", "Attic", ("temperature-1",)),
    _device(7, "wsn-1", "10", "Mote", "10", "Attic", ("temperature-1", "temperature-out")),
    _device(7, "wsn-1", "kitchen2", "living", "11", "", (), ("led-1",)),
)


class NamesOfPeople(unittest.TestCase):
    def test_a_point_is_named_as_people_name_it(self):
        for text, key in (
            ("living.lamp-1", "6541:proxy.dummy-rooms.living.actuator.lamp-1"),
            ("living room.LAMP-1", "6541:proxy.dummy-rooms.living.actuator.lamp-1"),
            ("Living room.lamp", "6541:proxy.dummy-rooms.living.actuator.lamp-1"),
            ("Living room.*", "6541:proxy.dummy-rooms.living.*.*"),
            ("living/ceiling.lamp-1", "6541:proxy.zigbee.0x01.actuator.lamp-1"),
            ("KÜCHE: decke.lamp-2", "6541:proxy.knx.1_4_6.actuator.lamp-2"),
            ("1.4.6.lamp-1", "6541:proxy.knx.1_4_6.actuator.lamp-1"),
            ("Fridge No. 2.door", "6541:proxy.knx.1_4_7.sensor.contact-door"),
            ("kitchen.temperature", "6541:proxy.log-flat.kitchen.sensor.temperature-1"),
            ("Kitchen.lamp-1", "6541:proxy.knx.1_4_6.actuator.lamp-1"),
            ("10.out", "7:proxy.wsn-1.10.sensor.temperature-out"),
            ("living.led-1", "7:proxy.wsn-1.kitchen2.actuator.led-1"),
            ("HOME:Living room.lamp-1", "6541:proxy.dummy-rooms.living.actuator.lamp-1"),
            ("Hut:9.temperature", "7:proxy.wsn-1.9.sensor.temperature-1"),
        ):
            with self.subTest(text):
                self.assertEqual([":".join(one) for one in points_called(HOUSE, ISLANDS, text, False)], [key])

    def test_several_or_none(self):
        self.assertEqual(len(points_called(HOUSE, ISLANDS, "Mote.temperature-1", False)), 2)
        self.assertEqual(len(points_called(HOUSE, ISLANDS, "10.temperature", False)), 2)
        for text in ("", ".", "living", "living.", "living.foo", "7:living.lamp-1", "hut:9.temperature", "living.1",
                     "0x01.light-1", "Living room.z*"):
            with self.subTest(text):
                self.assertEqual(points_called(HOUSE, ISLANDS, text, False), [])
        self.assertEqual(points_called(HOUSE, ISLANDS, "kitchen.temperature", True), [])

    def test_a_device_is_called_by_key_then_by_name_then_by_its_room(self):
        for text, ids in (("living", ["living"]), ("Living Room", ["living"]), ("1.4.6", ["1_4_6"]), ("mote", ["9", "10"]),
                          ("attic", ["9", "10"]), ("Küche: Decke", ["1_4_6"]), ("6541:Mote", []), ("", [])):
            with self.subTest(text):
                self.assertEqual([one.id for one in devices_called(HOUSE, ISLANDS, text)], ids)

    def test_what_is_neither_name_nor_key_is_seen(self):
        for text in ("Küche.lamp-1", "a b", "x"):
            self.assertTrue(is_like_name(text), text)
        for text in ("", ".a", "a.", "a..b", "a\nb"):
            self.assertFalse(is_like_name(text), text)


class Names(unittest.TestCase):
    def test_an_owner_stands_in_front(self):
        self.assertEqual(split_owner("6541:proxy.x"), ("6541", "proxy.x"))
        self.assertEqual(split_owner("home:living.*"), ("home", "living.*"))
        self.assertEqual(split_owner("*:proxy.**"), ("", "proxy.**"))
        self.assertEqual(split_owner("living.lamp-1"), ("", "living.lamp-1"))

    def test_what_is_no_name_is_refused(self):
        for name in ("", ":a", "6541:", "a b", "a..b", "a.ü", "a.b.", "*:"):
            with self.subTest(name), self.assertRaises(Error) as caught:
                split_owner(name)
            self.assertEqual(caught.exception.code, "invalid")

    def test_short_patterns_become_those_of_points(self):
        for name, key in (
            ("living.light-1", "*.*.living.*.light-1.value"),
            ("dummy-rooms.*.light-1", "*.dummy-rooms.*.*.light-1.value"),
            ("proxy.*.*.sensor.light-1", "proxy.*.*.sensor.light-1.value"),
            ("proxy.*.*.sensor.*.value", "proxy.*.*.sensor.*.value"),
            ("proxy.wsn-1.**", "proxy.wsn-1.**"),
            ("proxy.*.status", "proxy.*.status"),
            ("proxy.island", "proxy.island"),
        ):
            with self.subTest(name):
                self.assertEqual(query_of(name), (key, None))

    def test_wildcards_within_parts_are_sorted_out_here(self):
        query = query_of("proxy.*.l?ving.sensor.temperature-*.value")
        self.assertEqual(query.key, "proxy.*.*.sensor.*.value")
        self.assertTrue(query.means("proxy.a.living.sensor.temperature-bed.value"))
        self.assertFalse(query.means("proxy.a.living.sensor.light-1.value"))
        self.assertFalse(query.means("proxy.a.living.x.sensor.temperature-1.value"))
        self.assertTrue(query_of("a-*.**").means("a-1.b.c"))

    def test_errors_name_candidates(self):
        error = not_found("device", "livng", ["living", "bedroom", "Living room"])
        self.assertEqual(error.candidates[0], "living")
        self.assertIn("did you mean living", str(error))
        self.assertEqual(str(not_found("device", "xyz", ["living"])), "not-found: no device 'xyz'")
        many = ambiguous("tuple", "a.b", [f"{one}:x" for one in range(10, 22)])
        self.assertEqual(len(many.candidates), 12)
        self.assertIn("and 4 more", many.text)


if __name__ == "__main__":
    unittest.main()
