#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace rubicon::bridges::mqtt {

/// One point of a database.
struct Metric {
  std::string name;
  std::map<std::string, std::string> tags;
  std::map<std::string, double> fields;
  double time = 0;  ///< s since 1970
};

/// Reads messages as Telegraf does with a configuration of `inputs.mqtt_consumer` and `data_format = "json"`. Source:
/// the documentation of that plugin and of its JSON parser: numbers and booleans are fields, texts are none unless
/// `json_string_fields` names them, null is nothing, what `tag_keys` names is a tag; without a field there is no
/// metric.
class Telegraf {
 public:
  explicit Telegraf(const std::string& configuration) {
    std::istringstream lines(configuration);
    auto* section = &consumer_;
    for (std::string line; std::getline(lines, line);) {
      const auto text = line.substr(std::min(line.find_first_not_of(' '), line.size()));
      if (text.empty() || text.starts_with('#')) continue;
      if (text.starts_with('[')) {
        EXPECT_TRUE(text == "[[inputs.mqtt_consumer]]" || text == "[[inputs.mqtt_consumer.topic_parsing]]") << text;
        section = text.find("topic_parsing") == text.npos ? &consumer_ : &parsing_;
        continue;
      }
      const auto equals = text.find(" = ");
      if (equals == text.npos) throw std::runtime_error(text);
      EXPECT_TRUE(known_.contains(text.substr(0, equals))) << text;
      (*section)[text.substr(0, equals)] = nlohmann::json::parse(text.substr(equals + 3));
    }
    EXPECT_EQ(consumer_.value("data_format", ""), "json");
    EXPECT_EQ(consumer_.value("json_time_format", ""), "unix");
  }

  std::vector<std::string> topics() const { return consumer_.at("topics"); }

  /// nullopt: no metric, or an error (a test failure).
  std::optional<Metric> take(const std::string& topic, std::string_view payload) const {
    const auto json = nlohmann::json::parse(payload, nullptr, false);
    const auto time_key = consumer_.at("json_time_key").get<std::string>();
    if (!json.is_object() || !json.contains(time_key) || !json[time_key].is_number()) {
      ADD_FAILURE() << topic << ": " << payload;
      return std::nullopt;
    }
    Metric metric{consumer_.value("name_override", "mqtt_consumer"), {}, {}, json[time_key].get<double>()};
    for (const auto& [key, value] : json.items()) {
      const auto& tags = consumer_.at("tag_keys");
      if (key == time_key) continue;
      if (std::find(tags.begin(), tags.end(), key) != tags.end())
        metric.tags[key] = value.is_string() ? value.get<std::string>() : value.dump();
      else if (value.is_number())
        metric.fields[key] = value.get<double>();
      else if (value.is_boolean())
        metric.fields[key] = value.get<bool>() ? 1 : 0;
    }
    const auto names = levels(parsing_.at("tags")), parts = levels(topic);
    if (names.size() != parts.size()) ADD_FAILURE() << topic;
    for (std::size_t i = 0; i < std::min(names.size(), parts.size()); ++i)
      if (names[i] != "_") metric.tags[names[i]] = parts[i];
    return metric.fields.empty() ? std::nullopt : std::optional(metric);
  }

 private:
  static std::vector<std::string> levels(const std::string& text) {
    std::vector<std::string> all;
    std::istringstream stream(text);
    for (std::string level; std::getline(stream, level, '/');) all.push_back(level);
    return all;
  }

  const std::set<std::string> known_{"servers",       "topics",           "topic_tag", "name_override", "data_format",
                                     "json_time_key", "json_time_format", "tag_keys",  "topic",         "tags"};
  nlohmann::json consumer_, parsing_;
};

}  // namespace rubicon::bridges::mqtt
