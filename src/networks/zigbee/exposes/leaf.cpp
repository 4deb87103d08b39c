#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "model/json_members.h"
#include "model/json_text.h"
#include "networks/zigbee/exposes/leaf.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::zigbee::exposes {

namespace {

using Tree = nlohmann::json;

constexpr std::size_t kMaxTextCount = std::size_t{1} << 20;  ///< bytes of an `exposes` array
constexpr std::size_t kMaxLeaves = 512;  ///< of a definition, parts of composites included (276 seen)
constexpr std::size_t kMaxWords = 4096;  ///< of one enumeration (800 seen)
constexpr std::size_t kMaxTextLength = 512;
constexpr std::size_t kMaxSkipped = 100;

struct Placed {
  std::string_view group, endpoint;
};

std::optional<double> number_in(const Tree& tree, const char* name) {
  const auto found = tree.find(name);
  if (found == tree.end() || !found->is_number()) return std::nullopt;
  const auto number = found->get<double>();
  return std::isfinite(number) ? std::optional(number) : std::nullopt;
}

/// Endpoints are words or numbers.
std::string endpoint_in(const Tree& tree, std::string_view of_group) {
  const auto found = tree.find("endpoint");
  if (found == tree.end() || found->is_null()) return std::string(of_group);
  return found->is_string() ? found->get<std::string>() : model::dump(*found);
}

/// A value of any scalar kind; its name is the text of a string, else the JSON. Empty if it is not a scalar or too
/// long.
NamedValue value_in(const Tree& value) {
  if (!value.is_primitive()) return {};
  const auto* text = value.get_ptr<const std::string*>();
  if (text != nullptr && text->size() > kMaxTextLength) return {};
  const auto json = model::dump(value);
  return {text != nullptr ? *text : json, json};
}

std::optional<LeafForm> form_of(const std::string& type) {
  if (type == "numeric") return LeafForm::kNumeric;
  if (type == "binary") return LeafForm::kBinary;
  if (type == "enum") return LeafForm::kEnum;
  if (type == "text") return LeafForm::kText;
  if (type == "list") return LeafForm::kList;
  if (type == "composite") return LeafForm::kComposite;
  return std::nullopt;
}

class Reader {
 public:
  explicit Reader(std::vector<std::string>& skipped) : skipped_(skipped) {}

  void read(const Tree& expose, const Placed& place, std::vector<Leaf>& out) {
    if (!expose.is_object()) return skip("an entry", "it is not an object");
    const auto type = model::text_of(expose, "type");
    const auto form = form_of(type);
    if (form) return read_leaf(expose, *form, place, out, true);
    const auto features = expose.find("features");
    if (features == expose.end() || !features->is_array()) {
      return skip(model::text_of(expose, "name"), fmt::format("unknown type {}", model::quoted(type)));
    }
    const auto endpoint = endpoint_in(expose, place.endpoint);
    if (type.size() > kMaxTextLength || endpoint.size() > kMaxTextLength)
      return skip("a group", "its name is too long");
    for (const auto& feature : *features) read(feature, {type, endpoint}, out);
  }

 private:
  void skip(std::string_view what, std::string_view why) {
    if (skipped_.size() < kMaxSkipped) skipped_.push_back(fmt::format("{}: {}", model::quoted(what), why));
  }

  /// `whole`: a leaf of its own; else a part of one, which needs no property and no access.
  void read_leaf(const Tree& tree, LeafForm form, const Placed& place, std::vector<Leaf>& out, bool whole) {
    Leaf leaf;
    leaf.form = form;
    leaf.group = place.group;
    leaf.name = model::text_of(tree, "name");
    leaf.property = model::text_of(tree, "property");
    leaf.endpoint = endpoint_in(tree, place.endpoint);
    if (leaf.name.empty()) leaf.name = leaf.property;
    read_access(tree, leaf);
    if (const auto why = unusable(leaf, whole); !why.empty()) return skip(leaf.name, why);
    if (++count_ > kMaxLeaves) return skip(leaf.name, "the definition has too many leaves");
    leaf.label = short_text(tree, "label");
    leaf.unit = short_text(tree, "unit");
    const auto category = model::text_of(tree, "category");
    if (category == "config") leaf.category = Category::kConfig;
    if (category == "diagnostic") leaf.category = Category::kDiagnostic;
    read_form(tree, leaf);
    if (form == LeafForm::kBinary && (leaf.on.json.empty() || leaf.off.json.empty()))
      return skip(leaf.name, "value_on or value_off is too long or not a scalar");
    out.push_back(std::move(leaf));
  }

  static std::string unusable(const Leaf& leaf, bool whole) {
    if (leaf.name.size() > kMaxTextLength || leaf.property.size() > kMaxTextLength ||
        leaf.endpoint.size() > kMaxTextLength)
      return "its name is too long";
    if (!whole) return "";
    if (leaf.property.empty()) return "it has no property";
    if (leaf.access == LeafAccess{}) return "it has access 0";
    return "";
  }

  static void read_access(const Tree& tree, Leaf& leaf) {
    const auto bits = model::count_of(tree, "access");
    leaf.access = {(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0};
  }

  static std::string short_text(const Tree& tree, const char* name) {
    auto text = model::text_of(tree, name);
    return text.size() > kMaxTextLength ? std::string() : text;
  }

  void read_form(const Tree& tree, Leaf& leaf) {
    switch (leaf.form) {
      case LeafForm::kNumeric: return read_numeric(tree, leaf);
      case LeafForm::kBinary:
        leaf.on = {"true", "true"};
        leaf.off = {"false", "false"};
        if (const auto on = tree.find("value_on"); on != tree.end()) leaf.on = value_in(*on);
        if (const auto off = tree.find("value_off"); off != tree.end()) leaf.off = value_in(*off);
        return;
      case LeafForm::kEnum: return read_words(tree, leaf);
      case LeafForm::kText: return;
      case LeafForm::kList:
        if (const auto item = tree.find("item_type"); item != tree.end()) read_part(*item, leaf);
        return;
      case LeafForm::kComposite:
        if (const auto features = tree.find("features"); features != tree.end() && features->is_array()) {
          for (const auto& feature : *features) read_part(feature, leaf);
        }
    }
  }

  static void read_numeric(const Tree& tree, Leaf& leaf) {
    leaf.minimum = number_in(tree, "value_min");
    leaf.maximum = number_in(tree, "value_max");
    leaf.step = number_in(tree, "value_step");
    if (leaf.minimum && leaf.maximum && *leaf.minimum > *leaf.maximum) std::swap(leaf.minimum, leaf.maximum);
    if (leaf.step && *leaf.step <= 0) leaf.step.reset();
    const auto presets = tree.find("presets");
    if (presets == tree.end() || !presets->is_array()) return;
    for (const auto& preset : *presets) {
      const auto value = preset.is_object() ? preset.find("value") : preset.end();
      auto json = value == preset.end() ? std::string() : value_in(*value).json;
      if (leaf.values.size() >= kMaxWords || json.empty()) continue;
      leaf.values.push_back({short_text(preset, "name"), std::move(json)});
    }
  }

  void read_words(const Tree& tree, Leaf& leaf) {
    const auto values = tree.find("values");
    if (values == tree.end() || !values->is_array()) return;
    for (const auto& value : *values) {
      auto word = value_in(value);
      if (leaf.values.size() >= kMaxWords || word.json.empty()) {
        skip(leaf.name, fmt::format("a word is too long, not a scalar, or beyond {} words", kMaxWords));
        continue;
      }
      leaf.values.push_back(std::move(word));
    }
  }

  /// Parts describe a structured value; those that cannot be read are left out.
  void read_part(const Tree& tree, Leaf& leaf) {
    if (!tree.is_object()) return;
    const auto form = form_of(model::text_of(tree, "type"));
    if (form) read_leaf(tree, *form, {}, leaf.features, false);
  }

  std::vector<std::string>& skipped_;
  std::size_t count_ = 0;
};

}  // namespace

Result<std::vector<Leaf>> read_exposes(std::string_view json, std::vector<std::string>& skipped) {
  if (json.size() > kMaxTextCount) return fail(ErrorCode::kInvalid, fmt::format("exposes of {} bytes", json.size()));
  if (base::is_nested_deeper(json, kDeepestJson))
    return fail(ErrorCode::kInvalid, fmt::format("exposes: nested more than {} times", kDeepestJson));
  const auto tree = model::parse_json(json);
  if (!tree.is_array()) return fail(ErrorCode::kInvalid, "exposes: expected a JSON array");
  std::vector<Leaf> leaves;
  Reader reader(skipped);
  for (const auto& expose : tree) reader.read(expose, {}, leaves);
  return leaves;
}

}  // namespace rubicon::networks::zigbee::exposes
