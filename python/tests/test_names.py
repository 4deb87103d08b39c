import unittest

from rubicon import Error
from rubicon._names import ambiguous, not_found, query_of, split_owner


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
