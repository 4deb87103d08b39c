#include "apps/rubicon-proxy/parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <utility>

#include "island/rights_checks.h"
#include "model/json_text.h"
#include "model/point_keys.h"
#include "rubicon/summary.hpp"
#include "transport/host_names.h"

namespace rubicon::daemon {

Result<void> AuditPart::take(const island::IslandConfig& config, rights::RightsJudge& judge) {
  auto options = island::audit_options(config);
  if (file_ && options.file == path_) {
    file_->change(std::move(options));
    return {};
  }
  auto path = options.file;
  auto opened = rights::AuditFile::open(std::move(options), scheduler_, log_, lines_);
  if (!opened) return fail(std::move(opened.error()));
  path_ = std::move(path);
  file_ = std::move(*opened);
  judge.record_by(file_);
  return {};
}

namespace {

constexpr Duration kShowEach = std::chrono::seconds(1);
constexpr tuples::SetOptions kJson{"application/json", {}, {}};

}  // namespace

void check_bridges(const std::vector<config::BridgeSetup>& setups, const std::string& directory,
                   base::ConfigErrors& errors) {
  for (const auto& setup : setups) {
    ConfigReader options(setup.options, "bridges." + setup.name, errors);
    const auto* type = bridges::find_bridge_type(setup.type);
    if (type == nullptr && !setup.type.empty())
      options.error("type", fmt::format("is '{}', expected one of: {}", setup.type, bridges::bridge_type_names()));
    if (type != nullptr) std::ignore = type->make(options, directory, nullptr);
  }
}

struct BridgesPart::One {
  config::BridgeSetup setup;
  std::size_t place = 0;
  std::unique_ptr<tuples::Link> link;
  std::unique_ptr<TupleSpace> space;
  std::unique_ptr<bridges::Bridge> bridge;
  bridges::BridgeStatus shown{};
  WallTime since{};
};

BridgesPart::BridgesPart(Host host) : host_(std::move(host)) {}
BridgesPart::~BridgesPart() = default;

std::size_t BridgesPart::free_place() const {
  for (std::size_t place = 0;; ++place) {
    if (std::none_of(all_.begin(), all_.end(), [place](const auto& one) { return one->place == place; })) return place;
  }
}

OwnerId BridgesPart::id_of(std::size_t place) {
  while (ids_.size() <= place) ids_.push_back(host_.new_id(ids_.size()));
  return ids_[place];
}

rights::RightsJudge& BridgesPart::judge() {
  using namespace rights;
  const auto& config = host_.island.config();
  if (config.rights && host_.judge) return *host_.judge;
  if (!own_judge_) {
    Rule all;
    all.who = {std::string(kEverybody)};
    all.may = RightSet::all();
    own_judge_ = std::make_shared<RightsJudge>(Rights({all}));
  }
  const auto kept = host_.judge ? Result<void>() : host_.audit.take(config, *own_judge_);
  if (!kept) Log(host_.log, "bridges").warning(kept.error().text);
  host_.audit.share(*own_judge_);
  return *own_judge_;
}

void BridgesPart::end_others(bool all) {
  const auto& config = host_.island.config();
  std::erase_if(all_, [&](const auto& one) {
    const bool goes =
        all || std::find(config.bridges.begin(), config.bridges.end(), one->setup) == config.bridges.end();
    const auto key = model::IslandKey{config.proxy.prefix}.bridge(one->setup.name).status();
    if (goes) std::ignore = host_.island.space().erase(key);
    return goes;
  });
}

void BridgesPart::take() {
  const auto& config = host_.island.config();
  end_others(rights_ != config.rights);
  rights_ = config.rights;
  for (const auto& setup : config.bridges) {
    if (std::any_of(all_.begin(), all_.end(), [&](const auto& one) { return one->setup == setup; })) continue;
    auto one = std::make_unique<One>();
    one->setup = setup;
    one->place = free_place();
    const auto opened = open(*one);
    if (opened) all_.push_back(std::move(one));
    if (!opened)
      Log(host_.log, "bridge " + setup.name)
          .warning(fmt::format("{}; the island runs without it", opened.error().text));
  }
  show();
}

Result<void> BridgesPart::open(One& one) {
  const auto& name = one.setup.name;
  const auto& config = host_.island.config();
  const auto id = id_of(one.place);
  auto link = host_.ecology.join(id);
  if (!link) return fail(link.error());
  one.link = std::move(*link);
  one.space = std::make_unique<TupleSpace>(id, host_.scheduler, *one.link);
  const model::Summary summary{"bridge " + name, transport::host_name(), transport::own_process(), "",
                               host_.scheduler.wall_now()};
  if (auto named = one.space->describe(model::to_json(summary)); !named) return named;
  const bridges::BridgeHost host{name,      host_.scheduler, *one.space,          host_.transports,
                                 host_.log, config.id,       config.proxy.prefix, &judge()};
  base::ConfigErrors errors;
  ConfigReader options(one.setup.options, "bridges." + name, errors);
  const auto* type = bridges::find_bridge_type(one.setup.type);
  one.bridge = type ? type->make(options, config.directory, &host) : nullptr;
  if (!one.bridge) return fail(ErrorCode::kInvalid, errors.text());
  one.bridge->start();
  return {};
}

/// What changed since it was shown.
void BridgesPart::show() {
  for (const auto& one : all_) {
    auto status = one->bridge->status();
    const bool other = status.state != one->shown.state;
    if (status == one->shown) continue;
    if (other) one->since = host_.scheduler.wall_now();
    std::ignore =
        host_.island.space().set(model::IslandKey{host_.island.config().proxy.prefix}.bridge(one->setup.name).status(),
                                 bridges::to_json(status, one->since), kJson);
    one->shown = std::move(status);
  }
  if (!all_.empty()) show_ = host_.scheduler.after(kShowEach, [this] { show(); });
}

bool HistoryPart::has(const std::optional<config::HistorySetup>& setup) const {
  return setup ? history_ && history_->setup() == *setup : !history_;
}

void HistoryPart::take(const std::optional<config::HistorySetup>& setup, const std::string& directory) {
  if (has(setup)) return;
  questions_.reset();
  status_.reset();
  history_.reset();  // writes the last points
  space_.reset();
  link_.reset();
  if (!setup) return;
  if (const auto opened = open(*setup, directory); !opened)
    log_.warning(fmt::format("{}; the island runs without its history", opened.error().text));
}

Result<void> HistoryPart::open(const config::HistorySetup& setup, const std::string& directory) {
  auto worker = transport::start_worker("history");
  if (!worker) return fail(worker.error());
  auto link = host_.ecology.join(id_);
  if (!link) return fail(link.error());
  link_ = std::move(*link);
  space_ = std::make_unique<TupleSpace>(id_, host_.scheduler, *link_);
  const model::Summary summary{"history of the island", transport::host_name(), transport::own_process(), "",
                               host_.scheduler.wall_now()};
  if (auto named = space_->describe(model::to_json(summary)); !named) return named;
  history_ = std::make_unique<history::History>(
      setup, history::History::Context{host_.scheduler, std::move(*worker), host_.log, directory});
  history_->follow(*space_);
  status_ = std::make_unique<history::StatusTuple>(host_.scheduler, host_.island,
                                                   model::IslandKey{host_.prefix}.history().status(), *history_);
  questions_ = std::make_unique<history::MessageQuestions>(host_.island, host_.gateway, *history_);
  return {};
}

void WebPart::take(const std::optional<config::WebSetup>& setup, const std::string& directory,
                   history::History* history) {
  if (service_ && setup == setup_) {
    if (const auto read = service_->reload(); !read)
      log_.warning(fmt::format("{}; the page keeps the tokens and the certificate that it had", read.error().text));
    return;
  }
  close();
  if (!setup) {
    if (host_.closed && !std::exchange(is_offered_, true))
      log_.info("the island has no page; `rubicon web enable` makes its address and a token");
    return;
  }
  if (const auto opened = open(*setup, directory, history); !opened) {
    close();
    return log_.warning(fmt::format("{}; the island runs without its page", opened.error().text));
  }
  setup_ = setup;
  log_.info("open " + service_->address());
}

Result<void> WebPart::open(const config::WebSetup& setup, const std::string& directory, history::History* history) {
  auto link = host_.ecology.join(id_);
  if (!link) return fail(link.error());
  link_ = std::move(*link);
  auto& scheduler = host_.loop.scheduler();
  space_ = std::make_unique<TupleSpace>(id_, scheduler, *link_);
  const model::Summary summary{"page of the island", transport::host_name(), transport::own_process(), "",
                               scheduler.wall_now()};
  if (auto named = space_->describe(model::to_json(summary)); !named) return named;
  auto service = web::WebService::open({host_.loop.context(), scheduler, *space_, host_.transports, host_.log, history,
                                        host_.island, &host_.importer, host_.closed},
                                       setup, directory, name_);
  if (!service) return fail(service.error());
  service_ = std::move(*service);
  return {};
}

void WebPart::close() {
  service_.reset();
  space_.reset();
  link_.reset();
  setup_.reset();
}

std::string interfaces_text(const tuples::dds::InterfaceNews& news) {
  if (news.interfaces.empty()) return {};
  auto all = nlohmann::ordered_json::array();
  for (const auto& [name, state] : news.interfaces)
    all.push_back({{"name", name}, {"address", state.address}, {"lack", state.lack}});
  const auto changed = std::chrono::floor<std::chrono::seconds>(news.changed.time_since_epoch()).count();
  return model::dump({{"interfaces", std::move(all)}, {"changes", news.changes}, {"changed", changed}});
}

void show_interfaces(island::Island& island, const tuples::dds::DdsEcology& ecology) {
  island.show_word("dds-interfaces", [&ecology] { return interfaces_text(ecology.interfaces()); });
}

}  // namespace rubicon::daemon
