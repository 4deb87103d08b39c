#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/client.hpp"

namespace rubicon::cli {

class Session;

/// `--island ISLAND`: the island that a command is about, by its id or its name.
class IslandOption {
 public:
  CLI::Option* add_to(CLI::App* app, const std::string& about = "of this island: id or name");
  /// Finds the island that was named: kGood, or the exit code after the error was printed.
  int find(Session& session);
  /// The same; the island may also stand in front of the network, as lists write it: `6541:wsn-1`, `home:wsn-1`. Leaves
  /// `wsn-1` in `network`.
  int find(Session& session, std::string& network);
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

}  // namespace rubicon::cli
