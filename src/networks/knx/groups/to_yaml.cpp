#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "base/text.h"
#include "networks/knx/groups/encoding.h"
#include "networks/knx/groups/group_file.h"

namespace rubicon::networks::knx::groups {

namespace {

/// Characters beyond ASCII that YAML treats as line breaks, controls or marks (YAML 1.2, 5.1 and 5.4), and their
/// escapes in quotes.
struct Escape {
  std::string_view bytes, text;
};
constexpr std::array kEscapes{Escape{"\xe2\x80\xa8", "\\u2028"}, Escape{"\xe2\x80\xa9", "\\u2029"},
                              Escape{"\xef\xbb\xbf", "\\ufeff"}, Escape{"\xef\xbf\xbe", "\\ufffe"},
                              Escape{"\xef\xbf\xbf", "\\uffff"}};

bool needs_escape(std::string_view text) {
  const auto c1 = [&](std::size_t i) { return text[i] == '\xc2' && static_cast<unsigned char>(text[i + 1]) < 0xa0; };
  for (std::size_t i = 0; i + 1 < text.size(); ++i) {
    if (c1(i)) return true;
  }
  return std::any_of(kEscapes.begin(), kEscapes.end(),
                     [&](const Escape& escape) { return text.find(escape.bytes) != text.npos; });
}

bool is_reserved(std::string_view text) {
  static constexpr std::array<std::string_view, 10> kWords{"true", "false", "yes", "no", "on",
                                                           "off",  "null",  "y",   "n",  "nan"};
  return std::find(kWords.begin(), kWords.end(), to_lower(text)) != kWords.end();
}

/// True for text that needs no quotes, also between `{` and `}`.
bool is_plain(std::string_view text) {
  if (text.empty() || text.back() == ' ' || is_reserved(text)) return false;
  const auto letter = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || static_cast<unsigned char>(c) >= 0x80;
  };
  if (!letter(text.front())) return false;
  return std::all_of(text.begin(), text.end(), [&](char c) {
    return letter(c) || (c >= '0' && c <= '9') || std::string_view(" _./()+%-").find(c) != std::string_view::npos;
  });
}

std::string yaml_quoted(std::string_view text) {
  std::string out = "\"";
  while (!text.empty()) {
    const auto byte = static_cast<unsigned char>(text.front());
    const auto* escape = std::find_if(kEscapes.begin(), kEscapes.end(),
                                      [&](const Escape& entry) { return text.starts_with(entry.bytes); });
    std::size_t taken = 1;
    if (escape != kEscapes.end()) {
      out += escape->text;
      taken = escape->bytes.size();
    } else if (byte == 0xc2 && text.size() > 1 && static_cast<unsigned char>(text[1]) < 0xa0) {
      out += fmt::format("\\x{:02x}", static_cast<unsigned char>(text[1]));
      taken = 2;
    } else if (byte == '\n') {
      out += "\\n";
    } else if (byte < 0x20 || byte == 0x7f) {
      out += fmt::format("\\x{:02x}", byte);
    } else {
      if (byte == '"' || byte == '\\') out += '\\';
      out += text.front();
    }
    text.remove_prefix(taken);
  }
  return out + '"';
}

std::string scalar(std::string_view text) {
  const auto utf8 = base::is_utf8(text) ? std::string(text) : from_windows_1252(text);
  return is_plain(utf8) && !needs_escape(utf8) ? utf8 : yaml_quoted(utf8);
}

/// Names of groups that all or most of their points share: written once, not at each point.
class GroupNames {
 public:
  explicit GroupNames(const std::vector<const GroupPoint*>& points) {
    for (const auto* point : points) {
      names_.try_emplace(main_key(*point), point->main_group);
      names_.try_emplace(middle_key(*point), point->middle_group);
    }
  }

  const std::string& main(const GroupPoint& point) const { return names_.at(main_key(point)); }
  const std::string& middle(const GroupPoint& point) const { return names_.at(middle_key(point)); }

  std::string text() const {
    std::string out;
    for (const auto& [key, name] : names_) {
      const auto middle = key.second < 0 ? std::string() : fmt::format("/{}", key.second);
      if (!name.empty()) out += fmt::format("  {}{}: {}\n", key.first, middle, scalar(name));
    }
    return out.empty() ? out : "group-names:\n" + out;
  }

 private:
  using Key = std::pair<int, int>;  ///< main, middle; -1 = none
  static Key main_key(const GroupPoint& point) { return {number(point.address) >> 11, -1}; }
  static Key middle_key(const GroupPoint& point) {
    return {number(point.address) >> 11, number(point.address) >> 8 & 7};
  }

  std::map<Key, std::string> names_;
};

std::string list_text(const std::vector<wire::GroupAddress>& addresses, wire::Notation notation) {
  std::string out;
  for (const auto address : addresses)
    out += fmt::format("{}{}", out.empty() ? "" : ", ", to_string(address, notation));
  return "[" + out + "]";
}

std::string scenes_text(const SceneNames& names) {
  std::string out;
  for (const auto& [number, name] : names)
    out += fmt::format("{}{}: {}", out.empty() ? "" : ", ", number, scalar(name));
  return "{" + out + "}";
}

std::string line_of(const GroupPoint& point, const GroupNames& names, wire::Notation notation) {
  std::string out;
  const auto put = [&](std::string_view key, const std::string& value) {
    out += fmt::format("{}{}: {}", out.empty() ? "" : ", ", key, value);
  };
  if (point.dpt) put("dpt", to_string(*point.dpt));
  put("kind", std::string(to_string(point.kind)));
  if (point.state) put("state", to_string(*point.state, notation));
  if (!point.state_name.empty()) put("state-name", scalar(point.state_name));
  if (!point.listen.empty()) put("listen", list_text(point.listen, notation));
  if (!point.device.empty()) put("device", scalar(point.device));
  if (!point.device_name.empty()) put("device-name", scalar(point.device_name));
  if (point.instance != "1") put("instance", scalar(point.instance));
  if (point.read != ReadRule{}) put("read", to_string(point.read));
  if (point.scenes) put("scenes", scenes_text(*point.scenes));
  if (!point.name.empty()) put("name", scalar(point.name));
  if (!point.description.empty()) put("description", scalar(point.description));
  if (!point.room.empty()) put("room", scalar(point.room));
  if (point.main_group != names.main(point)) put("main", scalar(point.main_group));
  if (point.middle_group != names.middle(point)) put("middle", scalar(point.middle_group));
  return fmt::format("  {}: {{{}}}\n", to_string(point.address, notation), out);
}

/// `secured-groups: [1/2/7, 1/2/8]`, some addresses a line.
std::string secured_text(const std::vector<wire::GroupAddress>& secured, wire::Notation notation) {
  constexpr std::size_t kInLine = 10;
  std::string out;
  for (std::size_t i = 0; i < secured.size(); ++i)
    out += fmt::format("{}{}", i == 0 ? "" : i % kInLine == 0 ? ",\n  " : ", ", to_string(secured[i], notation));
  return out.empty() ? out : fmt::format("secured-groups: [{}]\n", out);
}

std::string comment(std::string_view text) {
  std::string out;
  for (const char c : clean_text(text, 200)) out += c == '\n' ? ' ' : c;
  return needs_escape(out) || !base::is_utf8(out) ? scalar(out) : out;
}

}  // namespace

std::string to_string(const ReadRule& rule) {
  using When = ReadRule::When;
  if (rule.when == When::kDemand) return "demand";
  if (rule.when == When::kInit) return "init";
  if (rule.when == When::kNever) return "never";
  struct Unit {
    Duration length;
    std::string_view name;
  };
  static constexpr std::array kUnits{Unit{std::chrono::hours(1), "h"}, Unit{std::chrono::minutes(1), "min"},
                                     Unit{std::chrono::seconds(1), "s"}, Unit{std::chrono::milliseconds(1), "ms"},
                                     Unit{std::chrono::microseconds(1), "us"}};
  const auto* unit = std::find_if(kUnits.begin(), kUnits.end() - 1,
                                  [&](const Unit& each) { return rule.period % each.length == Duration{}; });
  return fmt::format("{} {}{}", rule.when == When::kEvery ? "every" : "expire", rule.period / unit->length, unit->name);
}

std::string to_yaml(const std::vector<GroupPoint>& points, const std::string& source,
                    const std::vector<wire::GroupAddress>& secured, wire::Notation notation) {
  std::vector<const GroupPoint*> sorted;
  sorted.reserve(points.size());
  for (const auto& point : points) sorted.push_back(&point);
  std::stable_sort(sorted.begin(), sorted.end(), [](const auto* a, const auto* b) { return a->address < b->address; });
  const GroupNames names(sorted);
  auto out = fmt::format(
      "# {} KNX points from {}. Ids, kinds, types and state addresses of this file are kept:\n"
      "# `rubicon knx import FILE --merge THIS` only adds and renames.\n",
      points.size(), comment(source));
  if (notation != wire::Notation::kThreeLevel)
    out += fmt::format("notation: {}\n", notation == wire::Notation::kTwoLevel ? "two-level" : "free");
  out += names.text();
  out += secured_text(secured, notation);
  out += points.empty() ? "groups: {}\n" : "groups:\n";
  for (const auto* point : sorted) out += line_of(*point, names, notation);
  return out;
}

}  // namespace rubicon::networks::knx::groups
