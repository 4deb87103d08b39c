#include "apps/rubicon-proxy/knx_importer.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "base/config_reader.h"
#include "base/text.h"
#include "config/yaml.h"
#include "model/json_members.h"
#include "networks/knx/dpt/dpt.h"
#include "networks/knx/groups/group_file.h"
#include "networks/knx/groups/import.h"
#include "networks/knx/point_table.h"
#include "networks/knx/project/project.h"
#include "networks/knx/project/zip_source.h"
#include "networks/knx/secure/key.h"
#include "rubicon/key.hpp"

namespace rubicon::daemon {

namespace {

namespace knx = networks::knx;
using Json = nlohmann::ordered_json;
using knx::groups::GroupPoint;

/// Findings without an address of a point that one answer names; the report counts all.
constexpr std::size_t kMaxFindings = 500;

bool is_group_file(const std::string& name) {
  return name.ends_with(".yaml") || name.ends_with(".yml");
}

Result<knx::groups::Import> read_group_file(const std::string& text, const std::string& name) {
  const auto root = config::parse_yaml(text, name);
  if (!root) return fail(root.error());
  base::ConfigErrors errors;
  ConfigReader reader(*root, "", errors);
  knx::groups::Import out;
  knx::groups::read_groups(reader, out.points);
  out.secured = knx::groups::read_secured_groups(reader);
  out.report.notation = knx::groups::read_notation(reader).value_or(knx::wire::Notation::kThreeLevel);
  reader.finish();
  if (!errors.empty()) return fail(ErrorCode::kInvalid, errors.text());
  out.report.source = name;
  out.report.form = "group file";
  out.report.taken = out.points.size();
  return out;
}

Result<knx::groups::ImportOptions> options_of(const web::ImportRequest& request, const std::string& known) {
  knx::groups::ImportOptions how;
  how.guess = request.guess;
  if (known.empty()) return how;
  auto before = read_group_file(known, request.network + " before");
  if (!before) return fail(before.error());
  how.known = std::move(before->points);
  how.known_secured = std::move(before->secured);
  return how;
}

Result<knx::groups::Import> read_file(web::ImportRequest& request, const std::string& known) {
  if (is_group_file(request.name)) return read_group_file(request.content, request.name);
  const auto how = options_of(request, known);
  if (!how) return fail(how.error());
  const auto bytes = base::as_bytes(request.content);
  auto file = knx::project::file_of(Bytes(bytes.begin(), bytes.end()));
  const auto is_project = knx::project::is_project(*file, request.name);
  if (!is_project) return fail(is_project.error());
  if (!*is_project) return knx::groups::import_text(request.content, request.name, *how);
  request.content = {};
  const auto password = knx::secure::Secret::of_text(request.password);
  return knx::project::import_project(std::move(file), request.name, {password.empty() ? nullptr : &password}, *how);
}

Error wrong_choice(const std::string& address, std::string_view what) {
  return {ErrorCode::kInvalid, fmt::format("choices: {}: {}", model::quoted(address), what)};
}

/// What the user chose for one point.
Result<void> choose(GroupPoint& point, const std::string& address, const nlohmann::json& choice) {
  if (const auto dpt = model::text_of(choice, "dpt"); !dpt.empty()) {
    const auto id = knx::dpt::parse_dpt(dpt);
    if (!id || knx::dpt::find_dpt(*id) == nullptr)
      return fail(wrong_choice(address, fmt::format("there is no data point type {}", model::quoted(dpt))));
    point.dpt = *id;
  }
  const auto kind = model::text_of(choice, "kind");
  if (kind == "actuator" || kind == "sensor") {
    point.kind = kind == "sensor" ? model::Kind::kSensor : model::Kind::kActuator;
    if (point.kind == model::Kind::kSensor && point.state)
      return fail(wrong_choice(address, "has a state address, so it is an actuator"));
  } else if (!kind.empty()) {
    return fail(wrong_choice(address, "kind is expected to be sensor or actuator"));
  }
  return {};
}

Result<void> choose(std::vector<GroupPoint>& points, const std::string& text) {
  if (text.empty()) return {};
  const auto choices = model::object_of(text);
  std::map<knx::wire::GroupAddress, GroupPoint*> by_address;
  for (auto& point : points) by_address.emplace(point.address, &point);
  std::vector<knx::wire::GroupAddress> left;
  for (const auto& [text_of_address, choice] : choices.items()) {
    const auto address = knx::wire::parse_group(text_of_address);
    const auto found = address ? by_address.find(*address) : by_address.end();
    if (found == by_address.end()) return fail(wrong_choice(text_of_address, "is no address of the file"));
    if (model::flag_of(choice, "leave")) left.push_back(*address);
    if (auto good = choose(*found->second, text_of_address, choice); !good) return good;
  }
  std::erase_if(points,
                [&](const auto& one) { return std::find(left.begin(), left.end(), one.address) != left.end(); });
  return {};
}

Json counts_json(const knx::groups::Report& report) {
  return {{"taken", report.taken},
          {"untyped", report.untyped},
          {"mainTypeOnly", report.main_type_only},
          {"secured", report.secured},
          {"paired", report.paired + report.paired_by_project},
          {"errors", report.errors},
          {"warnings", report.warnings},
          {"notes", report.notes}};
}

/// What the report says of addresses, and the rest of it.
class ImportFindings {
 public:
  explicit ImportFindings(const knx::groups::Report& report) : notation_(report.notation) {
    for (const auto& one : report.findings) {
      using Level = knx::groups::Finding::Level;
      if (one.address && one.level != Level::kError)
        by_address_[*one.address].push_back(one.text);
      else if (one.level != Level::kNote && rest_.size() < kMaxFindings)
        rest_.push_back(json_of(one));
    }
  }

  Json of(const GroupPoint& point) const {
    auto all = Json::array();
    for (const auto& address : {std::optional(point.address), point.state}) {
      const auto found = address ? by_address_.find(*address) : by_address_.end();
      if (found == by_address_.end()) continue;
      for (const auto& text : found->second) all.push_back(text);
    }
    return all;
  }
  Json rest() const { return rest_; }

 private:
  Json json_of(const knx::groups::Finding& one) const {
    return {{"level", to_string(one.level)},
            {"line", one.line},
            {"address", one.address ? to_string(*one.address, notation_) : std::string()},
            {"text", one.text}};
  }

  knx::wire::Notation notation_;
  std::map<knx::wire::GroupAddress, std::vector<std::string>> by_address_;
  Json rest_ = Json::array();
};

/// `point` is the part of its key behind the network.
Json point_json(const GroupPoint& point, const knx::BoundPoint& bound, const TypeCatalogue& types,
                const knx::groups::Import& imported, const ImportFindings& findings) {
  const auto& type = *types.find(bound.id.type);
  const auto device = point.device.empty() ? knx::wire::to_key_part(point.address) : model::to_key_part(point.device);
  Json json{{"address", to_string(point.address, imported.report.notation)},
            {"state", point.state ? to_string(*point.state, imported.report.notation) : std::string()},
            {"name", point.name},
            {"room", point.room},
            {"dpt", point.dpt ? to_string(*point.dpt) : std::string()},
            {"kind", to_string(point.kind)},
            {"point", fmt::format("{}.{}.{}-{}", device, to_string(point.kind), type.name, point.instance)},
            {"unit", type.unit}};
  if (auto notes = findings.of(point); !notes.empty()) json["notes"] = std::move(notes);
  return json;
}

Json points_json(const knx::groups::Import& imported) {
  const TypeCatalogue types;
  const ImportFindings findings(imported.report);
  const knx::PointTable table(imported.points, types, imported.report.notation);
  auto points = Json::array();
  for (std::size_t i = 0; i < imported.points.size(); ++i)
    points.push_back(point_json(imported.points[i], table.points()[i], types, imported, findings));
  return points;
}

/// All types that a point may have.
Json types_json() {
  auto types = Json::array();
  for (const auto& type : knx::dpt::all_dpts())
    types.push_back({{"dpt", to_string(type.id)}, {"meaning", type.meaning}, {"unit", type.unit}});
  return types;
}

}  // namespace

Result<std::string> preview_of(web::ImportRequest request, const std::string& known) {
  auto imported = read_file(request, known);
  if (!imported) return fail(imported.error());
  if (imported->points.empty())
    return fail(ErrorCode::kInvalid, fmt::format("{}: no group address in it can be imported", request.name));
  if (auto good = choose(imported->points, request.choices); !good) return fail(good.error());
  if (const auto conflicts = knx::groups::conflicts(imported->points); !conflicts.empty())
    return fail(ErrorCode::kInvalid, fmt::format("choices: {}", conflicts.front()));
  Json preview{{"form", imported->report.form},
               {"merged", imported->report.merged},
               {"counts", counts_json(imported->report)},
               {"findings", ImportFindings(imported->report).rest()},
               {"points", points_json(*imported)}};
  preview["groups"] =
      knx::groups::to_yaml(imported->points, imported->report.source, imported->secured, imported->report.notation);
  if (request.choices.empty()) preview["types"] = types_json();
  return model::dump(preview);
}

/// The group file of a network that has one, so that its points keep their names and types.
std::string KnxImporter::known_groups(const std::string& network) {
  const auto& config = island_.config();
  for (const auto& setup : config.networks) {
    if (setup.key != network || setup.kept.empty()) continue;
    const auto options = base::unpacked(setup.kept);
    const auto* import = options.find("import");
    if (import == nullptr || !is_group_file(import->text)) continue;
    const auto path = base::resolve_path(config.directory, import->text);
    return transport::read_text(transports_, path, knx::groups::kMaxListBytes).value_or(std::string());
  }
  return {};
}

void KnxImporter::preview(web::ImportRequest request, std::function<void(Result<std::string>)> done) {
  const auto refuse = [&](Error error) { lifetime_.post(scheduler_, [done, error] { done(fail(error)); }); };
  if (worker_) return refuse({ErrorCode::kBusy, "another file is being read: try again later"});
  auto worker = transports_.start_worker("knx-import");
  if (!worker) return refuse(worker.error());
  worker_ = std::move(*worker);
  auto known = known_groups(request.network);
  auto answer = lifetime_.guard([this, done](const Result<std::string>& preview) {
    worker_.reset();
    done(preview);
  });
  worker_->run([request = std::make_shared<web::ImportRequest>(std::move(request)), known = std::move(known), answer,
                &scheduler = scheduler_] {
    auto preview = std::make_shared<Result<std::string>>(preview_of(std::move(*request), known));
    scheduler.post([answer, preview]() mutable { answer(*preview); });
  });
}

}  // namespace rubicon::daemon
