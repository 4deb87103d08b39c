#pragma once

#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "client/tuple_query.h"

namespace rubicon::web::api {

/// Collects samples and writes them in the Prometheus text format 0.0.4: each metric once, with its type, the samples
/// behind it.
class MetricsText {
 public:
  using Labels = std::vector<std::pair<std::string_view, std::string>>;

  /// `name` may hold any characters; those that a metric may not become `_`.
  void add(std::string_view name, std::string_view type, const Labels& labels, std::string_view number);
  std::string text() const;

 private:
  struct Metric {
    std::string type;
    std::vector<std::string> samples;
  };
  std::map<std::string, Metric> metrics_;
};

/// What the tuples of islands say: lines, devices by status, and counters (docs/api.md).
void add_island_metrics(const std::vector<client::Tuple>& tuples, MetricsText& text);

}  // namespace rubicon::web::api
