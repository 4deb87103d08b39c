#include "networks/wsn/wsn_options.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "base/text.h"
#include "networks/wsn/mote_messages.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::wsn {

namespace {

/// The default of the original (wsn.md 1.3).
constexpr std::string_view kDefaultSource = "sf@localhost:9002";
/// Higher ids have a special meaning for motes (wsn.md 6).
constexpr std::uint32_t kLastIsland = 0xfffc;

/// The path with symbolic links resolved, as far as it exists.
std::filesystem::path canonical_path(const std::string& path) {
  const std::filesystem::path given(path);
  std::error_code unknown;
  const auto whole = std::filesystem::absolute(given, unknown);
  if (unknown) return given.lexically_normal();
  const auto found = std::filesystem::weakly_canonical(whole, unknown);
  return unknown ? whole.lexically_normal() : found;
}

sink::Source read_source(ConfigReader& options, const std::string& directory) {
  const auto text = options.text("source", kDefaultSource);
  auto source = sink::parse_source(text);
  if (!source) {
    options.error("source", source.error().text);
    return {};
  }
  if (options.has("record")) {
    const auto path = options.text("record", "");
    if (!source->record.empty())
      options.error("record", "the source names a file to record to as well, expected one of them");
    if (path.empty()) options.error("record", "empty path, expected the path of a file");
    source->record = path;
  }
  if (!source->record.empty()) source->record = base::resolve_path(directory, source->record);
  if (source->kind != sink::Source::Kind::kFile) return std::move(*source);
  source->path = base::resolve_path(directory, source->path);
  if (!source->record.empty() && canonical_path(source->record) == canonical_path(source->path))
    options.error(options.has("record") ? "record" : "source",
                  model::quoted(source->record) + ", expected a file other than the one that is played");
  return std::move(*source);
}

motes::Board read_board(ConfigReader& options, const std::string& key) {
  const auto name = options.choice(key, "STANDARD", {"STANDARD", "EM1000", "SE1000", "IRIS", "MICAZ"});
  return motes::parse_board(name).value_or(motes::Board::kStandard);
}

motes::CodecOptions read_motes(ConfigReader& options, IslandId island) {
  motes::CodecOptions out;
  out.island = static_cast<std::uint16_t>(model::number(island));
  out.actuators_report = options.choice("actuators", "report", {"report", "assumed"}) == "report";
  out.calibration.board = read_board(options, "board");
  auto boards = options.map("boards");
  for (const auto& key : boards.keys()) {
    const auto mote = mote_address(key);
    if (!mote) boards.error(key, "expected the address of a mote, 1 to 65532");
    const auto board = read_board(boards, key);
    if (mote) out.boards[*mote] = board;
  }
  boards.finish();
  const auto units = options.choice("units", "physical", {"physical", "raw", "both"});
  out.calibration.units = motes::parse_units(units).value_or(motes::Units::kPhysical);
  auto& zero = out.calibration.temperature_at_zero;
  zero = options.real("temperature-at-zero", zero, -50, 0);
  auto& threshold = out.calibration.threshold;
  threshold = static_cast<std::uint16_t>(options.integer("threshold", threshold, 1, 4095));
  return out;
}

/// `9002`, `0.0.0.0:9002`, `[::1]:9002`; the port 0 alone is any free one.
std::optional<transport::Endpoint> read_endpoint(std::string_view text) {
  if (const auto port = base::parse_number<std::uint16_t>(text)) return transport::Endpoint{"127.0.0.1", *port};
  const auto at = base::parse_host_port(text);
  if (!at || at->host.empty()) return std::nullopt;
  return transport::Endpoint{at->host, at->port};
}

/// By default a sink with a line of its own is shared, unless only members reach the island: the protocol of the
/// forwarder does not ask who connects. Behind a forwarder it is shared already.
std::optional<share::ForwarderOptions> read_share(ConfigReader& options, const sink::Source& source,
                                                  const network::NetworkConfig& config) {
  share::ForwarderOptions out;
  const auto island = static_cast<std::uint16_t>(model::number(config.island));
  const bool own_line = source.kind == sink::Source::Kind::kSerial || source.kind == sink::Source::Kind::kStream;
  const auto text = options.text("share", own_line && !config.closed ? "9002" : "no");
  out.may_configure = options.boolean("share-config", false);
  out.island = island;
  out.clients =
      static_cast<std::size_t>(options.integer("share-clients", static_cast<std::int64_t>(out.clients), 1, 1000));
  if (text == "no" || text == "off" || text == "false") return std::nullopt;
  const auto at = read_endpoint(text);
  if (at) {
    out.listen = *at;
    return out;
  }
  options.error("share", fmt::format("{}, expected no, a port, or an address and a port such as 0.0.0.0:9002",
                                     model::quoted(text)));
  return std::nullopt;
}

}  // namespace

WsnOptions read_wsn_options(const network::NetworkConfig& config) {
  ConfigReader& options = config.options;
  WsnOptions out;
  if (model::number(config.island) > kLastIsland)
    options.error(
        "", fmt::format("island {}: motes can join islands 1 to {} only", model::number(config.island), kLastIsland));
  out.source = read_source(options, config.directory);
  out.codec = read_motes(options, config.island);
  if (out.source.kind == sink::Source::Kind::kFile) {
    out.codec.island.reset();  // a recording may be of any island
  } else {
    out.codec.unknown = {0, 0xffff};
  }
  out.read_updates = options.choice("sampling", "periodic", {"periodic", "read-updates"}) == "read-updates";
  out.island_check = options.duration_or_never("island-check", out.island_check);
  if (out.island_check && *out.island_check < std::chrono::seconds(1))
    options.error("island-check", "expected at least 1s, or never");
  out.messages_to = OwnerId(static_cast<std::uint32_t>(options.integer("messages-to", 0, 0, UINT32_MAX)));
  out.messages_as_json = options.choice("messages-as", "bytes", {"bytes", "json"}) == "json";
  out.share = read_share(options, out.source, config);
  return out;
}

}  // namespace rubicon::networks::wsn
