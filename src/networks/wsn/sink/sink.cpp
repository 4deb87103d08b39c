#include "networks/wsn/sink/sink.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "base/text.h"
#include "networks/wsn/sink/packet_logs.h"
#include "networks/wsn/sink/stream_sinks.h"
#include "transport/sockets.h"

namespace rubicon::networks::wsn::sink {

namespace {

/// Platforms and their baud rates (wsn.md 1.2).
constexpr std::array<std::pair<std::string_view, unsigned>, 13> kPlatforms{{{"mica", 19200},
                                                                            {"mica2", 57600},
                                                                            {"mica2dot", 19200},
                                                                            {"telos", 115200},
                                                                            {"telosb", 115200},
                                                                            {"tinynode", 115200},
                                                                            {"tmote", 115200},
                                                                            {"micaz", 57600},
                                                                            {"eyesIFX", 57600},
                                                                            {"intelmote2", 115200},
                                                                            {"iris", 57600},
                                                                            {"shimmer", 115200},
                                                                            {"ucmini", 115200}}};

constexpr std::string_view kForms = "`serial@DEVICE:BAUD`, `network@HOST:PORT`, `sf@HOST:PORT` or `file@PATH`";
constexpr std::string_view kRecords = "`+file@PATH` to record";

/// A part of the source string and its offset there.
struct Part {
  std::string_view text;
  std::size_t at = 0;

  Part from(std::size_t first) const { return {text.substr(std::min(first, text.size())), at + first}; }
  Part first(std::size_t count) const { return {text.substr(0, count), at}; }
};

/// Positions count from 1.
auto wrong(const Part& part, std::string_view expected) {
  return fail(ErrorCode::kInvalid,
              fmt::format("source, position {}: \"{}\", expected {}", part.at + 1, part.text, expected));
}

auto not_supported(const Part& part, std::string_view instead) {
  return fail(ErrorCode::kUnsupported,
              fmt::format("source, position {}: \"{}\" is not supported; {}", part.at + 1, part.text, instead));
}

Part trimmed(const Part& part) {
  const auto inner = base::trimmed(part.text);
  if (inner.empty()) return part.first(0);
  return part.from(static_cast<std::size_t>(inner.data() - part.text.data())).first(inner.size());
}

std::vector<Part> elements_of(std::string_view text) {
  std::vector<Part> elements;
  Part rest{text, 0};
  while (true) {
    const auto plus = rest.text.find('+');
    const auto arrows = rest.text.find(">>");
    const auto end = std::min(plus, arrows);
    elements.push_back(trimmed(rest.first(end)));
    if (end == rest.text.npos) return elements;
    rest = rest.from(end + (plus < arrows ? 1 : 2));
  }
}

Result<unsigned> read_baud(const Part& part) {
  const auto* const platform =
      std::find_if(kPlatforms.begin(), kPlatforms.end(), [&](const auto& row) { return row.first == part.text; });
  if (platform != kPlatforms.end()) return platform->second;
  const auto number = base::parse_number<unsigned>(part.text);
  if (number && transport::is_baud_rate(*number)) return *number;
  return wrong(part,
               "a baud rate of serial lines (50 to 4000000, such as 57600 or 115200) or a platform (telosb, tmote, "
               "micaz, iris, ...)");
}

Result<Source> read_serial(const Part& rest) {
  const auto colon = rest.text.rfind(':');  // /dev/serial/by-path names contain colons
  if (colon == rest.text.npos || colon == 0) return wrong(rest, "DEVICE:BAUD, as in `serial@/dev/ttyUSB0:telosb`");
  const auto baud = read_baud(rest.from(colon + 1));
  if (!baud) return fail(baud.error());
  Source source;
  source.kind = Source::Kind::kSerial;
  source.path = rest.text.substr(0, colon);
  source.baud = *baud;
  return source;
}

bool is_host(const std::string& text) {
  constexpr std::string_view kOthers = "._-%:";  // colons came in brackets
  const auto good = [&](char c) {
    const bool word = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    return word || kOthers.find(c) != kOthers.npos;
  };
  return std::all_of(text.begin(), text.end(), good) && base::host_fault(text).empty();
}

auto wrong_endpoint(const Part& part, std::size_t separator) {
  if (separator == part.text.npos || part.text.ends_with(']')) return wrong(part, "HOST:PORT with a port");
  const auto host = part.first(separator);
  const auto with_any_port = base::parse_host_port(fmt::format("{}:1", host.text));
  if (!with_any_port && host.text.find_first_of("[]:") != part.text.npos)
    return wrong(part, "HOST:PORT, with an IPv6 address in brackets: `[::1]:9002`");
  if (!with_any_port || !is_host(with_any_port->host)) return wrong(host, "a host name or address");
  return wrong(part.from(separator + 1), "a port of 1 to 65535");
}

/// `HOST:PORT` or, where `comma` is allowed, `HOST,PORT`; IPv6 addresses in brackets.
Result<Source> read_endpoint(const Part& part, Source::Kind kind, bool comma) {
  const auto separator = part.text.find_last_of(comma ? ":," : ":");
  std::string text(part.text);
  if (separator != text.npos) text[separator] = ':';
  auto endpoint = base::parse_host_port(text);
  if (!endpoint || !is_host(endpoint->host)) return wrong_endpoint(part, separator);
  Source source;
  source.kind = kind;
  source.host = std::move(endpoint->host);
  source.port = endpoint->port;
  return source;
}

Result<Source> read_file(const Part& rest) {
  if (rest.text.empty()) return wrong(rest, "`file@` and the path of a packet log");
  Source source;
  source.kind = Source::Kind::kFile;
  source.path = rest.text;
  return source;
}

struct Element {
  std::string_view scheme;  ///< empty: there is no `@`
  Part rest;
};

Element split(const Part& part) {
  const auto at = part.text.find('@');
  if (at == part.text.npos) return {{}, part};
  return {part.text.substr(0, at), part.from(at + 1)};
}

bool is_simulator(const Part& part) {
  const auto name = part.text.substr(0, part.text.find('@'));
  return name == "tossim-serial" || name == "tossim-radio";
}

Result<Source> read_first(const Part& part) {
  const auto [scheme, rest] = split(part);
  if (scheme == "serial") return read_serial(rest);
  if (scheme == "network") return read_endpoint(rest, Source::Kind::kStream, true);
  if (scheme == "sf") return read_endpoint(rest, Source::Kind::kForwarder, false);
  if (scheme == "file") return read_file(rest);
  if (is_simulator(part))
    return not_supported(part, "make the simulator serve its serial port over TCP and use `network@HOST:PORT`");
  if (scheme == "peis")
    return not_supported(part,
                         "share the sink from the proxy that owns it (`share:` of its network) and use `sf@HOST:PORT`");
  if (scheme == "log") return not_supported(part, "to play a packet log use `file@PATH`, or a network of type `log`");
  if (scheme.empty() && part.text.find(',') != part.text.npos) return read_endpoint(part, Source::Kind::kStream, true);
  return wrong(part, kForms);
}

Result<void> read_later(const Part& part, Source& source) {
  const auto [scheme, rest] = split(part);
  if (scheme == "peis") return not_supported(part, "use `share:` of the network to offer the sink to other programs");
  if (scheme == "serial" || scheme == "network" || scheme == "sf" || is_simulator(part))
    return wrong(part, fmt::format("only one source, and {}", kRecords));
  if (scheme == "log") return wrong(part, kRecords);
  if (scheme != "file")
    return wrong(part, fmt::format("{} (`+` and `>>` separate elements: a path cannot contain them)", kRecords));
  if (rest.text.empty()) return wrong(rest, "`file@` and the path to record to");
  if (!source.record.empty()) return wrong(part, "only one file to record to");
  if (source.kind == Source::Kind::kFile && source.path == rest.text)
    return wrong(part, "a file other than the one that is played");
  source.record = rest.text;
  return {};
}

}  // namespace

Result<Source> parse_source(std::string_view text) {
  const auto elements = elements_of(text);
  auto source = read_first(elements.front());
  for (std::size_t i = 1; i < elements.size() && source; ++i) {
    if (auto read = read_later(elements[i], *source); !read) return fail(read.error());
  }
  return source;
}

std::string to_string(const Source& source) {
  const bool ipv6 = source.host.find(':') != std::string::npos;
  const auto endpoint = fmt::format("{}{}{}:{}", ipv6 ? "[" : "", source.host, ipv6 ? "]" : "", source.port);
  switch (source.kind) {
    case Source::Kind::kSerial: return fmt::format("serial@{}:{}", source.path, source.baud);
    case Source::Kind::kStream: return "network@" + endpoint;
    case Source::Kind::kForwarder: return "sf@" + endpoint;
    case Source::Kind::kFile: break;
  }
  return "file@" + source.path;
}

namespace {

/// Differs from start to start, so that a late acknowledgement to an earlier process does not match.
std::uint8_t start_sequence(const Scheduler& scheduler) {
  const auto time = std::chrono::floor<std::chrono::milliseconds>(scheduler.wall_now().time_since_epoch());
  return static_cast<std::uint8_t>(static_cast<std::uint64_t>(time.count()) & 0xffU);
}

}  // namespace

std::unique_ptr<Sink> make_sink(SinkOptions options, Scheduler& scheduler, transport::Transports& transports,
                                SinkCallbacks callbacks) {
  switch (options.source.kind) {
    case Source::Kind::kForwarder:
      return std::make_unique<ForwarderSink>(std::move(options), scheduler, transports, std::move(callbacks));
    case Source::Kind::kFile:
      return std::make_unique<FileSink>(std::move(options), scheduler, transports, std::move(callbacks));
    case Source::Kind::kSerial:
    case Source::Kind::kStream: break;
  }
  return std::make_unique<SerialSink>(options, scheduler, transports, std::move(callbacks), start_sequence(scheduler));
}

namespace {

constexpr std::uint8_t kSerialAm = 0x00;

}  // namespace

bool SinkNotifier::set_state(SinkState::Phase phase, std::string reason) {
  if (state_.phase == phase && state_.reason == reason) return true;
  state_ = {phase, std::move(reason)};
  const auto self = lifetime_.watch();
  if (callbacks_.changed) callbacks_.changed(state_);
  return !self.ended();
}

bool SinkNotifier::failed(Error why) {
  const auto self = lifetime_.watch();
  if (!set_state(SinkState::Phase::kOff, why.text)) return false;
  if (callbacks_.failed) callbacks_.failed(std::move(why));
  return !self.ended();
}

bool SinkNotifier::received(ByteView packet) {
  const auto self = lifetime_.watch();
  if (packet.empty() || packet.front() != kSerialAm) {
    ++unknown_dispatches_;
    return note("unknown-dispatches",
                packet.empty() ? std::string("an empty packet from the sink")
                               : fmt::format("a packet with dispatch byte {:02x}, expected 00", packet.front()));
  }
  ++read_;
  if (callbacks_.received) callbacks_.received(packet);
  return !self.ended();
}

bool SinkNotifier::sent(ByteView packet) {
  const auto self = lifetime_.watch();
  ++written_;
  if (callbacks_.sent) callbacks_.sent(packet);
  return !self.ended();
}

bool SinkNotifier::note(const std::string& subject, std::string_view text) {
  const auto self = lifetime_.watch();
  if (callbacks_.note) callbacks_.note(subject, text);
  return !self.ended();
}

void SinkNotifier::room(Lane lane) const {
  if (callbacks_.room) callbacks_.room(lane);
}

void SinkNotifier::count(std::map<std::string, std::uint64_t>& into) const {
  into["packets-read"] = read_;
  into["packets-written"] = written_;
  into["unknown-dispatches"] = unknown_dispatches_;
}

}  // namespace rubicon::networks::wsn::sink
