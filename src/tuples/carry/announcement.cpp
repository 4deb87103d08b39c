#include "tuples/carry/announcement.h"

#include <algorithm>

#include "model/json_members.h"
#include "rubicon/summary.hpp"

namespace rubicon::tuples::carry {

namespace {

constexpr const char* kMember = "carries";
constexpr std::size_t kMaxPairs = 16;

}  // namespace

std::string pair_name(std::string_view one, std::string_view other) {
  const auto [first, second] = std::minmax(one, other);
  return std::string(first) + "-" + std::string(second);
}

std::string with_announcement(std::string summary, const Announcement& carries) {
  auto text = summary.empty() ? std::string("{}") : summary;
  if (carries.empty() || text.back() != '}') return summary;
  text.pop_back();
  if (text != "{") text += ',';
  text += '"' + std::string(kMember) + "\":" + model::dump(nlohmann::json(carries)) + '}';
  return text.size() <= kMaxSummary ? text : summary;
}

Announcement announcement_of(std::string_view summary) {
  Announcement all;
  if (summary.find(kMember) == summary.npos) return all;
  const auto object = model::object_of(summary);
  const auto found = object.find(kMember);
  if (found == object.end() || !found->is_object()) return all;
  for (const auto& [pair, digest] : found->items()) {
    if (digest.is_string() && all.size() < kMaxPairs) all.emplace(pair, digest.get<std::string>());
  }
  return all;
}

}  // namespace rubicon::tuples::carry
