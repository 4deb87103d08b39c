#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/output/tuple_text.h"
#include "apps/rubicon/targets/options.h"
#include "base/bytes.h"
#include "base/clocks.h"
#include "model/json_members.h"
#include "tuples/tuple_json.h"

namespace rubicon::cli {

namespace {

/// What an island takes (docs/gateway.cddl) with room for the rest of the message.
constexpr std::size_t kMaxByteCount = 1000UL * 1000;

struct SendOptions {
  std::string to, type = "text", file, network, device;
  std::optional<std::string> text;
  bool hex = false;
};

Result<std::string> words(const SendOptions& options) {
  if (!options.text && options.file.empty())
    return fail(ErrorCode::kInvalid, "nothing to send, expected TEXT, - or --file");
  if (options.text && *options.text != "-") return *options.text;
  const bool standard = options.file.empty() || options.file == "-";
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(
      standard ? stdin : std::fopen(options.file.c_str(), "rb"),  // NOLINT(cppcoreguidelines-owning-memory)
      [](std::FILE* one) { return one == stdin ? 0 : std::fclose(one); });
  if (!file) return fail(ErrorCode::kIo, fmt::format("{}: cannot be opened", options.file));
  std::string bytes(kMaxByteCount + 1, '\0');
  bytes.resize(std::fread(bytes.data(), 1, bytes.size(), file.get()));
  if (std::ferror(file.get())) return fail(ErrorCode::kIo, fmt::format("{}: cannot be read", options.file));
  if (bytes.size() > kMaxByteCount)
    return fail(ErrorCode::kOutOfRange, fmt::format("a message has at most {} bytes", kMaxByteCount));
  return bytes;
}

Result<std::string> content(const SendOptions& options) {
  auto text = words(options);
  if (!text || !options.hex) return text;
  std::erase_if(*text, [](char letter) { return letter == '\n' || letter == '\r'; });
  const auto bytes = base::from_hex(*text);
  if (!bytes) return fail(bytes.error());
  return std::string(base::as_text(*bytes));
}

int tell(Session& session, OwnerId to, std::size_t bytes, const std::string& why_not) {
  if (session.json()) {
    session.out().line(
        model::dump({{"to", number(to)}, {"bytes", bytes}, {"ok", why_not.empty()}, {"reason", why_not}}));
  } else if (why_not.empty()) {
    session.out().line(fmt::format("sent {} to {}", counted(bytes, "byte"), session.component_text(to)));
  } else {
    print_error(fmt::format("{} did not take it: {}", session.component_text(to), printable(why_not)));
  }
  return why_not.empty() ? kGood : kRefused;
}

int send(Session& session, const SendOptions& options) {
  const auto bytes = content(options);
  if (!bytes) {
    print_error(bytes.error().text);
    return bytes.error().code == ErrorCode::kIo ? kFailed : kUsage;
  }
  const auto found = components_called(session, options.to);
  if (found.empty()) return session.not_found(fmt::format("no component {}", model::quoted(options.to)));
  if (found.size() > 1) {
    std::string ids;
    for (const auto id : found) ids += fmt::format(" {}", number(id));
    print_error(fmt::format("{} is the name of several components; use an id:{}", model::quoted(options.to), ids));
    return kUsage;
  }
  std::optional<std::string> answer;
  const auto heard = [&answer](const std::string& why_not) { answer = why_not; };
  auto& client = session.client();
  if (!options.device.empty()) {
    client.send_to_device(found[0], options.network, options.device, options.type, *bytes, heard);
  } else {
    client.send_to_network(found[0], options.network, options.type, *bytes, heard);  // none: to the component itself
  }
  if (session.run([&] { return answer.has_value(); }, session.settings().patience + std::chrono::seconds(5)))
    return tell(session, found[0], bytes->size(), *answer);
  print_error(fmt::format("{} did not answer", session.component_text(found[0])));
  return kTimedOut;
}

}  // namespace

void add_send(Cli& cli) {
  const auto options = std::make_shared<SendOptions>();
  auto* app =
      cli.command_in_ecology({"send", "Send a message of a type to a component",
                              "  rubicon send 70001 --type chat 'come to the kitchen'\n"
                              "  rubicon send 6541 --type image --file map.png\n"
                              "  date | rubicon send robot --type clock -\n"
                              "  rubicon send 6541 --network wsn-1 --device 7 --type mote/3/6/1 --hex 01012cbeef\n"},
                             [options](Session& session) { return send(session, *options); });
  app->add_option("COMPONENT", options->to, "id or name of an island or another component")->required();
  auto* text = app->add_option("TEXT", options->text, "the message; - = standard input");
  app->add_option("--type", options->type, "your word for what it is")->capture_default_str();
  app->add_option("--file", options->file, "send what is in this file")->excludes(text);
  app->add_flag("--hex", options->hex, "TEXT, input or file are bytes in hex");
  app->add_option("--device", options->device, "to a device of the island, by its address");
  app->add_option("--network", options->network,
                  "to a network of the island, or its device where several have that address");
}

namespace {

constexpr Duration kLastWords = std::chrono::milliseconds(300);

struct ReceiveOptions {
  AsOptions as;
  std::string type, length;
  std::size_t count = 0;
  bool hex = false, raw = false;
};

Line json_of(const client::UserMessage& message, WallTime now) {
  Line line;
  line["time"] = base::iso_text(now);
  line["from"] = number(message.from);
  if (!message.device.empty()) line["network"] = message.network;
  if (!message.device.empty()) line["device"] = message.device;
  line["type"] = message.type;
  if (base::is_utf8(message.bytes)) {
    line["text"] = message.bytes;
  } else {
    line["hex"] = base::to_hex(base::as_bytes(message.bytes));
  }
  return line;
}

/// `70001`, or `6541 wsn-1/7` for a device of an island.
std::string sender_of(const client::UserMessage& message) {
  const auto id = std::to_string(number(message.from));
  return message.device.empty() ? id : fmt::format("{} {}/{}", id, message.network, message.device);
}

void show(Session& session, const client::UserMessage& message, const ReceiveOptions& options) {
  auto& out = session.out();
  if (session.json()) return out.line(model::dump(json_of(message, session.now())));
  if (options.raw) return out.write(message.bytes);
  const bool hex = options.hex || !base::is_utf8(message.bytes);
  const auto text = hex ? base::to_hex(base::as_bytes(message.bytes)) : printable(message.bytes);
  out.line(fmt::format("{}  {}  {}: {}", clock_text(session.now()), printable(sender_of(message)),
                       printable(message.type), text));
}

int receive(Session& session, const ReceiveOptions& options) {
  std::size_t received = 0;
  auto listening = session.client().on_message(options.type, [&](const client::UserMessage& message) {
    if (options.count > 0 && received >= options.count) return;
    ++received;
    show(session, message, options);
  });
  print_error(fmt::format("waiting as {} for messages {}", number(session.client().id()),
                          options.type.empty() ? "of every type" : "of type " + printable(options.type)));
  session.run([&] { return options.count > 0 && received >= options.count; },
              parse_duration_or(options.length, Duration::max()));
  // Gives the sender of the last message its acknowledgement before the program ends; later messages are refused.
  listening = {};
  if (received > 0) session.run([] { return false; }, kLastWords);
  return received == 0 && !session.interrupted() ? kNotThere : kGood;
}

}  // namespace

void add_receive(Cli& cli) {
  const auto options = std::make_shared<ReceiveOptions>();
  auto* app = cli.command({"receive", "Show the messages that others send to this program, line by line",
                           "  rubicon receive --type chat --name kitchen     # rubicon send kitchen --type chat hello\n"
                           "  rubicon receive --id 70001 --count 1 --for 10min --json\n"
                           "Exit code 8: no message came in the time of --for.\n"},
                          [options](const Settings& settings) {
                            const auto session = Session::open(options->as.applied(settings), "receive");
                            return session ? session->end(receive(*session, *options)) : static_cast<int>(kFailed);
                          });
  app->add_option("--type", options->type, "messages of this type only; of every type if not given");
  options->as.add_to(*app);
  add_duration_option(app, "--for", options->length, "end after this time");
  app->add_option("--count", options->count, "end after so many messages")->type_name("N")->check(CLI::PositiveNumber);
  auto* hex = app->add_flag("--hex", options->hex, "show the bytes in hex");
  app->add_flag("--raw", options->raw, "nothing but the bytes, as they came")->excludes(hex);
}

}  // namespace rubicon::cli
