#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <string_view>
#include <vector>

namespace rubicon::zigbee_simulator {

/// Random numbers that are the same for the same seed on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  /// 0 to `below` - 1; 0 if `below` is 0.
  std::uint64_t below(std::uint64_t below) { return below == 0 ? 0 : engine_() % below; }
  /// `low` to `high`, both included.
  std::int64_t between(std::int64_t low, std::int64_t high) {
    return low + static_cast<std::int64_t>(below(static_cast<std::uint64_t>(high - low) + 1));
  }
  /// 0 to 1.
  double share() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  /// True so many times in a thousand.
  bool chance(std::uint64_t per_mille) { return below(1000) < per_mille; }

  template <class List>
  const auto& one_of(const List& list) {
    return list[below(list.size())];
  }
  /// The index of a weight, as often as the weight says.
  template <std::size_t Count>
  std::size_t weighted(const std::array<int, Count>& weights) {
    int sum = 0;
    for (const int weight : weights) sum += weight;
    auto drawn = between(1, sum);
    std::size_t index = 0;
    while ((drawn -= weights[index]) > 0) ++index;
    return index;
  }

 private:
  std::mt19937_64 engine_;
};

/// The leaves of an `exposes` array in their order, groups flattened; a composite or a list is one leaf. Other entries
/// are left out.
std::vector<nlohmann::json> leaves_of(const nlohmann::json& exposes);

/// Random definitions over the whole grammar of `exposes` (zigbee.md, section 3.1), about as frequent as in
/// Zigbee2MQTT's converter library (section 10), with all its oddities: binaries of strings, booleans and numbers,
/// enumerations of integers, presets that are null, two leaves on one property, composites in composites, lists whose
/// items have no property, properties with a space, fractions as bounds, very long names, unknown units, access 0.
/// The same seed gives the same definitions.
class DefinitionGenerator {
 public:
  explicit DefinitionGenerator(std::uint64_t seed);

  /// An `exposes` array; sometimes empty, at most 276 leaves.
  nlohmann::json exposes();
  /// A leaf that stands alone.
  nlohmann::json leaf();
  /// A record of `bridge/devices`. `index` makes its address, which begins at 0x00124b0020000000, and its friendly name
  /// unique. Most are interviewed and supported.
  nlohmann::json device_record(std::uint32_t index);

  /// A value that a device could report for this leaf, or that may be set: within bounds, in steps, one of the words.
  nlohmann::json value_of(const nlohmann::json& leaf);
  /// A state message: a value for each property that is published, rarely null, and `linkquality`.
  nlohmann::json state_of(const nlohmann::json& exposes);

 private:
  using Json = nlohmann::json;

  void begin_definition();
  Json numeric(std::string_view name = {});
  Json binary(std::string_view name = {});
  Json enumeration(std::string_view name = {});
  Json text();
  Json list(int depth);
  Json composite(int depth);
  Json any_leaf(int depth);
  Json common(std::string_view type, std::string name);
  void name_endpoint(Json& leaf);
  void add_range(Json& leaf);
  void add_presets(Json& leaf);
  std::string made_name();
  template <class Names>
  std::string name_from(const Names& names);

  Json group(std::string_view type);
  Json light();
  Json climate();
  Json cover();
  Json lock();
  Json fan();
  Json settable(Json leaf, int access = 7);
  Json expose();
  Json definition();
  Json options();

  Random random_;
  std::vector<std::string> endpoints_;  ///< of the present definition
  std::string endpoint_;                ///< of the present group; empty = none
};

}  // namespace rubicon::zigbee_simulator
