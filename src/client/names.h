#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rubicon/client.hpp"

// What people call devices and points (docs/cli.md#names-of-tuples). No function here asks anybody.
namespace rubicon::client {

struct IslandName {
  OwnerId id{};
  std::string name;
  std::string prefix = "proxy";  ///< of its keys
};

/// What names may stand for.
struct KnownNames {
  std::vector<Device> devices{};
  std::vector<IslandName> islands{};
  std::map<std::pair<OwnerId, std::string>, std::string> points{};  ///< names of points, by their keys
};
/// Adds the names of points that a tuple `<prefix>.overview` keeps (docs/tuple-keys.md).
void add_point_names(OwnerId island, std::string_view key, std::string_view overview, KnownNames& names);
/// What people call a point; empty: it has no name of its own.
std::string name_of_point(const KnownNames& names, OwnerId island, const std::string& key);

/// What people call the device or point that a key belongs to, with the island in front (`6541:proxy.wsn-1.7.status`):
/// `Kitchen mote`, `Kitchen mote, Window light`; empty where they have no names.
std::string name_of(const KnownNames& names, std::string_view key);

/// A text without the island in front of it.
struct OfIslands {
  std::vector<OwnerId> islands;  ///< those that it may be; empty = any
  std::string_view before;       ///< `home:`; empty = none was named
  std::string_view rest;

  bool fit(OwnerId island) const;
};
/// What stands before the first colon is an island if it is `*`, an id, or the name of one; else the colon belongs to
/// the rest. Names are compared exactly first, then without case, here as everywhere below.
OfIslands take_islands(const std::vector<IslandName>& islands, std::string_view text);

/// The devices that `[ISLAND:]DEVICE` may mean: DEVICE is `living`, `dummy-rooms.living` or
/// `proxy.dummy-rooms.living`; if none of these fits, a name (`Living room`) or an address, and at last an area.
std::vector<Device> devices_called(const KnownNames& names, std::string_view text);

/// Which points of a device count.
enum class Among : std::uint8_t { kAll, kSettable };

/// The points that `[ISLAND:]DEVICE.POINT` may mean. POINT is an id (`lamp-1`), `*` and `?` within it as in shells, or
/// the name that people gave it (`Reading lamp`), or a type (`temperature`), or the name in an id (`door` of
/// `contact-door`). Where nothing is called so, the points that have the whole text as their name. The keys have five
/// parts; those of a POINT with `*` or `?` have `*` for the kind, and POINT as it is. Of a device, kSettable leaves out
/// the sensors; whether a property can be set only its tuples tell. With kSettable only the devices that DEVICE names
/// best count, even if none of them has the point; with kAll those that have it.
std::vector<Pattern> points_called(const KnownNames& names, std::string_view text, Among among);

/// Whether a text that names nothing may have been meant as a name; false: it is neither that nor a key.
bool is_like_name(std::string_view text);

/// What may have been meant by a text that names no point, as people would type it: nearest first, at most three, never
/// the text itself.
std::vector<std::string> near_points(const KnownNames& names, std::string_view text, Among among);

}  // namespace rubicon::client
