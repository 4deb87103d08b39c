#include "apps/rubicon-proxy/host_check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>

#include "config/config_file.h"
#include "config/network_numbers.h"
#include "island/island_state.h"
#include "tuples/dds/dds_options.h"
#include "tuples/peis/peis_options.h"
#include "web/web_service.h"

namespace rubicon::daemon {

namespace {

namespace fs = std::filesystem;
using Kind = network::Missing::Kind;

class Findings {
 public:
  explicit Findings(const ConfigPlaces& places) : places_(places) {}

  void add(const std::vector<std::string>& path, std::string_view text, Kind kind = Kind::kOnHost) {
    auto& lines = kind == Kind::kOnHost ? found_.lacking : kind == Kind::kWrong ? found_.wrong : found_.warnings;
    lines.push_back(fmt::format("{}: {}: {}", places_.of(path), fmt::join(path, "."), text));
  }
  /// A file is to be made there. What we may not look into is left to who runs the island.
  void need_folder(const std::vector<std::string>& path, const fs::path& file) {
    const auto folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
    std::error_code error;
    const bool there = fs::is_directory(folder, error);
    if (there || (error && error != std::errc::no_such_file_or_directory && error != std::errc::not_a_directory))
      return;
    add(path, fmt::format("there is no folder {}", folder.string()));
  }

  HostCheck take() { return std::move(found_); }

 private:
  const ConfigPlaces& places_;
  HostCheck found_;
};

/// `broker.tls.ca` is an option of an option.
std::vector<std::string> path_of(const std::string& network, const std::string& option) {
  std::vector<std::string> path{"networks", network};
  for (std::size_t begin = 0, end = 0; end != option.npos; begin = end + 1) {
    end = option.find('.', begin);
    path.push_back(option.substr(begin, end - begin));
  }
  return path;
}

}  // namespace

std::string ConfigPlaces::of(const std::vector<std::string>& path) const {
  if (!root_) {
    root_.emplace();
    if (auto root = config::load_config(file_, overrides_)) root_ = std::move(*root);
    config::number_networks(*root_);
  }
  const ConfigNode* node = &*root_;
  ConfigPlace place(file_, 0, 0);
  for (const auto& part : path) {
    node = node->find(part);
    if (!node) break;
    place = node->key_place();
  }
  return to_string(place);
}

HostCheck check_host(island::Island& island, transport::Transports& transports, const ConfigPlaces& places) {
  Findings findings(places);
  const auto& config = island.config();
  for (const auto& setup : config.networks) {
    for (const auto& one : island.networks().find(setup.id)->missing())
      findings.add(path_of(setup.key, one.option), one.text, one.kind);
  }
  if (config.engine.dds) {
    const auto good = tuples::dds::check_interfaces(config.engine.options, transport::interfaces());
    if (!good) findings.add({"tuples", "interfaces"}, good.error().text);
  } else if (config.engine.peis) {
    const auto good = tuples::peis::select_interfaces(config.engine.peis_options, transport::ipv4_interfaces());
    if (!good) findings.add({"tuples", "interfaces"}, good.error().text);
  }
  if (!config.state.file.empty()) findings.need_folder({"state", "file"}, island::state_path(config));
  if (config.history) findings.need_folder({"history", "file"}, fs::path(config.directory) / config.history->file);
  for (const auto& recorder : config.recorders)
    findings.need_folder({"recorders", recorder.name, "file"}, fs::path(config.directory) / recorder.file);
  if (config.web) {
    for (const auto& [key, text] : web::faults_of_files(transports, *config.web, config.directory))
      findings.add({"web", key}, text);
  }
  return findings.take();
}

}  // namespace rubicon::daemon
