#include "config/site_types.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/text.h"

namespace rubicon::config {

namespace {

model::DataType data_type(ConfigReader& type) {
  using model::DataType;
  const auto word = type.choice("data", "real", {"boolean", "integer", "real", "enumeration", "text", "json", "bytes"});
  for (const auto data : {DataType::kBoolean, DataType::kInteger, DataType::kReal, DataType::kEnumeration,
                          DataType::kText, DataType::kJson, DataType::kBytes}) {
    if (to_string(data) == word) return data;
  }
  return DataType::kReal;
}

/// `id: 0x8001` or decimal.
std::uint16_t type_id(ConfigReader& type) {
  const auto text = type.required_text("id", "0x8000..0xffff, such as 0x8001");
  const auto id = text.starts_with("0x") ? base::parse_hex_number<std::uint16_t>(std::string_view(text).substr(2))
                                         : base::parse_number<std::uint16_t>(text);
  if (id) return *id;
  if (type.has("id")) type.error("id", "expected 0x8000..0xffff");
  return model::kFirstSiteType;
}

}  // namespace

void read_site_types(ConfigReader& root, TypeCatalogue& types) {
  for (auto& [name, type] : root.maps("types")) {
    model::SiteType site;
    site.id = type_id(type);
    site.name = name;
    site.quantity = type.text("quantity", name);
    site.unit = type.text("unit", "1");
    site.data = data_type(type);
    site.minimum = type.real("minimum", site.minimum, -1e300, 1e300);
    site.maximum = type.real("maximum", site.maximum, -1e300, 1e300);
    site.report =
        type.choice("report", "state", {"state", "event"}) == "event" ? model::Report::kEvent : model::Report::kState;
    site.words = fmt::format("{}", fmt::join(type.texts("words"), ","));
    type.finish();
    if (auto declared = types.declare(site); !declared) type.error("", declared.error().text);
  }
}

}  // namespace rubicon::config
