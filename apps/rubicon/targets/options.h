#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/rubicon/session.h"
#include "client/names.h"
#include "client/target_search.h"
#include "rubicon/client.hpp"
#include "rubicon/time.hpp"

namespace rubicon::cli {

/// `--island ISLAND`: the island that a command is about, by its id or its name.
class IslandOption {
 public:
  CLI::Option* add_to(CLI::App* app, const std::string& about = "of this island: id or name");
  /// Finds the island that was named: kGood, or the exit code after the error was printed.
  int find(Session& session);
  /// The same; the island may also stand in front of the network, as lists write it: `6541:wsn-1`, `home:wsn-1`. Leaves
  /// `wsn-1` in `network`.
  int find(Session& session, std::string& network);
  /// Finds the island, and puts it in front of texts that name tuples or devices and no island.
  int put_before(Session& session, std::vector<std::string>& texts);
  int put_before(Session& session, std::string& text);
  /// The island that find() found; nullopt: none was named.
  std::optional<OwnerId> owner() const { return id_; }

 private:
  std::string word_;
  std::optional<OwnerId> id_;
};

/// Runs a command when its island was found, else returns the exit code of find().
int with_island(Session& session, IslandOption& island, const std::function<int()>& run);
int with_network(Session& session, IslandOption& island, std::string& network, const std::function<int()>& run);

/// The components that a word may mean: the one with this id, or all with this name.
std::vector<OwnerId> components_called(Session& session, std::string_view word);

/// A tuple, pattern or device with its island in front, by id (`6541:living.lamp-1`) in place of a name
/// (`home:living.lamp-1`). The same text where no island has that name.
std::string with_island_id(Session& session, std::string_view text);
std::vector<std::string> with_island_ids(Session& session, const std::vector<std::string>& texts);

// Points of the islands themselves, which take commands: settings, recorders, replays (docs/tuple-keys.md).

/// The only island that has a tuple under this key; otherwise the exit code after an error was printed. `what` names
/// the point in that error.
struct ChosenIsland {
  OwnerId id{};
  int code = kGood;
};
ChosenIsland choose_island(Session& session, const IslandOption& option, const std::string& key,
                           const std::string& what);

/// Sets a `.command` and prints the outcome: `done` on success, else state and reason on standard error. The exit code.
int command_island(Session& session, OwnerId island, const std::string& key, const std::string& text,
                   const std::string& done);

/// Options that select devices: --network, --type, --name, --area, --island.
class DeviceOptions {
 public:
  void add_to(CLI::App& app);
  /// Runs a command when the island was found that --island or --network names.
  int run(Session& session, const std::function<int(const client::DeviceQuery&)>& command);

 private:
  IslandOption island_;
  std::string network_, type_, name_, area_;
};

/// Islands whose names may stand in front of a colon.
std::vector<client::IslandName> known_islands(Session& session);
/// The same, if a name stands in front of a colon of this text; otherwise none, without a wait.
std::vector<client::IslandName> islands_for(Session& session, std::string_view text);
/// All devices and islands that are present, with what people call them and their points.
client::KnownNames known_names(Session& session);

/// Prints the devices that `word` may mean; returns kUsage.
int ambiguous(std::string_view word, const std::vector<client::Device>& candidates);

/// Finds the one device that `word` means: kGood, or an exit code after the error was printed.
int one_device(Session& session, std::string_view word, client::Device& device);
int one_device(Session& session, const client::KnownNames& names, std::string_view word, client::Device& device);

/// The error in the text of a time; empty if there is none.
std::string check_time(const std::string& text);
/// Adds an option whose value is a time: `now`, a span before it (`2h`), seconds since 1970, or `2026-01-31T12:00:00Z`.
CLI::Option* add_time_option(CLI::App* app, const std::string& name, std::string& text, const std::string& about);
/// The time in the text of such an option; nullopt for a text that it refuses.
std::optional<WallTime> time_in(const std::string& text, WallTime now);

}  // namespace rubicon::cli
