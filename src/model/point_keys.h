#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "model/type_catalogue.h"

// The keys of an island's tuples (docs/tuple-keys.md), built and taken apart in one place. Any part may be `*`: the key
// is then that of a pattern. `IslandKey{"*"}.network("*").device("*").status()` is `*.*.*.status`.
namespace rubicon::model {

/// A sensor, actuator or property: `proxy.wsn-1.7.sensor.light-1`.
struct PointKey {
  std::string text;

  std::string value() const { return text + ".value"; }
  std::string status() const { return text + ".status"; }
  std::string command() const { return text + ".command"; }
  std::string description() const { return text + ".description"; }
};

/// `proxy.wsn-1.7`
struct DeviceKey {
  std::string text;

  std::string status() const { return text + ".status"; }
  std::string description() const { return text + ".description"; }
  /// `kind` is sensor, actuator, property or `*`.
  PointKey point(std::string_view kind, std::string_view id) const;
  PointKey point(Kind kind, std::string_view id) const { return point(to_string(kind), id); }
};

/// `proxy.wsn-1`
struct NetworkKey {
  std::string text;

  std::string status() const { return text + ".status"; }
  std::string devices() const { return text + ".devices"; }
  /// The value of one of its counters and texts.
  std::string property(std::string_view name) const;
  /// One of its properties that users may set.
  PointKey control(std::string_view name) const;
  /// The state of its line, and the command `reopen`.
  PointKey line() const { return control("line"); }
  DeviceKey device(std::string_view id) const;
};

/// The prefix of the keys of an island: `proxy`.
struct IslandKey {
  std::string text;

  std::string island() const { return text + ".island"; }
  std::string islands() const { return text + ".islands"; }
  std::string networks() const { return text + ".networks"; }
  std::string devices() const { return text + ".devices"; }
  std::string inbox() const { return text + ".inbox"; }
  /// A device that waits in the inbox; `device` is `<network>.<address>` as key parts.
  std::string inbox(std::string_view device) const;
  /// The value of one of the island's own numbers and texts.
  std::string property(std::string_view name) const;
  /// The configuration in force, and the commands that read it again.
  PointKey settings() const { return {text + ".settings"}; }
  PointKey recorder(std::string_view name) const;
  /// What a bridge does.
  PointKey bridge(std::string_view name) const;
  /// What its history does.
  PointKey history() const { return {text + ".history"}; }
  /// What needs a person: model::AlertList.
  std::string alerts() const { return text + ".alerts"; }
  /// The last lines of the log.
  std::string log_lines() const { return text + ".log.lines"; }
  NetworkKey network(std::string_view id) const;
};

/// All points of all devices, of any kind: `*.*.*.*.*`.
PointKey any_point();

/// Parts behind the prefix that hold tuples of the island itself: no network has one of them as its id.
bool is_part_of_island(std::string_view part);
/// Whether the key lies in one of them: its status is neither that of a network nor that of a device.
bool is_of_island(std::string_view key);

/// Whether the key is the command of the line of a network: `proxy.wsn-1.property.line.command`.
bool is_line_command(std::string_view key);

/// `proxy.wsn-1.7.status` -> `proxy.wsn-1.7`; empty for a key of one part.
std::string_view parent_key(std::string_view key);
/// `proxy.wsn-1.7.status` -> `status`.
std::string_view last_part(std::string_view key);
/// The network in whose part of the tree a key lies; nullopt for a key of one part.
std::optional<NetworkKey> network_of(std::string_view key);
/// The point whose value, status, command or description has this key; nullopt for every other key.
std::optional<PointKey> point_of(std::string_view key);

}  // namespace rubicon::model
