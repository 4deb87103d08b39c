#include <fmt/format.h>

#include <cmath>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/output/tuple_text.h"
#include "apps/rubicon/targets/suggestions.h"
#include "model/json_members.h"
#include "model/type_names.h"
#include "rubicon/unit.hpp"

namespace rubicon::cli {

namespace {

Line json_of(const Type& type) {
  Line line;
  line["type"] = type.name;
  line["number"] = static_cast<unsigned>(type.id);
  line["quantity"] = type.quantity;
  line["unit"] = type.unit;
  line["data"] = to_string(type.data);
  if (std::isfinite(type.minimum)) line["minimum"] = type.minimum;
  if (std::isfinite(type.maximum)) line["maximum"] = type.maximum;
  if (!type.words.empty()) line["words"] = type.words;
  line["report"] = type.report == model::Report::kState ? "state" : "event";
  return line;
}

int list(const Settings& settings, const std::string& word) {
  const std::string of_today(model::current_type(word));
  const TypeCatalogue catalogue;
  Output out(1);
  using Kind = Column::Kind;
  Table table({{"TYPE", Kind::kKey},
               {"NUMBER"},
               {"UNIT"},
               {"DATA", Kind::kWord, 2},
               {"RANGE", Kind::kText},
               {"QUANTITY", Kind::kText, 1}});
  for (const auto* type : catalogue.all()) {
    if (!word.empty() && !found_by(*type, word) && !found_by(*type, of_today)) continue;
    if (settings.json) out.line(model::dump(json_of(*type)));
    table.row({std::string(type->name), std::to_string(static_cast<unsigned>(type->id)), model::unit_text(type->unit),
               std::string(to_string(type->data)), range_text(*type), std::string(type->quantity)});
  }
  if (table.empty()) {
    const auto near = suggest_type({}, word);
    print_error(fmt::format("no type matches {}{}{}", model::quoted(word), near.empty() ? "" : "; ", near));
    return kNotThere;
  }
  if (!settings.json) out.write(table.text({out.has_colour(), out.width()}));
  return ended(out, kGood);
}

}  // namespace

void add_types(Cli& cli) {
  const auto word = std::make_shared<std::string>();
  auto* app = cli.command({"types", "List the types of sensors, actuators and properties: number, unit, range",
                           "  rubicon types\n"
                           "  rubicon types temperature       # by name, quantity or unit\n"
                           "  rubicon types ppm --json\n"
                           "These are the types every island knows; a site may declare its own (docs/types.md).\n"},
                          [word](const Settings& settings) { return list(settings, *word); });
  app->add_option("WORD", *word, "part of the name, quantity or unit, or the number; default: all types");
}

}  // namespace rubicon::cli
