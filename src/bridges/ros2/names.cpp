#include "bridges/ros2/names.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "rubicon/key.hpp"

namespace rubicon::bridges::ros2 {

namespace {

constexpr std::size_t kMaxRosName = 247;  // rmw/validate_full_topic_name.h
constexpr std::size_t kMaxInstance = 100, kMaxDevice = 60;
constexpr std::string_view kTopic = "rt/", kMiddle = "::msg::dds_::";

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

bool is_ros_token(std::string_view text) {
  const auto fits = [](char c) { return is_letter(c) || is_digit(c) || c == '_'; };
  return !text.empty() && !is_digit(text.front()) && std::all_of(text.begin(), text.end(), fits);
}

}  // namespace

std::string token(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const char next = is_letter(c) || is_digit(c) ? c : '_';
    if (next != '_' || out.empty() || out.back() != '_') out += next;
  }
  if (out.empty() || !is_letter(out.front())) out.insert(out.begin(), 'd');
  return out;
}

bool is_ros_name(std::string_view name) {
  if (name.size() > kMaxRosName || !name.starts_with('/')) return false;
  while (!name.empty()) {
    name.remove_prefix(1);
    const auto end = std::min(name.find('/'), name.size());
    if (!is_ros_token(name.substr(0, end))) return false;
    name.remove_prefix(end);
  }
  return true;
}

std::string ros_name(std::string_view name_space, std::string_view point_key) {
  const auto parts = model::key_parts(point_key);
  std::string name = "/" + token(name_space);
  for (std::size_t i = 1; i < parts.size(); ++i) {
    if (i != 3) name += "/" + token(parts[i]);
  }
  name.resize(std::min(name.size(), kMaxName));
  if (name.back() == '/') name.pop_back();
  return name;
}

std::string dds_topic(std::string_view ros_name) {
  return "rt" + std::string(ros_name);
}

std::optional<std::string> topic_of_dds(std::string_view topic) {
  if (!topic.starts_with(kTopic) || !is_ros_name(topic.substr(2))) return std::nullopt;
  return std::string(topic.substr(2));
}

std::optional<std::string> type_of_dds(std::string_view type) {
  const auto middle = type.find(kMiddle);
  if (middle == type.npos || !type.ends_with('_')) return std::nullopt;
  const auto package = type.substr(0, middle);
  auto name = type.substr(middle + kMiddle.size());
  name.remove_suffix(1);
  if (!is_ros_token(package) || !is_ros_token(name)) return std::nullopt;
  return fmt::format("{}/msg/{}", package, name);
}

ImportPlace import_place(std::string_view ros_name) {
  const auto name = ros_name.substr(std::min<std::size_t>(1, ros_name.size()));
  const auto slash = name.find('/');
  ImportPlace place{slash == name.npos ? "robot" : model::to_key_part(name.substr(0, slash), kMaxDevice),
                    model::to_key_part(slash == name.npos ? name : name.substr(slash + 1), kMaxInstance)};
  return place;
}

/// FNV-1a.
std::string distinct_name(std::string_view wanted, std::string_view id) {
  std::uint32_t hash = 2166136261U;
  for (const char c : id) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
  return fmt::format("{}_{:08x}", wanted, hash);
}

}  // namespace rubicon::bridges::ros2
