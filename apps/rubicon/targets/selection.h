#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "client/target_search.h"
#include "rubicon/client.hpp"

namespace rubicon::cli {

class Session;

using client::long_form;
using client::parse_target;
using client::Target;
using client::TypedTarget;

/// A name without wildcards as it was typed; the owner may be the name of an island.
Result<TypedTarget> parse_target(Session& session, std::string_view text);
/// The present tuples that a text may mean (client::TargetSearch). kInvalid: it is a pattern, or can name nothing.
Result<std::vector<Target>> targets_called(Session& session, std::string_view text, std::string_view last);

/// Prints the candidates; returns kUsage.
int ambiguous(std::string_view typed, const std::vector<Target>& candidates);

/// Which tuples a text on the command line means. Islands know `*` for whole parts only; a `*` or `?` within a part
/// (`contact-*`) is applied by this program.
struct Selection {
  Pattern pattern;   ///< what islands understand; matches at least the selection
  std::string text;  ///< as it was typed, or what it is short for; for messages
  /// Of each part of the pattern, `*` where all fit; empty = the pattern alone decides.
  std::vector<std::string> globs{};

  bool fits(OwnerId owner, std::string_view key) const;
  /// The pattern matches more than the selection.
  bool narrower() const { return !globs.empty(); }
};
using Selections = std::vector<Selection>;

/// The text itself, and what it may be short for (`living.lamp-1`, `1_0_7.*`: the `last` of points); both also under
/// the names that types have today (model/type_names.h). No tuple fits two of them.
Result<Selections> parse_selections(std::string_view text, std::string_view last);
/// The same of several texts; of `otherwise` when there are none.
Result<Selections> parse_selections(const std::vector<std::string>& texts, const std::string& otherwise,
                                    std::string_view last);

/// The same with the names of people: of a text that fits nothing present, the points that people call so. kGood, or
/// the exit code after the error was printed.
int selections_called(Session& session, const std::vector<std::string>& texts, std::string_view last,
                      Selections& selections);

bool any_fits(const Selections& selections, OwnerId owner, std::string_view key);

/// Waking the sensors of more devices than this prints a warning.
inline constexpr std::size_t kManyDevices = 20;

/// Devices with at least one selected sensor value.
std::size_t count_woken(const std::vector<client::Device>& devices, const Selections& selections);

/// Prints a warning in a later turn if the selections wake the sensors of more than kManyDevices devices.
void warn_if_many_wake(Client& client, const Selections& selections);

/// Active subscriptions to many single tuples. Bounded: an island accepts 10,000 subscriptions of one component.
class Wakers {
 public:
  static constexpr std::size_t kMaxCount = 9000;
  using Subscribe = std::function<Handle(const Pattern& exact)>;

  explicit Wakers(Subscribe subscribe, std::size_t most = kMaxCount) : subscribe_(std::move(subscribe)), most_(most) {}

  /// Subscribes to a tuple, once. The first tuple beyond the bound prints a warning.
  void wake(OwnerId owner, std::string_view key);
  void forget(OwnerId owner, std::string_view key);
  /// At least one tuple was not woken.
  bool full() const { return full_; }

 private:
  Subscribe subscribe_;
  std::size_t most_;
  bool full_ = false;
  std::map<std::pair<OwnerId, std::string>, Handle> handles_;
};

}  // namespace rubicon::cli
